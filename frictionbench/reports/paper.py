"""Files for a paper: figures at the widths of a two-column page, booktabs tables, captions and references, in DIR/paper/.

    \\input{speed_accuracy.pgf}                    a figure in the paper's own fonts, or \\includegraphics{speed_accuracy}
    \\input{times}                                 a table that fits its width
    \\caption{\\benchcaption{speed_accuracy}}       from captions.tex
    \\bibliography{references}

preview.tex is a document that shows all of them. The same tables always give the same files, byte for byte.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from shutil import which
from typing import NamedTuple

import numpy as np
import pandas as pd
from markupsafe import Markup

from frictionbench.reports import tables
from frictionbench.reports.accuracy import LEVELS, in_order, overall, percentiles, shown_levels
from frictionbench.reports.charts import CHARTS, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.files import BANDS, pages, save_panels, save_sheet
from frictionbench.reports.drawing.svg import in_file
from frictionbench.reports.drawing.text import count, percent, power, residual, seconds
from frictionbench.reports.drawing.tiles import Drawing, Text
from frictionbench.reports.latex import Cell, Layout, Table, Tex, bibliography, booktabs, cited, escaped, one_unit
from frictionbench.reports.run import PORTFOLIO, Run
from frictionbench.results.conventions import ENDINGS
from frictionbench.results.files import ResultsError, subfolder, write_text

FONT = 7  # points, in figures: the smallest size that journals accept
ASPECT, TALLEST = 0.75, 7.4  # height of a panel over its width; inches of a figure, which leaves room for its caption
MOST_IN_COLUMN, MOST_COLUMNS = 2, 3  # panels one above the other in a column of text; more stand side by side on the page
ON_PAGE_ONLY = ("Hover over", "Bands, ", "Below each panel")  # the beginnings of sentences that apply to the page only


class Float(NamedTuple):
    """A figure: the name of its files, its caption, and whether it takes the page's width."""

    name: str
    caption: str
    wide: bool


def write_paper(folder: Path, run: Run, layout: Layout | None = None, figures: Sequence[str] | None = None) -> Path:
    """Write figures as PDF, SVG and, if LaTeX is installed, PGF; tables, captions and references; return DIR/paper.

    figures: names of charts, None for all. A chart that is taller than a page is continued in further files, NAME_2 and so on.
    Errors: ResultsError naming a chart that does not exist.
    """
    layout = layout or Layout()
    paper = subfolder(folder, "paper")
    escape = escaped if which("pdflatex") else None
    run, floats = replace(run, printed=True), list[Float]()
    for chart in CHARTS if figures is None else [_chart(name) for name in figures]:
        found = chart.panels(run)[chart.in_paper]
        for drawing in (one for one in found if isinstance(one, Drawing)):
            wide = len(drawing.panels) > 1
            width = layout.page if wide else layout.column
            stem, caption = f"{chart.name}_{drawing.name}", f"{drawing.title.rstrip('.')}. {_caption(chart, run)}"
            write_text(paper / f"{stem}.svg", in_file(drawing))
            parts = pages(drawing, width, TALLEST)
            for one, part in zip(_floats(stem, caption, wide, len(parts)), parts, strict=True):
                save_panels(part, paper / one.name, width, layout.font, escape)
                floats.append(_marked(one, [shape.text for panel in part for shape in panel if isinstance(shape, Text)]))
        if panels := [one for one in found if isinstance(one, Panel)]:
            columns = max(chart.columns, MOST_COLUMNS) if len(panels) > MOST_IN_COLUMN else min(chart.columns, len(panels))
            width = (layout.column if columns == 1 else layout.page) / columns
            most = columns * int(TALLEST / (ASPECT * width))
            sheets = [panels[k : k + most] for k in range(0, len(panels), most)]
            for one, sheet in zip(_floats(chart.name, _caption(chart, run), columns > 1, len(sheets)), sheets, strict=True):
                size = width, ASPECT * width
                drawn = save_sheet(sheet, run.looks, paper / one.name, columns, size, FONT, layout.font, escape)
                floats.append(_marked(one, drawn))
    made = {name: make(run) for name, make in TABLES.items()}
    for name, table in made.items():
        write_text(paper / f"{name}.tex", table.text)
    words = {"by": f"{run.rank_by.words} ({run.rank_by.parts})", "target": power(run.outer_targets[-1])}
    captions = {name: CAPTIONS[name].format(**words) for name in made} | {one.name: one.caption for one in floats}
    write_text(paper / "captions.tex", captions_file(captions, _setting(run)))
    write_text(paper / "references.bib", bibliography({*run.rows["solver"], *run.simulations["solver"]}))
    write_text(paper / "preview.tex", preview(made, floats, layout))
    return paper


