"""The figures of a run as Markdown: which solver to choose, percentiles, reliability, times by size, and times measured by the
libraries.

`make peers` writes it, and docs/peers.md contains an example.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports import choice, noise, tables
from frictionbench.reports.accuracy import in_order, overall, percentiles, shown_levels
from frictionbench.reports.drawing.text import ahead, code, count, escaped, percent, power, seconds
from frictionbench.reports.run import Run
from frictionbench.results.files import write_text

BANDS = ((0, 4), (4, 20), (20, 100), (100, np.inf))  # contacts


def write_markdown(folder: Path, run: Run) -> Path:
    """Write DIR/report.md; return its path."""
    parts = [
        _head(run),
        *(f"{escaped(line)}\n" for line in _first(run)),
        _which(run),
        *(_percentiles(run, where, times) for where, times in overall(run.times[run.outer_targets[-1]]).items()),
        *(f"**{what}**: {escaped(names)}.\n" for what, names in tables.sentences(run)),
        _exact(run),
        *(_times(run, dimension) for dimension in (2, 3)),
        _clocks(run),
        _skipped(run),
    ]
    path = folder / "report.md"
    write_text(path, "\n".join(part for part in parts if part).replace("<", "&lt;"))  # it holds no HTML of our own
    return path


def _head(run: Run) -> str:
    settings, machine = run.manifest.get("settings", {}), run.manifest.get("machine", {})
    problems = run.ranked.drop_duplicates("problem_id")
    return (
        escaped(
            f"Suite {settings.get('suite')}, finished {run.manifest.get('finished', 'never')}, {machine.get('processor')}, "
            f"{machine.get('cores')} cores: {count(len(problems), 'ranked problem')}, "
            f"{count(run.ranked['label'].nunique(), 'solver')}, time limit {settings.get('time_limit')} s."
        )
        + "\n"
    )


def _first(run: Run) -> list[str]:
    """The sentences of the page's first screen: winners by both rankings, what scenes decide them, and noise."""
    target = run.outer_targets[-1]
    runs = run, run.ranked_by(run.rank_by.other)
    ranked = {one.rank_by: choice.choices(one) for one in runs}
    families = choice.deciding_scenes({one.rank_by: choice.without_scenes(one) for one in runs})
    found = noise.timing_noise(run, ranked)
    noisy = [noise.sentence(found, len(run.rows)), *found.changed] if found else []
    return [*choice.headline(ranked, run.overall, target), *families, *noisy]


def _which(run: Run) -> str:
    """The fastest of all solvers and of the solvers from outside libraries, by kind of problem."""
    theirs = choice.choices(run, outside(run))
    rows = []
    for kind, other in zip(choice.choices(run), theirs, strict=True):
        best = [_describe(kind.choices.get(target)) for target in run.outer_targets]
        rows.append(
            [f"{kind.name} ({count(kind.problems, 'problem')})", *best, _describe(other.choices.get(run.outer_targets[-1]))]
        )
    heads = [
        "for",
        *(f"to {power(target)}" for target in run.outer_targets),
        f"of the outside solvers, to {power(run.outer_targets[-1])}",
    ]
    return _table(f"## The fastest {run.rank_by.words} ({run.rank_by.parts}), and how reliable", heads, rows)


def outside(run: Run) -> set[str]:
    """The labels of solvers that use an outside library: those whose version is not that of this package."""
    ours = run.manifest.get("versions", {}).get("frictionbench")
    return set(run.rows.loc[run.rows["version"].fillna(ours) != ours, "label"])


def _describe(found: choice.Choice | None) -> str:
    if found is None or found.winner is None:
        return found.unclear if found else "none"
    best, rate = found.winner, f", wins {percent(found.win_rate or 0.0)} of bootstrap samples"
    lead = "" if found.lead is None else f", {ahead(found.lead, code(found.places[1].label))}{rate}"
    law = f" ({best.law})" if best.law else ""
    return f"**{code(best.label)}**{law} {seconds(best.mean)}{lead} ({best.reached}/{found.problems})"


