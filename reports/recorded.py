"""The problems that others recorded, one by one: what they are, who solves them, and who is the fastest.

Of each problem the tightest tolerance that it was put to counts; who reaches it at a looser one has reached it, too.
"""

import json
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from frictionbench.reports.run import Run
from frictionbench.results.verdicts import Verdict

NOTICED = 1e-12  # asymmetry and indefiniteness of W that are not rounding


class Recorded(NamedTuple):
    """One file: rank_ratio is W's rank over its rows, None where unknown; solvers, the fastest first, with their times in s.
    A bare LCP has unknowns alone.

    reason: why the file yields no problem; all else but its name is then empty.
    """

    family: str
    file: str
    dimension: int | None
    contacts: int | None
    unknowns: int | None
    rank_ratio: float | None
    oddities: str
    tol: float
    solvers: dict[str, float]
    tried: int
    reason: str


def recorded_problems(run: Run) -> list[Recorded]:
    """A line per file, in the plan's order; none where the run has scenes alone."""
    files = run.rows["parameters"].map(_file)
    own = run.rows.assign(file=files)[files != ""]
    groups = own.groupby(["scene", "file", "problem"], sort=False)
    return [_line(str(family), str(file), rows) for (family, file, _), rows in groups]


def _line(family: str, file: str, rows: pd.DataFrame) -> Recorded:
    first, tol = rows.iloc[0], float(rows["tol"].min())
    if first["problem"] == "":
        return Recorded(family, file, None, None, None, None, "", tol, {}, 0, str(first["reason"]))
    done = rows[rows["answered"] & (rows["residual"] <= tol)]
    tried = rows.loc[rows["verdict"] != Verdict.SKIPPED, "label"].nunique()
    contacts, dimension, unknowns = (None if pd.isna(first[n]) else int(first[n]) for n in ("contacts", "dimension", "size"))
    rows_of_w = (contacts or 0) * (dimension or 0)
    ratio = first["rank"] / rows_of_w if rows_of_w and np.isfinite(first["rank"] or np.nan) else None
    times = {str(label): float(time) for label, time in done.groupby("label")["time"].min().sort_values().items()}
    size = dimension, contacts, unknowns, ratio
    return Recorded(family, file, *size, _oddities(first), tol, times, tried, "")


def _oddities(facts: pd.Series) -> str:
    """What mechanics has not, and the file has."""
    told = ["trivial"] if facts["trivial"] else []
    for name, column in (("unsymmetric", "asymmetry"), ("indefinite", "indefiniteness")):
        share = abs(facts[column] or 0.0)
        told += [f"{name} by {share:.0e}".replace("e-0", "e-")] if share > NOTICED else []
    return ", ".join(told)


def _file(parameters: str) -> str:
    """The file that a source's parameters name; empty for a scene."""
    try:
        told: Any = json.loads(parameters or "{}")
    except (ValueError, RecursionError):
        return ""
    return str(told["file"]) if isinstance(told, dict) and list(told) == ["file"] else ""
