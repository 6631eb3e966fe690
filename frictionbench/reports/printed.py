"""The tables of a run in print, as LaTeX in a paper and as Markdown in `report.md`: each has a header, rows and a caption.

A caption explains only the columns that its table has.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports import tables
from frictionbench.reports.accuracy import LEVELS, in_order, overall, percentiles, shown_levels
from frictionbench.reports.choice import DRAWS, Choice, Kind, choices
from frictionbench.reports.drawing.text import percent, power, ratio, residual, seconds
from frictionbench.reports.latex import cited
from frictionbench.reports.run import PORTFOLIO, Run
from frictionbench.results.conventions import ENDINGS

REFERENCES = "references"
MODELS = {"coulomb": "Coulomb's law", "lcp": "LCP"}  # names of models in print that differ from those in tables


class Table(NamedTuple):
    """A table of text. A column with the head REFERENCES has keys of the bibliography, separated by commas."""

    name: str
    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]


def printed(run: Run) -> list[Table]:
    """Return all tables that have rows."""
    return [table for make in TABLES for table in make(run) if table.rows]


def _choice(run: Run) -> list[Table]:
    """For each kind of problem, the solvers with the least mean at the tightest target, among all and among outside ones."""
    target = run.outer_targets[-1]
    theirs = {kind.name: kind.choices.get(target) for kind in choices(run, run.outside)}
    rows = [_first(kind, one, theirs.get(kind.name)) for kind in choices(run) if (one := kind.choices.get(target))]
    outside = ["outside"] * any(row[-1] != "–" for row in rows)
    caption = (
        f"Of the solvers compared, that with the least mean time {run.rank_by.words} ({run.rank_by.parts}) to "
        f"{power(target)}, problems not solved or not run charged the time limit; its lead over the next, with the 95 % "
        f"interval over {DRAWS} resamples of scenes, problems and repeats, of which a lower end of 1.00 or less names no winner"
        f"{'; and the first of the outside libraries that has a mean' if outside else ''}."
    )
    caption += " One outcome: no answers with several velocities are known." * any("one outcome" in row[0] for row in rows)
    caption += " Unjudgeable: rounding leaves open whether it is solved." * any("unjudgeable" in row[-2] for row in rows)
    header = ["kind of problem", "problems", "first", "mean", "lead", "interval", "solved", *outside]
    return [Table("choice", caption, header, [row[: len(header)] for row in rows])]


def _first(kind: Kind, choice: Choice, outside: Choice | None) -> list[str]:
    best, theirs = choice.places[0], outside and outside.places[0]
    ends = " to ".join(map(ratio, choice.interval)) if choice.lead and choice.interval else ""
    return [
        kind.name,
        str(kind.problems),
        best.label + (f" ({best.law})" if best.law else ""),
        seconds(best.mean, 3),
        ratio(choice.lead) if choice.lead else "–",
        ", ".join(filter(None, (ends, choice.unclear))) or "–",
        best.solved + _not_run(best.skipped),
        f"{theirs.label} {seconds(theirs.mean, 3)}{_not_run(theirs.skipped)}" if theirs and np.isfinite(theirs.mean) else "–",
    ]


def _not_run(skipped: int) -> str:
    """Return the number of problems that a solver does not take, which are charged the time limit, or an empty text."""
    return f", {skipped:.0f} not run" if skipped else ""


def _times(run: Run) -> list[Table]:
    """The solvers on all problems in the plane, then in space, those with the largest share solved first."""
    ranking = [(where, *row) for where in run.overall for row in tables.ranking(run.summaries, where)]
    facts = {
        "solver": [label for _, label, _ in ranking],
        "where": [where for where, *_ in ranking] if len(run.overall) > 1 else [],
        "law": [rows[0]["law"] for *_, rows in ranking],
    }
    facts = {name: texts for name, texts in facts.items() if any(texts)}
    header, columns = [*facts], [*facts.values()]
    for i, target in enumerate(run.summaries):
        header += [f"to {power(target)}", "mean"]
        columns.append([f"{rows[i]['reached']}/{rows[i]['problems']}{_not_run(rows[i]['skipped'])}" for *_, rows in ranking])
        columns.append([seconds(rows[i]["mean"], 3) for *_, rows in ranking])
    caption = (
        "Problems brought within a verified residual of each target, and the weighted shifted geometric mean of the time "
        f"{run.rank_by.words} ({run.rank_by.parts}), problems not solved or not run charged the time limit. {tables.asked(run)}"
    )
    if "law" in facts:
        caption += " Law: what is solved in place of Coulomb's law; a mean is then given only if every problem is solved."
    return [Table("times", caption, header, list(zip(*columns, strict=True)))]


def _percentiles(run: Run) -> list[Table]:
    """Percentiles at the tightest target, sorted by p99."""
    places = []
    for where, times in overall(run.times[run.outer_targets[-1]]).items():
        table = in_order(percentiles(times, run.budget))
        places += [(where, str(label), row) for label, row in zip(table.index, table.to_dict("records"), strict=True)]
    levels = shown_levels(pd.DataFrame([row for *_, row in places], columns=[*LEVELS]))
    budget = [] if run.budget is None else [f"within {seconds(run.budget)}"]
    rows = [
        [label, where, *(seconds(row[name], 3) for name in levels), *([percent(row["within"], 1)] if budget else [])]
        for where, label, row in places
    ]
    shares = ", ".join({"p50": "half", "p99": "99 %", "worst": "all"}[name] for name in levels)
    caption = (
        f"The times {run.rank_by.words} ({run.rank_by.parts}) within which {' and '.join(shares.rsplit(', ', 1))} of the "
        f"problems, by weight, are solved to {power(run.outer_targets[-1])}; a dash: not solved."
    )
    return [Table("percentiles", caption, ["solver", "where", *levels, *budget], rows)]


def _solvability(run: Run) -> list[Table]:
    """The numbers of verdicts per solver, without verdicts that do not occur."""
    counted = tables.solvability(run)
    columns = ["cells", "claimed", *(name for name in ENDINGS if counted[name].any())]
    with_error = bool(counted["error"].notna().any())
    rows = [
        [row["label"], *(str(row[name]) for name in columns)]
        + ([residual(row["error"]) if np.isfinite(row["error"]) else "–"] if with_error else [])
        for row in counted.to_dict("records")
    ]
    caption = "Verdicts of an independent verification. Cells: of a problem and a tolerance; claimed: those reported as solved."
    if with_error:
        caption += " Error: the median residual, by Coulomb's law, of answers to another law or with a polygon for the cone."
    caption += f" {tables.exclusions(run)}"
    return [Table("solvability", caption, ["solver", *columns, *["error"] * with_error], rows)]


def _problems(run: Run) -> list[Table]:
    rows = [
        [row["problem_class"], str(row["problems"]), str(row["left_out"]), _range(row, "contacts"), _range(row, "size")]
        for row in tables.problem_classes(run).to_dict("records")
    ]
    caption = (
        "Problems by class; left out: not ranked; unknowns (n): of the friction LCP, in space with a cone of eight facets."
    )
    return [Table("problems", caption, ["class", "problems", "left out", "contacts", "unknowns"], rows)]


def _range(row: dict[str, float], what: str) -> str:
    low, high = row[f"{what}_from"], row[f"{what}_to"]
    return f"{low:.0f}" if low == high else f"{low:.0f}–{high:.0f}" if np.isfinite(low) else "–"


def _solvers(run: Run) -> list[Table]:
    """The solvers with their models and references and, if there are outside ones, the versions of the libraries."""
    columns = ["solver", "model", "version"]
    both = pd.concat([table.reindex(columns=columns) for table in (run.rows, run.simulations)]).fillna("")
    own = run.manifest.get("versions", {}).get("frictionbench")
    rows = [
        [name + PORTFOLIO * (name in run.portfolios), MODELS.get(model, model), ", ".join(sorted(cited(name))) or "–"]
        + ["–" if version in ("", own) else str(version)] * bool(run.outside)
        for name, model, version in both.groupby("solver", as_index=False).max().itertuples(index=False)
    ]
    caption = "Solvers, the model that each solves (LCP: in space with a polygon in place of the cone), and references."
    caption += "".join(f" {name}* is a portfolio, which may run {members}." for name, members in run.portfolios.items())
    return [Table("solvers", caption, ["solver", "solves", REFERENCES, *["version"] * bool(run.outside)], rows)]


TABLES: tuple[Callable[[Run], list[Table]], ...] = (*(_choice, _solvability, _times, _percentiles, _problems, _solvers),)