def _chart(name: str) -> Chart:
    for chart in CHARTS:
        if chart.name == name:
            return chart
    raise ResultsError(f"figures: there is no {name}; there are {', '.join(chart.name for chart in CHARTS)}")


def _floats(stem: str, caption: str, wide: bool, count: int) -> list[Float]:
    """The figures of a chart in `count` parts; those after the first are continued."""
    names = [stem, *(f"{stem}_{k}" for k in range(2, count + 1))]
    title = caption.partition(". ")[0].rstrip(".")
    return [Float(name, f"{title} (continued)." if k else caption, wide) for k, name in enumerate(names)]


def _caption(chart: Chart, run: Run) -> str:
    """The caption in print: the title, what the chart shows, and its bands."""
    title = f"{chart.title}, {run.rank_by.words} ({run.rank_by.parts})" if chart.ranked else chart.title
    caption = f"{title}. {_plain(chart.told(run))}".removeprefix(". ")
    if chart is profiles.CHART and len(run.looks) <= BANDS:
        caption += " Bands: 95 % bootstrap bands over the problems."
    return caption


def _marked(one: Float, names: Iterable[str]) -> Float:
    """The figure, its caption with the mark of portfolios explained where a name that is drawn has it."""
    told = " An asterisk marks a portfolio, which runs other solvers." * any(PORTFOLIO in name for name in names)
    return one._replace(caption=one.caption + told)


def of_scenes(run: Run, names: Collection[str]) -> Run:
    """The run restricted to some scenes, or classes of problems. Errors: ResultsError naming one that is not in the run."""
    there = {*run.rows["scene"], *run.rows["problem_class"], *run.simulations["scene"]}
    if missing := [name for name in names if name not in there]:
        raise ResultsError(f"scenes: {missing[0]} is not in this run; there are {', '.join(sorted(there))}")
    rows = run.rows[run.rows["scene"].isin(names) | run.rows["problem_class"].isin(names)]
    simulations = run.simulations[run.simulations["scene"].isin(names)]
    return replace(run, rows=rows, simulations=simulations)


def chosen(run: Run, names: Collection[str]) -> Run:
    """The run restricted to some solvers, given by name, variant or label.

    Errors: ResultsError naming a solver that is not in the run.
    """
    selected: set[str] = set()
    for name in names:
        found = {
            str(label)
            for table in (run.rows, run.simulations)
            for label in table.loc[
                (table["solver"] == name) | (table["variant"] == name) | (table["label"].str.removesuffix(PORTFOLIO) == name),
                "label",
            ]
        }
        if not found:
            there = ", ".join(sorted({*run.rows["variant"], *run.simulations["variant"]}))
            raise ResultsError(f"solvers: {name} is not in this run; there are {there}")
        selected |= found
    parts = {
        name: table[table["label"].isin(selected)] if len(table) else table
        for name, table in (("rows", run.rows), ("simulations", run.simulations), ("map_simulations", run.map_simulations))
    }
    return replace(run, **parts)


