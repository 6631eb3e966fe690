"""The finished studies of a folder: DIR/studies.html, DIR/studies.md with its figures in DIR/studies, and files for a paper.

Everything is made from the studies' tables; the same tables give the same files, byte for byte.
"""

from collections.abc import Mapping
from pathlib import Path
from shutil import which
from typing import NamedTuple

from frictionbench.reports.drawing.files import save_sheet
from frictionbench.reports.drawing.text import escaped as in_markdown
from frictionbench.reports.latex import Layout, bibliography, escaped
from frictionbench.reports.paper import ASPECT, FONT, Float, captions_file, preview
from frictionbench.reports.studies import ACCOUNTS, Account
from frictionbench.reports.templates import environment
from frictionbench.results.files import subfolder, write_text
from frictionbench.results.studies import Description, finished, read_study

FIGURES = "studies"  # the folder of the figures that DIR/studies.md shows
PANEL = (3.4, 2.5)  # inches, there


class Told(NamedTuple):
    """A study and its account."""

    about: Description
    account: Account


def told(folder: Path) -> list[Told]:
    """The finished studies in the order of ACCOUNTS. Errors: ResultsError where a table contradicts an account."""
    found = [read_study(folder, name) for name in ACCOUNTS if finished(folder, name)]
    return [Told(tables.about, ACCOUNTS[tables.about.name](tables)) for tables in found]


def write_studies(folder: Path) -> Path:
    """Write DIR/studies.html and DIR/studies.md with its figures; the path of the page."""
    found, page = told(folder), folder / "studies.html"
    write_text(page, environment().get_template("studies.html").render(studies=found))
    figures = subfolder(folder, FIGURES)
    for about, account in found:
        for figure in account.figures:
            stem = figures / f"{about.name}_{figure.name}"
            save_sheet(figure.panels, dict(figure.looks), stem, figure.columns, PANEL, 8, kinds=("svg",), paper="white")
    write_text(folder / "studies.md", markdown(found))
    return page


def markdown(found: list[Told]) -> str:
    """The studies in Markdown: the answers in a table, then each study."""
    lines = [
        "# Studies",
        "",
        "Open questions of the field, answered by computed tables. Made by `make studies`, which runs `frictionbench study "
        "all`; sentences and figures are written from the tables, and a claim that they do not hold is refused. Intervals are "
        "of 95 %.",
        "",
        "| question | answer |",
        "|---|---|",
        *(f"| [{about.question}](#{about.name}) | {in_markdown(account.answer)} |" for about, account in found),
    ]
    for about, account in found:
        answer, result, limits = map(in_markdown, (account.answer, account.result, account.limits))
        lines += ["", f"## {about.name}", "", f"**{about.question}** {answer}", ""]
        lines += [f"*Method.* {in_markdown(about.method)}", "", f"*Result.* {result}", ""]
        if account.table:
            heads, *rows = ([in_markdown(cell) for cell in row] for row in account.table)
            lines += [f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows)] + [""]
        for figure in account.figures:
            caption = in_markdown(figure.caption)
            lines += [f"![{caption}]({FIGURES}/{about.name}_{figure.name}.svg)", "", caption, ""]
        lines += [f"*What it does not show.* {limits}", "", f"    frictionbench study {about.name}"]
    return "\n".join([*lines, ""])


def write_paper(folder: Path, layout: Layout) -> Path:
    """Write each figure as PDF, SVG and, if LaTeX is installed, PGF, with captions and a preview, to DIR/paper."""
    paper, escape = subfolder(folder, "paper"), escaped if which("pdflatex") else None
    floats: dict[str, Float] = {}
    for about, account in told(folder):
        for figure in account.figures:
            one = Float(
                f"{about.name}_{figure.name}", f"{about.question} {figure.caption}", min(figure.columns, len(figure.panels)) > 1
            )
            width = (layout.page if one.wide else layout.column) / min(figure.columns, len(figure.panels))
            size = width, ASPECT * width
            save_sheet(figure.panels, dict(figure.looks), paper / one.name, figure.columns, size, FONT, layout.font, escape)
            floats[one.name] = one
    captions: Mapping[str, str] = {name: one.caption for name, one in floats.items()}
    write_text(paper / "captions.tex", captions_file(captions, "Computed by frictionbench study."))
    write_text(paper / "references.bib", bibliography(()))
    write_text(paper / "preview.tex", preview({}, list(floats.values()), layout))
    return paper
