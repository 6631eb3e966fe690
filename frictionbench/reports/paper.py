"""Files for a paper: figures of one width, booktabs tables, captions and references, in DIR/paper/.

The same tables always give the same files, byte for byte.
"""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from markupsafe import Markup

from frictionbench.reports.charts import CHARTS
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.choice import disturbed
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.files import NO_HANDLES, legend_size, save_sheet
from frictionbench.reports.drawing.text import plain
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.latex import ESCAPED, bibliography, escaped
from frictionbench.reports.printed import REFERENCES, Table, printed
from frictionbench.reports.run import PORTFOLIO, Run
from frictionbench.reports.tables import asked, revision, setting
from frictionbench.results.files import ResultsError, read_text, subfolder, write_text

LARGEST_CAPTIONS = 2**20  # bytes of a file of captions: room for about a thousand
FONT = 7  # points, in figures: the smallest size that journals accept
ASPECT, TALLEST = 0.75, 5.6  # height of a panel over its width; inches of panels and legend, on a page of 7.6 with a caption
SHRUNK = 0.3  # if this share of a panel's height is lacking for one more row, all rows are made lower, by less than a quarter
NARROWEST, MOST_COLUMNS = 1.6, 3  # least width of a panel, inches; most panels side by side
LETTERS = 75  # letters in a row that fit into one column of text; a table with longer rows takes the width of the page
CITED = 4  # letters of a citation by number
ON_PAGE_ONLY = ("Hover over", "Below each panel", "One map per scene")  # how sentences begin that apply to the page only
RESTRICTED = {"scenes": ["scene", "problem_class"], "solvers": ["variant", "solver", "label"]}  # columns with their names
# Shrinks a table that is wider than the text; \width is graphicx's name for the natural width of the box.
FIT = r"\smallskip\noindent\footnotesize\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"


def write_paper(folder: Path, run: Run, figures: Iterable[str] | None = None, width: float = 3.35, font: str = "serif") -> Path:
    """Write figures as PDF and SVG, tables, captions and references; return DIR/paper.

    figures: some of chart_names(), None for all. width: of every figure, inches. font: serif or sans. A chart that is taller
    than a page is continued in further files, NAME_2 and so on. Captions and settings of earlier calls' figures are kept.
    """
    paper = subfolder(folder, "paper")
    captions: dict[str, str] = {}
    for name in CHARTS if figures is None else figures:
        captions |= _save_chart(CHARTS[name], run, paper, width, font)
    made = printed(run)
    for table in made:
        write_text(paper / f"{table.name}.tex", booktabs(table))
    captions = {table.name: table.caption for table in made} | captions
    write_text(paper / "captions.tex", captions_file(captions, f"{setting(run)} {disturbed(run, leads=False)}".rstrip(), paper))
    solvers = [*run.rows["solver"], *run.simulations["solver"], *run.portfolios.values()]
    write_text(paper / "references.bib", bibliography(set(", ".join(solvers).split(", ")), revision(run.manifest)))
    return paper


def chart_names(run: Run, names: Sequence[str] | None = None) -> Sequence[str]:
    """Check the names of charts, None for all, and return them. Errors: ResultsError naming one that the run lacks."""
    if missing := [name for name in names or () if name not in CHARTS or not CHARTS[name].panels(run)]:
        there = [name for name, chart in CHARTS.items() if chart.panels(run)]
        raise ResultsError(
            f"figures: there is no figure {missing[0]} (tables are always written); there are {', '.join(there)}"
        )
    return names or [*CHARTS]


