"""Where lines may end: not within an option of a command, nor within a number or date of a table (wrap.css).

A name in a table, such as siconos[method=friction_3d_prox,settings=tuned], may be broken after its commas, bars and bracket.
"""

import re
from typing import Any

BLOCK, OPTION = re.compile(r"<(pre|code)\b.*?</\1>", re.DOTALL), re.compile(r"(?<![^\s\[(>])--?[a-z][\w-]*")
CELL, TEXT = re.compile(r"<t[dh]\b.*?</t[dh]>", re.DOTALL), re.compile(r"(?<=>)[^<>]+(?=<)")
NUMBER = re.compile(r"(?<![\w.=])(?:± )?-?\d[\d.,]*(?:e[-+]?\d+(?: /)?| (?:[µmnk]?s|%)(?!\w)|-\d\d-\d\d)")
NAME = re.compile(r"\w+\[[^\]\s]+\]")


def keep_options(app: Any, name: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    def block(found: re.Match[str]) -> str:
        return OPTION.sub(r'<span class="unbroken">\g<0></span>', found[0])

    def text(found: re.Match[str]) -> str:
        kept = NUMBER.sub(r'<span class="unbroken">\g<0></span>', found[0])
        return NAME.sub(lambda name: re.sub(r"[\[,_]", r"\g<0><wbr>", name[0]), kept)

    def cell(found: re.Match[str]) -> str:
        return TEXT.sub(text, found[0])

    context["body"] = CELL.sub(cell, BLOCK.sub(block, context.get("body", "")))


def setup(app: Any) -> dict[str, bool]:
    app.connect("html-page-context", keep_options)
    return {"parallel_read_safe": True}