def _percentiles(run: Run, where: str, times: pd.DataFrame) -> str:
    """The percentiles over the problems, by weight, at the finest target."""
    table = in_order(percentiles(times, run.budget))
    shown = shown_levels(table)
    body = []
    for label, row in zip(table.index, table.to_dict("records"), strict=True):
        within = [] if run.budget is None else [percent(row["within"], 1)]
        body.append([code(str(label)), *(seconds(row[name], 3) for name in shown), *within])
    budget = [] if run.budget is None else [f"within {seconds(run.budget)}"]
    title = f"## Percentiles {where}, {run.rank_by.words} ({run.rank_by.parts}), to {power(run.outer_targets[-1])}"
    return _table(title, ["solver", *shown, *budget], body)


def _exact(run: Run) -> str:
    """For each label the number of problems at the tightest tolerance, and how many ended with each result."""
    names = ["problems", "exact", "own model", Verdict.NEAR_MISS, Verdict.WRONG, Verdict.TIMEOUT, Verdict.CRASHED]
    body = [[code(one.label), *map(str, one[1:])] for one in tables.reliabilities(run)]
    return _table(f"## Reliability at {power(run.ranked['tol'].min())}", ["solver", "model", *names], body)


def _times(run: Run, dimension: int) -> str:
    """Medians of form, setup and solve over the problems whose own model is solved at the tightest tolerance, by size."""
    rows = run.tightest[(run.tightest["dimension"] == dimension) & measured(run.tightest)]
    if rows.empty:
        return ""
    body, order = [], []
    for label, own in rows.groupby("label", sort=False):
        cells = []
        for low, high in BANDS:
            band = (own["contacts"] > low) & (own["contacts"] <= high)
            good = own[band & own["own_solved"]]
            parts = [good[f"{step}_time"].median() for step in ("form", "setup", "solve")]
            shown = " + ".join(f"{1e3 * part:.2g}" for part in parts)
            cells.append(f"{shown} ({len(good)}/{band.sum()})" if len(good) else f"– (0/{band.sum()})")
        body.append([code(str(label)), *cells])
        order.append((-own["own_solved"].sum(), own.loc[own["own_solved"], "time"].median()))
    body = [body[i] for i in sorted(range(len(body)), key=order.__getitem__)]
    where = "the plane" if dimension == 2 else "space"
    title = f"## Times in {where}, ms: form + setup + solve (solved/problems, each solver by its own model)"
    return _table(title, ["solver", *_bands()], body)


def _clocks(run: Run) -> str:
    """Medians by size for the solvers whose library measures a different time, over the problems whose model they solve."""
    differing = tables.clocks(run).query("differs")
    rows = run.tightest[run.tightest["clock_time"].notna() & run.tightest["own_solved"]]
    rows = rows.assign(solve_time=rows["call_time"].fillna(rows["solve_time"]))
    body = []
    for label, ratio in zip(differing["label"], differing["ratio"], strict=True):
        own, shown = rows[rows["label"] == label], []
        for low, high in BANDS:
            times = own.loc[(own["contacts"] > low) & (own["contacts"] <= high), ["solve_time", "clock_time"]].median() * 1e3
            shown.append("–" if times.isna().any() else f"{times['solve_time']:.2g} / {times['clock_time']:.2g}")
        body.append([code(str(label)), *shown, f"{ratio:.2g}"])
    title = "## Solve times measured by the benchmark / by the library, ms, where they differ by more than a tenth"
    return _table(title, ["solver", *_bands(), "ratio"], body) if body else ""


def _bands() -> list[str]:
    return [f"{low + 1} to {high:.0f} contacts" if high < np.inf else f"more than {low}" for low, high in BANDS]


def _skipped(run: Run) -> str:
    found = tables.reasons(run)
    found = found[(found["verdict"] == Verdict.SKIPPED) & found["reason"].str.contains("not installed")]
    return "".join(f"Skipped: {code(row['label'])}, {escaped(row['reason'])}.  \n" for _, row in found.iterrows())


def _table(title: str, heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return f"{title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"