def _solvability(run: Run) -> Table:
    """The counts of verdicts per solver, without verdicts that do not occur."""
    rows = tables.solvability(run)
    columns = ["cells", "claimed", *(name for name in ENDINGS if rows[name].any())]
    body = [[row["label"], *(str(row[name]) for name in columns)] for row in rows.to_dict("records")]
    if rows["error"].notna().any():
        columns.append("error")
        for line, error in zip(body, rows["error"], strict=True):
            line.append("–" if np.isnan(error) else residual(error))
    return booktabs(["solver", *columns], body)


def _times(run: Run) -> Table:
    """Of all problems of the plane, then of space, the solvers with the largest share reached first."""
    ranking = [(where, *row) for where in run.overall for row in tables.ranking(run.summaries, where)]
    facts = {
        "solver": [label for _, label, _ in ranking],
        "where": [where for where, *_ in ranking] if len(run.overall) > 1 else [],
        "for": [rows[0]["law"] for *_, rows in ranking],
    }
    facts = {name: texts for name, texts in facts.items() if any(texts)}
    header, columns, groups = [*facts], [*facts.values()], [("", len(facts))]
    for i, target in enumerate(run.summaries):
        unit, means = one_unit([cells[i]["mean"] for *_, cells in ranking])
        header += ["reached", f"mean, {unit}"]
        groups.append((f"to {power(target)}", 2))
        columns += [[f"{cells[i]['reached']}/{cells[i]['problems']}" for *_, cells in ranking], means]
    return booktabs(header, list(zip(*columns, strict=True)), groups)


def _percentiles(run: Run) -> Table:
    """At the finest target, in the order of the mean."""
    body, places = [], []
    for where, times in overall(run.times[run.outer_targets[-1]]).items():
        table = in_order(percentiles(times, run.budget))
        places += [(where, label, row) for label, row in zip(table.index, table.to_dict("records"), strict=True)]
    levels = shown_levels(pd.DataFrame([row for *_, row in places], columns=[*LEVELS]))
    unit, shown = one_unit([row[name] for *_, row in places for name in levels])
    for i, (where, label, row) in enumerate(places):
        within = [] if run.budget is None else [percent(row["within"], 1)]
        body.append([label, where, *shown[len(levels) * i : len(levels) * (i + 1)], *within])
    budget = [] if run.budget is None else [f"within {seconds(run.budget)}"]
    return booktabs(["solver", "where", *(f"{name}, {unit}" for name in levels), *budget], body)


def _problems(run: Run) -> Table:
    classes = tables.problem_classes(run)
    body = [
        [
            row["problem_class"],
            f"{row['problems']:.0f}",
            f"{row['trivial'] + row['idle']:.0f}",
            _range(row, "contacts"),
            _range(row, "size"),
        ]
        for row in classes.to_dict("records")
    ]
    return booktabs(["class", "problems", "left out", "contacts", "unknowns"], body)


def _range(row: dict[str, float], what: str) -> str:
    low, high = row[f"{what}_from"], row[f"{what}_to"]
    return f"{low:.0f}" if low == high else f"{low:.0f}–{high:.0f}" if np.isfinite(low) else "–"


def _solvers(run: Run) -> Table:
    both = pd.concat([run.rows[["solver", "model"]], run.simulations[["solver"]]]).drop_duplicates("solver").fillna("")
    body: list[list[Cell]] = []
    for row in both.sort_values("solver").itertuples():
        keys = cited(row.solver)
        citation = Tex(rf"\cite{{{','.join(keys)}}}", f"[{', '.join('00' for _ in keys)}]") if keys else "–"
        body.append([row.solver, row.model, citation])
    return booktabs(["solver", "solves", "references"], body)


