"""The directive `public-face`: all names of `import frictionbench as fb` from their docstrings, by autodoc.

Docstrings are plain text: paragraphs, indented tables, names in single backticks and examples. Paragraphs are escaped for
reStructuredText, indented ones become literal blocks.
"""

import inspect
import re
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

import frictionbench as fb

MODULES = ("capture", "mujoco", "plot")
ARRAY = re.compile(r"ndarray\[~?(?:\w+\.)*tuple\[[^]]*\], ~?(?:\w+\.)*dtype\[[^]]*\]\]")


class PublicFace(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        return [self.section(name) for name in fb.__all__ if name != "__version__"]

    def section(self, name: str) -> nodes.section:
        found = nodes.section(ids=[f"fb-{name}"], names=[f"fb-{name}"])
        found += nodes.title(text=name)
        kind = "module" if name in MODULES else "class" if inspect.isclass(getattr(fb, name)) else "function"
        members = ["   :members:"] if kind == "module" else []
        lines = ["```{eval-rst}", f".. auto{kind}:: frictionbench.{name}", *members, "```"]
        self.state.nested_parse(StringList(lines, "public face"), self.content_offset, found)
        return found


def plain(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    paragraphs = re.split(r"\n\s*\n", "\n".join(lines).strip("\n"))
    lines[:] = [*"\n\n".join(map(as_rst, paragraphs)).splitlines(), ""]


def short(app: Any, what: str, name: str, thing: Any, options: Any, *signature: str | None) -> tuple[str | None, ...]:
    """Name arrays without their parameters. A default factory is no Python, and Sphinx would show the rest as raw text."""
    return tuple(text and ARRAY.sub("ndarray", text).replace("<factory>", "...") for text in signature)


def as_rst(paragraph: str) -> str:
    if paragraph.lstrip().startswith(">>>"):
        return paragraph
    if paragraph.startswith(" ") or "\n  " in paragraph:
        return "::\n\n" + "\n".join("    " + line for line in paragraph.splitlines())
    parts = re.split(r"(`[^`]+`)", paragraph)
    return "".join(f"`{part}`" if part.startswith("`") else re.sub(r"([*|_\\])", r"\\\1", part) for part in parts)


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("public-face", PublicFace)
    app.connect("autodoc-process-docstring", plain)
    app.connect("autodoc-process-signature", short)
    return {"parallel_read_safe": True}
