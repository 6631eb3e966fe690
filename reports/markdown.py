"""A run's figures as Markdown: which solver for what, who is exact and who claims falsely, times by size, and whose own clock
says otherwise. `make peers` writes it, and docs/peers.md keeps one."""

from pathlib import Path

import numpy as np
import pandas as pd

from reports import choice, tables
from reports.accuracy import TARGETS
from reports.drawing.text import power, seconds
from reports.run import Run, read_run
from results.schema import CRASHED, MISSED, SKIPPED, TIMEOUT, WRONG

BANDS = ((0, 10), (10, 40), (40, np.inf))  # contacts
ENDS = (max(TARGETS), min(TARGETS))


def write_markdown(folder: Path) -> Path:
    """Write DIR/report.md; its path. Errors: results.store.ResultsError where DIR is not a results folder."""
    run = read_run(folder)
    parts = [_which(run), _exact(run), *(_times(run, dimension) for dimension in (2, 3)), _clocks(run), _skipped(run)]
    path = folder / "report.md"
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")
    return path


def _which(run: Run) -> str:
    rows = [
        [kind, *(_said(found[target]) if target in found else "–" for target in ENDS)] for kind, found in choice.choices(run)
    ]
    return _table("## Which solver", ["problems", *(f"to {power(target)}" for target in ENDS)], rows)


def _said(found: choice.Choice) -> str:
    sure = "" if found.sure is None else f", sure {found.sure:.0%}"
    lead = "" if found.lead is None else f", {found.lead:.1f} times ahead of {_name(str(found.next))}{sure}"
    return f"**{_name(found.entry)}** {seconds(found.mean)}{lead} ({found.reached}/{found.problems})"


def _exact(run: Run) -> str:
    """Of each entry the problems it met at the tightest tolerance, and how many it ended how."""
    rows = run.contested[(run.contested["tol"] == run.contested["tol"].min()) & (run.contested["verdict"] != SKIPPED)]
    best = rows["tol"].min()
    own = rows["model_residual"] <= best
    counts = pd.DataFrame({"problems": rows.groupby("entry").size()})
    counts["exact"] = (rows["residual"] <= best).groupby(rows["entry"]).sum()
    counts["its own model"] = own.groupby(rows["entry"]).sum()
    for verdict in (MISSED, WRONG, TIMEOUT, CRASHED):
        counts[verdict] = (rows["verdict"] == verdict).groupby(rows["entry"]).sum()
    models = rows.drop_duplicates("entry").set_index("entry")["model"]
    counts = counts.assign(model=models).sort_values(["exact", "its own model"], ascending=False, kind="stable")
    names = ["problems", "exact", "its own model", MISSED, WRONG, TIMEOUT, CRASHED]
    body = [[_name(entry), row["model"], *(str(row[name]) for name in names)] for entry, row in counts.iterrows()]
    title = f"## Who is exact, who claims falsely, at {power(best)}"
    return _table(title, ["solver", "model", *names], body)


def _times(run: Run, dimension: int) -> str:
    """Median of form, setup and solve together where the solver's own model is solved at the tightest tolerance."""
    rows = run.contested
    rows = rows[(rows["dimension"] == dimension) & (rows["tol"] == rows["tol"].min()) & (rows["verdict"] != SKIPPED)]
    if rows.empty:
        return ""
    done = rows["answered"] & (rows[["residual", "model_residual"]].min(axis=1) <= rows["tol"])
    body, order = [], []
    for entry, own in rows.groupby("entry", sort=False):
        cells = []
        for low, high in BANDS:
            band = (own["contacts"] > low) & (own["contacts"] <= high)
            good = own[band & done[own.index]]
            parts = [good[f"{step}_time"].median() for step in ("form", "setup", "solve")]
            shown = " + ".join(f"{1e3 * part:.2g}" for part in parts)
            cells.append(f"{shown} ({len(good)}/{band.sum()})" if len(good) else f"– (0/{band.sum()})")
        body.append([_name(str(entry)), *cells])
        order.append((-done[own.index].sum(), own.loc[done[own.index], "time"].median()))
    body = [body[i] for i in sorted(range(len(body)), key=order.__getitem__)]
    where = "the plane" if dimension == 2 else "space"
    title = f"## Times in {where}, ms: form + setup + solve (solved/problems, each its own model)"
    heads = [f"{low + 1} to {high:.0f} contacts" if high < np.inf else f"more than {low}" for low, high in BANDS]
    return _table(title, ["solver", *heads], body)


def _clocks(run: Run) -> str:
    apart = tables.clocks(run).query("apart")
    body = [
        [_name(str(row.entry)), *(f"{1e3 * time:.2g}" for time in (row.solve_time, row.clock_time)), f"{row.ratio:.2g}"]
        for row in apart.itertuples()
    ]
    title = "## Whose own clock differs by more than a tenth (medians, ms)"
    return _table(title, ["solver", "solve, by the harness", "by its own clock", "ratio"], body) if body else ""


def _skipped(run: Run) -> str:
    found = tables.reasons(run)
    found = found[(found["verdict"] == SKIPPED) & found["reason"].str.contains("not installed")]
    return "".join(f"Skipped: {_name(row['entry'])}, {row['reason']}.  \n" for _, row in found.iterrows())


def _name(entry: str) -> str:
    return f"`{entry}`"


def _table(title: str, heads: list[str], rows: list[list[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return f"{title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"