TABLES: dict[str, Callable[[Run], Table]] = {
    "solvability": _solvability,
    "times": _times,
    "percentiles": _percentiles,
    "problems": _problems,
    "solvers": _solvers,
}
CAPTIONS = {
    "solvability": "Verdicts of an independent verification, by solver; claimed: cells that the solver reports as solved; "
    "error: the median residual, by Coulomb's law, of answers to another law or with a polygon for the cone. Problems in which "
    "friction does not act are left out.",
    "times": "Problems brought within a verified residual of each target, and the weighted shifted geometric mean of the time "
    "{by}, problems not solved charged the time limit; for: what is solved in place of Coulomb's law.",
    "percentiles": "The times {by} within which half and, from a hundred on, 99 % of the problems, by weight, are solved to "
    "{target}, and the longest; a dash: not solved.",
    "problems": "Problems by class; left out: nothing to solve, or solved without friction; unknowns of the friction LCP.",
    "solvers": "Solvers, the model that each solves, and references.",
}


def _plain(caption: str) -> str:
    """A caption without markup and without the sentences that apply to the page only."""
    sentences = Markup(caption).striptags().replace(". ", ".\n").splitlines()
    return " ".join(sentence for sentence in sentences if not sentence.startswith(ON_PAGE_ONLY))


def _setting(run: Run) -> str:
    """The suite and the machine of the run, in a sentence."""
    machine = run.manifest.get("machine")
    processor = f", one thread of {machine['processor']}" if isinstance(machine, dict) and "processor" in machine else ""
    problems = run.ranked["problem_id"].nunique()
    return f"Suite {run.manifest['settings'].get('suite', 'unnamed')}, {count(problems, 'problem')}{processor}."


def captions_file(captions: Mapping[str, str], setting: str) -> str:
    """captions.tex: the captions by the names of their tables and figures, and the setting."""
    lines = [
        r"% \input{captions}, then \caption{\benchcaption{times}} and, where and on what it was made, \benchsetting",
        r"\newcommand{\benchcaption}[1]{\csname benchcaption@#1\endcsname}",
        rf"\newcommand{{\benchsetting}}{{{escaped(setting)}}}",
    ]
    for name, caption in captions.items():
        lines.append(rf"\expandafter\def\csname benchcaption@{_label(name)}\endcsname{{{escaped(caption)}}}")
    return "\n".join([*lines, ""])


def _label(name: str) -> str:
    return "".join(c for c in name if c.isalnum() or c in "_-")


def preview(made: Mapping[str, Table], figures: Sequence[Float], layout: Layout) -> str:
    """preview.tex: a document with all tables and figures."""
    body = [_float("table", name, table.wide, rf"\input{{{name}}}") for name, table in made.items()]
    for name, _, wide in figures:
        drawn = rf"\IfFileExists{{{name}.pgf}}{{\input{{{name}.pgf}}}}{{\includegraphics{{{name}.pdf}}}}"
        body.append(_float("figure", name, wide, drawn))
    family = [r"\renewcommand{\familydefault}{\sfdefault}"] if layout.font == "sans" else []
    return "\n".join([
        r"% pdflatex preview; bibtex preview; pdflatex preview; pdflatex preview",
        r"% Packages: geometry, booktabs, graphicx, pgf, url, and lmodern if it is there; in Debian and Ubuntu",
        r"% texlive-latex-recommended, texlive-pictures and lmodern.",
        r"\documentclass[twocolumn]{article}",
        rf"\usepackage[textwidth={layout.page:.3f}in,columnsep={layout.gap}in,textheight=9.5in]{{geometry}}",
        r"\usepackage[T1]{fontenc}", r"\IfFileExists{lmodern.sty}{\usepackage{lmodern}}{}", *family,
        r"\usepackage{booktabs,graphicx,pgf,url}", r"\input{captions}",
        r"\begin{document}", r"\nocite{*}", *body,
        r"\bibliographystyle{plain}", r"\bibliography{references}", r"\end{document}", "",
    ])  # fmt: skip


def _float(kind: str, name: str, wide: bool, content: str) -> str:
    star = "*" * wide
    caption = rf"\caption{{\benchcaption{{{_label(name)}}} \benchsetting}}\label{{{kind}:{_label(name)}}}"
    parts = (rf"\begin{{{kind}{star}}}", r"\centering", content, caption, rf"\end{{{kind}{star}}}", r"\clearpage")
    return "\n".join(parts)
