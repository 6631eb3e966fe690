"""The figures of a run as Markdown: which solver to choose, reliability, times by size, and times measured by the libraries.

`make peers` writes it, and docs/peers.md contains an example.
"""

from pathlib import Path

import numpy as np

from frictionbench.reports import choice, tables
from frictionbench.reports.drawing.text import power, seconds
from frictionbench.reports.reliability import reliabilities, sentences
from frictionbench.reports.run import Run
from frictionbench.results.verdicts import Verdict, measured

BANDS = ((0, 4), (4, 20), (20, 100), (100, np.inf))  # contacts


def write_markdown(folder: Path, run: Run) -> Path:
    """Write DIR/report.md; return its path."""
    parts = [
        _head(run),
        _which(run),
        *(f"**{what}**: {names}.\n" for what, names in sentences(run)),
        _exact(run),
        *(_times(run, dimension) for dimension in (2, 3)),
        _clocks(run),
        _skipped(run),
    ]
    path = folder / "report.md"
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")
    return path


def _head(run: Run) -> str:
    settings, machine = run.manifest.get("settings", {}), run.manifest.get("machine", {})
    problems = run.ranked.drop_duplicates("problem_id")
    timed = run.rows["disturbed"].dropna()
    disturbed = f"; {timed.eq(True).mean():.0%} of the cells that ran waited for their core" if len(timed) else ""
    return (
        f"Suite {settings.get('suite')}, finished {run.manifest.get('finished', 'never')}, {machine.get('processor')}, "
        f"{machine.get('cores')} cores: {len(problems)} ranked problems, "
        f"{run.ranked['label'].nunique()} solvers, time limit {settings.get('time_limit')} s{disturbed}.\n"
    )


def _which(run: Run) -> str:
    """The fastest of all solvers and of the solvers from outside libraries, by kind of problem."""
    theirs = choice.choices(run, outside(run))
    rows = []
    for (kind, found), (_, other) in zip(choice.choices(run), theirs, strict=True):
        best = [_describe(found[target]) if target in found else "none" for target in run.outer_targets]
        peer = other.get(run.outer_targets[-1])
        rows.append([kind, *best, _describe(peer) if peer else "none"])
    heads = [
        "for",
        *(f"to {power(target)}" for target in run.outer_targets),
        f"of the outside solvers, to {power(run.outer_targets[-1])}",
    ]
    return _table("## Which solver, and how reliable", heads, rows)


def outside(run: Run) -> set[str]:
    """The labels of solvers that use an outside library: those whose version is not that of this package."""
    ours = run.manifest.get("versions", {}).get("frictionbench")
    return set(run.rows.loc[run.rows["version"].fillna(ours) != ours, "label"])


def _describe(found: choice.Choice) -> str:
    rate = "" if found.win_rate is None else f", wins {found.win_rate:.0%} of bootstrap samples"
    lead = "" if found.lead is None else f", {found.lead:.1f} times ahead of {_name(str(found.next))}{rate}"
    return f"**{_name(found.label)}** {seconds(found.mean)}{lead} ({found.reached}/{found.problems})"


def _exact(run: Run) -> str:
    """For each label the number of problems at the tightest tolerance, and how many ended with each result."""
    names = ["problems", "exact", "own model", Verdict.NEAR_MISS, Verdict.WRONG, Verdict.TIMEOUT, Verdict.CRASHED]
    body = [[_name(one.label), *map(str, one[1:])] for one in reliabilities(run)]
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
        body.append([_name(str(label)), *cells])
        order.append((-own["own_solved"].sum(), own.loc[own["own_solved"], "time"].median()))
    body = [body[i] for i in sorted(range(len(body)), key=order.__getitem__)]
    where = "the plane" if dimension == 2 else "space"
    title = f"## Times in {where}, ms: form + setup + solve (solved/problems, each solver by its own model)"
    return _table(title, ["solver", *_bands()], body)


def _clocks(run: Run) -> str:
    """Medians by size for the solvers whose library measures a different time, over the problems whose model they solve."""
    differing = tables.clocks(run).query("differs")
    rows = run.tightest[run.tightest["clock_time"].notna() & run.tightest["own_solved"]]
    body = []
    for label, ratio in zip(differing["label"], differing["ratio"], strict=True):
        own, shown = rows[rows["label"] == label], []
        for low, high in BANDS:
            times = own.loc[(own["contacts"] > low) & (own["contacts"] <= high), ["solve_time", "clock_time"]].median() * 1e3
            shown.append("–" if times.isna().any() else f"{times['solve_time']:.2g} / {times['clock_time']:.2g}")
        body.append([_name(str(label)), *shown, f"{ratio:.2g}"])
    title = "## Solve times measured by the benchmark / by the library, ms, where they differ by more than a tenth"
    return _table(title, ["solver", *_bands(), "ratio"], body) if body else ""


def _bands() -> list[str]:
    return [f"{low + 1} to {high:.0f} contacts" if high < np.inf else f"more than {low}" for low, high in BANDS]


def _skipped(run: Run) -> str:
    found = tables.reasons(run)
    found = found[(found["verdict"] == Verdict.SKIPPED) & found["reason"].str.contains("not installed")]
    return "".join(f"Skipped: {_name(row['label'])}, {row['reason']}.  \n" for _, row in found.iterrows())


def _name(label: str) -> str:
    return f"`{label}`"


def _table(title: str, heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return f"{title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"
