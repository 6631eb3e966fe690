"""The directive `code-cell` of MyST notebooks, executed when the site is built, without a kernel or a server.

The cells of a page share their names. Below a cell stand what it printed, the value of its last line, and the figures that it
drew with pyplot. A cell that fails ends the build. jupytext opens the same pages as notebooks.
"""

import ast
import re
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective


def code_cells(page: str) -> list[str]:
    """The code of the cells of a page."""
    return re.findall(r"^```\{code-cell\}[^\n]*\n(.*?)^```", page, re.MULTILINE | re.DOTALL)


def run_cell(code: str, names: dict[str, Any], folder: str) -> str:
    """Execute a cell in a folder; return what it printed, and the value of its last line unless that is None."""
    tree, printed = ast.parse(code), StringIO()
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with redirect_stdout(printed), chdir(folder):
        exec(compile(tree, "cell", "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
            if value is not None:
                print(value)
    return printed.getvalue().rstrip()


class CodeCell(SphinxDirective):
    has_content = True
    optional_arguments = 1  # the language, which jupytext writes

    def run(self) -> list[nodes.Node]:
        import matplotlib as mpl

        mpl.use("Agg")
        from matplotlib import pyplot

        names = self.env.temp_data.setdefault("names of cells", {})
        folder = self.env.temp_data.setdefault("folder of cells", mkdtemp())
        code = "\n".join(self.content)
        output = run_cell(code, names, folder)
        content: list[nodes.Node] = [nodes.literal_block(text=code, language="python")]
        if output:
            content.append(nodes.literal_block(text=output, language="text", classes=["output"]))
        content += [self.image(pyplot.figure(number)) for number in pyplot.get_fignums()]
        pyplot.close("all")
        return content

    def image(self, figure: Any) -> nodes.Node:
        home = Path(self.env.srcdir) / "_build" / "cells"
        home.mkdir(parents=True, exist_ok=True)
        count = self.env.new_serialno("figure of cells")
        name = f"{self.env.docname.replace('/', '-')}-{count}.svg"
        figure.savefig(home / name, metadata={"Date": None})
        return nodes.image(uri=f"/_build/cells/{name}", alt="The figure that the cell draws")


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("code-cell", CodeCell)
    return {"parallel_read_safe": True}
