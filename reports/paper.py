"""For a paper: vector figures at the widths of a two-column page and LaTeX tables (booktabs), in DIR/paper/.

\\includegraphics{speed_accuracy}      \\input{times}
"""

from collections.abc import Sequence
from pathlib import Path

from reports import tables
from reports.charts import CHARTS
from reports.drawing.figures import Panel, save_sheet
from reports.drawing.text import power, seconds
from reports.drawing.tiles import Drawing, in_file
from reports.run import Run, read_run
from results.files import room, write_text

COLUMN, PAGE = 3.35, 7.0  # inches: one column, both
FONT = 7  # points
_SPECIAL = str.maketrans({
    **{sign: "\\" + sign for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}",
    "[": "{[}", "]": "{]}", "µ": r"\textmu{}", "–": "--",
})  # fmt: skip


def write_paper(folder: Path) -> Path:
    """Write figures as PDF and SVG, maps as SVG and tables as LaTeX from the tables in DIR; return DIR/paper.

    Errors: results.store.ResultsError where DIR is not a results folder or a table cannot be read.
    """
    run = read_run(folder)
    paper = room(folder, "paper")
    for chart in CHARTS:
        found = chart.panels(run)[chart.in_paper]
        for drawing in (one for one in found if isinstance(one, Drawing)):
            write_text(paper / f"{chart.name}_{drawing.name}.svg", in_file(drawing))
        if panels := [one for one in found if isinstance(one, Panel)]:
            width = (COLUMN if chart.columns == 1 else PAGE) / chart.columns
            save_sheet(panels, run.looks, paper / chart.name, chart.columns, size=(width, 0.75 * width), font=FONT)
    for name, table in (("solvability", _solvability), ("times", _times), ("classes", _classes)):
        write_text(paper / f"{name}.tex", table(run))
    return paper


def _solvability(run: Run) -> str:
    columns = ["cells", "claimed", *tables.OUTCOMES]
    rows = tables.solvability(run).to_dict("records")
    return booktabs(["solver", *columns], [[row["entry"], *(str(row[column]) for column in columns)] for row in rows])


def _times(run: Run) -> str:
    header = [text for target in run.summaries for text in (f"to {power(target)}", "mean")]
    body = [
        [entry, *(text for cell in cells for text in (f"{cell['reached']}/{cell['problems']}", seconds(cell["mean"])))]
        for entry, cells in tables.race(run.summaries)
    ]
    return booktabs(["solver", *header], body)


def _classes(run: Run) -> str:
    columns = ["problems", "trivial", "contacts_from", "contacts_to", "size_from", "size_to"]
    rows = tables.problem_classes(run).to_dict("records")
    body = [[row["problem_class"], *(f"{row[column]:.0f}" for column in columns)] for row in rows]
    return booktabs(["class", "problems", "trivial", "contacts from", "to", "unknowns from", "to"], body)


def booktabs(header: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    """A tabular of plain texts: the first column to the left, the others to the right."""
    lines = [" & ".join(text.translate(_SPECIAL) for text in row) + r" \\" for row in (header, *body)]
    inner = [lines[0], r"\midrule", *lines[1:]]
    return "\n".join(
        [rf"\begin{{tabular}}{{l{'r' * (len(header) - 1)}}}", r"\toprule", *inner, r"\bottomrule", r"\end{tabular}", ""]
    )
