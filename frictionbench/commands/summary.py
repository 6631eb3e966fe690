"""The default folder of a run, and the summary at its end: counts of verdicts, the folder, the next commands."""

import json
from hashlib import sha256
from pathlib import Path
from shlex import quote

import numpy as np
import pandas as pd

from frictionbench.commands.table import columns
from frictionbench.harness.plans.plan import Plan
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import ENDINGS, count, endings
from frictionbench.results.store import read_table

MOST_REASONS, LONGEST = 6, 160  # reasons shown and characters of each: two lines of a terminal at most


def folder_for(plan: Plan) -> Path:
    """Return the default folder of a plan's results: the suite's, or one named by a hash of the settings if these differ."""
    runs = Path("runs")
    if plan.suite in SUITES and plan.settings() == SUITES[plan.suite]().settings():
        return runs / plan.suite
    name = "-".join([plan.suite, *(spec.name for spec in plan.maps if plan.suite == "map")])
    return runs / f"{name}-{sha256(json.dumps(plan.settings(), sort_keys=True).encode()).hexdigest()[:8]}"


def summary(folder: Path) -> str:
    """Return the verdicts of a finished run, one line per solver, its folder, and the command that makes the report."""
    rows = read_table(folder, "solves")
    easy, bare = rows["trivial"].eq(True) | rows["idle"].eq(True), rows["contacts"].isna()
    lines = [verdict_counts("cells of problems in which friction is at work", rows[~easy & ~bare])]
    lines += [verdict_counts("cells of LCPs and of files that cannot be read, not ranked", rows[~easy & bare])]
    if others := int(easy.sum()):
        lines.append(f"cells of trivial and idle problems (nothing to solve, or friction not needed), not ranked: {others}")
    lines += [verdict_counts("simulations, scenes in closed loop", read_table(folder, "simulations"))]
    batches = read_table(folder, "batches")
    lines += [verdict_counts("batches of small problems", batches), _reasons(rows), _reasons(batches)]
    lines.append(f"results: {folder}\nreport:  frictionbench report {quote(str(folder))}")
    return "\n\n".join(filter(None, lines))


def verdict_counts(what: str, rows: pd.DataFrame) -> str:
    """Return the numbers of verdicts, a line per variant; empty without rows."""
    if rows.empty:
        return ""
    counts = pd.crosstab(rows["variant"], np.array(endings(rows))).reindex(columns=list(ENDINGS), fill_value=0)
    counts = counts.sort_values(list(ENDINGS), ascending=False, kind="stable")
    counts.insert(0, "cells", counts.sum(axis=1))
    body = [(str(name), *(str(n or "") for n in row)) for name, row in zip(counts.index, counts.to_numpy(), strict=True)]
    return "\n".join([f"{what}: {len(rows)}", *columns(("solver", *counts), body)])


def _reasons(rows: pd.DataFrame) -> str:
    """Return why cells were skipped or crashed, the most frequent reasons first."""
    failed = rows[rows["verdict"].isin([Verdict.SKIPPED, Verdict.CRASHED]) & rows["reason"].notna()]
    lines = []
    for (verdict, reason), variants in sorted(failed.groupby(["verdict", "reason"])["variant"], key=lambda one: -len(one[1])):
        names = variants.unique()
        line = f"{len(variants)} × {verdict} ({names[0] if len(names) == 1 else count(len(names), 'solver')}): {reason}"
        lines.append(line if len(line) <= LONGEST else f"{line[: LONGEST - 4]} ...")
    more = [f"... and {len(lines) - MOST_REASONS} more reasons, in the report"] if len(lines) > MOST_REASONS else []
    return "\n".join([*lines[:MOST_REASONS], *more])
