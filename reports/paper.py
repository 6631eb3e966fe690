"""For a paper: vector figures at the widths of a two-column page and LaTeX tables (booktabs), in DIR/paper/.

\\includegraphics{speed_accuracy}      \\input{times}
"""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from reports import energy, growth, profiles, speed_accuracy, tables
from reports.accuracy import ALL, TARGETS, summary, times_to
from reports.cells import annotate, annotate_drives, contested, entrants
from reports.figures import save_sheet
from reports.style import looks, power, seconds
from results.store import read_manifest, read_table

COLUMN, PAGE = 3.35, 7.0  # inches: one column, both
FONT = 7  # points
_SPECIAL = str.maketrans({
    **{sign: "\\" + sign for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}",
    ">": r"\textgreater{}",
    "[": "{[}", "]": "{]}", "µ": r"\textmu{}", "–": "--",
})  # fmt: skip


def write_paper(folder: Path) -> Path:
    """Write figures as PDF and SVG and tables as LaTeX from the tables in DIR; return DIR/paper.

    Errors: results.store.ResultsError where DIR is not a results folder or a table cannot be read.
    """
    read_manifest(folder)
    rows = annotate(read_table(folder, "solves"))
    drives = annotate_drives(read_table(folder, "drives"))
    times = {target: times_to(contested(rows), target) for target in TARGETS}
    look = looks(entrants(rows) + entrants(drives))
    paper = folder / "paper"
    paper.mkdir(exist_ok=True)
    for name, panels, columns, width in (
        ("speed_accuracy", speed_accuracy.panels(rows, look), 3, PAGE),
        ("profiles", profiles.panels({target: times[target] for target in (TARGETS[0], TARGETS[-1])}, look), 1, COLUMN),
        ("growth", growth.panels(rows, look, TARGETS[1]), 1, COLUMN),
        ("energy", energy.panels(drives, look), 3, PAGE),
    ):
        if panels:
            size = (width / columns, 0.75 * width / columns)
            save_sheet(panels, look, paper / name, columns=columns, size=size, font=FONT)
    for name, text in (
        ("solvability", _solvability(tables.solvability(rows))),
        ("times", _times({target: summary(table) for target, table in times.items()})),
        ("classes", _classes(tables.problem_classes(rows))),
    ):
        (paper / f"{name}.tex").write_text(text, encoding="utf-8")
    return paper


def _solvability(table: pd.DataFrame) -> str:
    columns = ["cells", "claimed", *tables.OUTCOMES]
    body = [[row["entry"], *(str(row[column]) for column in columns)] for row in table.to_dict("records")]
    return booktabs(["solver", *columns], body)


def _times(summaries: dict[float, pd.DataFrame]) -> str:
    overall = {target: table[table["problem_class"] == ALL].set_index("entry") for target, table in summaries.items()}
    order = overall[min(overall)].sort_values(["reached", "mean"], ascending=[False, True]).index
    body = []
    for entry in order:
        rows = [table.loc[entry] for table in overall.values()]
        body.append([entry, *(text for row in rows for text in (f"{row['reached']}/{row['problems']}", seconds(row["mean"])))])
    return booktabs(["solver", *(text for target in overall for text in (f"to {power(target)}", "mean"))], body)


def _classes(table: pd.DataFrame) -> str:
    columns = ["problems", "trivial", "contacts_from", "contacts_to", "size_from", "size_to"]
    body = [[row["problem_class"], *(f"{row[column]:.0f}" for column in columns)] for row in table.to_dict("records")]
    return booktabs(["class", "problems", "trivial", "contacts from", "to", "unknowns from", "to"], body)


def booktabs(header: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    """A tabular of plain texts: the first column to the left, the others to the right."""
    lines = [" & ".join(text.translate(_SPECIAL) for text in row) + r" \\" for row in (header, *body)]
    inner = [lines[0], r"\midrule", *lines[1:]]
    return "\n".join(
        [rf"\begin{{tabular}}{{l{'r' * (len(header) - 1)}}}", r"\toprule", *inner, r"\bottomrule", r"\end{tabular}", ""]
    )
