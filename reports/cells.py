"""The solves table made ready for a report: who ran (entry), on what (problem, problem class), and how long it took.

    entry           the variant of a solver; another start makes it another entry, and so does another host: times of two
                    machines never meet in one figure
    problem_id      a number for the problem of one time step
    problem_class   the scene; where a scene comes in several sizes, the scene and its band of sizes
    time            prepare and solve together, s

Trivial problems never enter a headline: `contested` leaves them out.
"""

import numpy as np
import pandas as pd

from results.schema import CRASHED, SKIPPED, TIMEOUT

BANDS = (100, 1000)  # unknowns of the friction LCP: dense methods win below, sparse ones above
NO_ANSWER = (TIMEOUT, CRASHED, SKIPPED)
_IDENTITY = ["scene", "parameters", "step", "phase", "problem"]


def annotate(solves: pd.DataFrame) -> pd.DataFrame:
    """A copy of the solves table with the columns entry, problem_id, problem_class, time and answered."""
    rows = solves.reset_index(drop=True)
    texts = [
        "scene",
        "parameters",
        "solver",
        "variant",
        "model",
        "verdict",
        "reason",
        "phase",
        "problem",
        "start",
        "key",
        "host",
    ]
    rows[texts] = rows[texts].fillna("")
    rows["trivial"] = rows["trivial"].eq(True)
    rows["claimed"] = rows["claimed"].eq(True)
    rows["entry"] = rows["variant"].where(rows["start"].isin(["", "cold"]), rows["variant"] + ", " + rows["start"])
    if len(set(rows["host"])) > 1:
        rows["entry"] += " on " + rows["host"]
    rows["problem_id"] = rows.groupby(_IDENTITY, dropna=False, sort=False).ngroup()
    rows["problem_class"] = _classes(rows)
    rows["time"] = rows["prepare_time"].fillna(0.0) + rows["solve_time"]
    rows["answered"] = ~rows["verdict"].isin(NO_ANSWER) & np.isfinite(rows["residual"]) & np.isfinite(rows["time"])
    return rows


def annotate_drives(drives: pd.DataFrame) -> pd.DataFrame:
    """A copy of the drives table with the column entry."""
    rows = drives.reset_index(drop=True)
    texts = ["scene", "parameters", "variant", "verdict", "reason", "scheme"]
    rows[texts] = rows[texts].fillna("")
    return rows.assign(entry=rows["variant"])


def contested(rows: pd.DataFrame) -> pd.DataFrame:
    """The annotated rows of problems that are not trivial."""
    return rows[~rows["trivial"]]


def entrants(table: pd.DataFrame) -> list[str]:
    """The entries of a table that ran at all; table: solves or drives with the column entry."""
    return table.loc[table["verdict"] != SKIPPED, "entry"].drop_duplicates().tolist()


def _classes(rows: pd.DataFrame) -> pd.Series:
    size = rows.groupby(["scene", "parameters"])["size"].transform("max")  # a skipped cell may not know its size
    band = pd.Series(np.searchsorted(BANDS, size.fillna(0), side="right"), index=rows.index)
    low, high = BANDS
    names = band.map({0: f", n < {low}", 1: f", n < {high}", 2: f", n from {high}"})
    several = band.groupby(rows["scene"]).transform("nunique") > 1
    return rows["scene"] + names.where(several, "")