def _save_chart(chart: Chart, run: Run, paper: Path, width: float, font: str) -> dict[str, str]:
    """Save the figures of a chart, one with all panels or one for each map, each in parts that fit on a page. Return the
    captions by the files' names."""
    drawings, captions, caption = chart.panels(run), dict[str, str](), _caption(chart, run)
    # Of each figure the file, the caption, the panels and the legend's entries.
    figures = [(chart.name, caption, [one for one in drawings if isinstance(one, Panel)], NO_HANDLES)]
    for one in drawings:
        if isinstance(one, Drawing):
            text = f"{one.title.rstrip('.')}. {one.note} {caption}"
            figures.append((f"{chart.name}_{one.name}", text, one.panels, one.handles))
    for stem, text, panels, handles in figures:
        columns = max(1, min(MOST_COLUMNS, len(panels), int(width / NARROWEST)))
        height = ASPECT * width / columns
        room = TALLEST - legend_size([plain(name) for name in run.looks], width, FONT)[1]
        rows = max(1, min(-(-len(panels) // columns), int(room / height + SHRUNK)))
        size, most = (width / columns, min(height, max(room, NARROWEST) / rows)), columns * rows
        title = text.partition(". ")[0].rstrip(".")
        for k in range(0, len(panels), most):
            name, part = f"{stem}_{k // most + 1}" if k else stem, panels[k : k + most]
            named = save_sheet(part, run.looks, paper / name, columns, size, FONT, font, handles=handles)
            continued = f"{title}, continued ({k // most + 1} of {-(-len(panels) // most)})." if k else text
            marked = any(PORTFOLIO in text for text in (continued, *named, *(panel.title for panel in part)))
            captions[name] = continued + " An asterisk marks a portfolio, which runs other solvers." * marked
        for earlier in paper.glob(f"{stem}_*.*"):  # further parts of an earlier call, whose figures were smaller or narrower
            if re.fullmatch(rf"{re.escape(stem)}_\d+", earlier.stem) and earlier.stem not in captions:
                earlier.unlink()
    return captions


def _caption(chart: Chart, run: Run) -> str:
    """Return the caption in print: the title and the chart's caption, without markup and sentences on the page only."""
    title = f"{chart.title}, {run.rank_by.words} ({run.rank_by.parts})" if chart.ranked else chart.title
    sentences = Markup(chart.caption).striptags().replace(". ", ".\n").splitlines()
    printed_ones = (sentence for sentence in sentences if not sentence.startswith(ON_PAGE_ONLY))
    return f"{title}. {' '.join(printed_ones)}{f' {asked(run)}' * chart.ranked}".removeprefix(". ")


def restricted(run: Run, what: str, names: Collection[str]) -> Run:
    """Return the run with only the named scenes or solvers. what: a key of RESTRICTED. Errors: ResultsError for other names."""
    tables = {name: getattr(run, name) for name in ("rows", "simulations", "map_simulations")}
    named = {name: table.reindex(columns=RESTRICTED[what]) for name, table in tables.items()}
    there = {str(text) for table in named.values() for text in table.stack().dropna()}
    if missing := [name for name in names if name not in there]:
        raise ResultsError(f"{what}: {missing[0]} is not in this run; there are {'; '.join(sorted(there))}")
    settings = dict(run.manifest["settings"])
    settings["suite"] = f"{settings.get('suite', 'unnamed')}; only {what} {', '.join(names)}"
    kept = {name: table[named[name].isin(list(names)).any(axis=1)] for name, table in tables.items()}
    return replace(run, manifest=run.manifest | {"settings": settings}, **kept)


def booktabs(table: Table) -> str:
    """Return a tabular with columns of words aligned left and of numbers right, for documents with booktabs and graphicx."""
    sides, widths, body = [], [], []  # by column
    for head, *cells in zip(table.header, *table.rows, strict=True):
        cited = head == REFERENCES
        sides.append("r" if any(cell[:1].isdigit() for cell in cells) else "l")
        widths.append(max(len(head), *(CITED * (1 + cell.count(",")) if cited else len(cell) for cell in cells)))
        body.append([rf"\cite{{{cell}}}" if cited and cell.isascii() else escaped(cell) for cell in cells])
    lines = [" & ".join(row) + r" \\" for row in (map(escaped, table.header), *zip(*body, strict=True))]
    wide = sum(widths) + 2 * len(widths) > LETTERS
    return "\n".join([
        f"% {'both columns, table*' if wide else 'one column, table'}",
        rf"{{{FIT}",
        rf"\begin{{tabular}}{{@{{}}l{''.join(sides[1:])}@{{}}}}",
        *(r"\toprule", lines[0], r"\midrule", *lines[1:], r"\bottomrule", r"\end{tabular}}\par}", ""),
    ])  # fmt: skip


def captions_file(captions: Mapping[str, str], setting: str, paper: Path) -> str:
    """Return captions.tex: captions and the setting by table and figure, and earlier ones, without commands, of files there."""
    file, line = paper / "captions.tex", rf"^(\\expandafter\\def\\csname (bench\w+@\w+)\\endcsname\{{{ESCAPED}\}})$"
    earlier = read_text(file, LARGEST_CAPTIONS) if file.exists() else ""
    there = {path.stem for path in paper.iterdir()}
    named = {key: text for text, key in re.findall(line, earlier, re.MULTILINE) if key.partition("@")[2] in there}
    lines = [
        r"% \input{captions}, then \caption{\benchcaption{times}} and, in the text, on what it was made: \benchsetting{times}",
        r"\newcommand{\benchcaption}[1]{\benchtext{benchcaption@#1}{#1}}",
        r"\newcommand{\benchsetting}[1]{\benchtext{benchsetting@#1}{#1}}",
        r"\newcommand{\benchtext}[2]{\ifcsname #1\endcsname\csname #1\endcsname\else"
        r"\PackageError{frictionbench}{captions.tex has no #2}{It has the names of the figures and tables beside it.}\fi}",
    ]
    for name, caption in captions.items():
        for key, text in ((f"benchcaption@{name}", caption), (f"benchsetting@{name}", setting)):
            named[key] = rf"\expandafter\def\csname {key}\endcsname{{{escaped(text)}}}"
    return "\n".join([*lines, *named.values(), ""])
