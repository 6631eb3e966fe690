"""Rows of a table at their places on a map, and which of them failed though a solution is known to exist.

A solution is known to exist at a place where theory or the counting of all solutions says so (the column `existence`), or where
any solver's verified answer is one; but not where counting finds none, whatever passes for one within the tolerance.
"""

import json

import pandas as pd

from frictionbench.results.conventions import first_phase
from frictionbench.results.maps import Map
from frictionbench.results.verdicts import Verdict

THEORY = ("gaps", "pointed")  # what is known so of a problem holds for it with fewer contacts, too
EXACT = ("coulomb", "lcp")  # models


def placed(rows: pd.DataFrame, spec: Map) -> pd.DataFrame:
    """The map's rows, of simulations where it is one in closed loop, else of solves; with the columns i, j (the grid point),
    tile (the width of its tile in grid lines) and known (a solution is)."""
    rows = rows[rows["scheme"] == spec.scheme] if spec.steps else rows[rows["phase"] == first_phase(spec.scheme)]
    rows = rows[rows["scene"] == spec.scene]
    where: dict[str, tuple[float, float, float]] = {}
    for i, j in spec.places():
        tile = 1.0 if i % 1 == 0 and j % 1 == 0 else 0.5 if (2 * i) % 1 == 0 and (2 * j) % 1 == 0 else 0.25
        where.setdefault(json.dumps(spec.at((i, j)), sort_keys=True), (i, j, tile))
    rows = rows[rows["parameters"].isin(where.keys())]
    places = pd.DataFrame([where[told] for told in rows["parameters"]], columns=["i", "j", "tile"], index=rows.index)
    rows = rows.join(places)
    solved = (rows["verdict"] == Verdict.SOLVED).groupby([rows["i"], rows["j"]]).transform("any")
    if spec.steps:
        return rows.assign(known=solved)
    return rows.assign(known=rows["existence"].isin([*THEORY, "counted"]) | (solved & (rows["existence"] != "none")))


def lost(rows: pd.DataFrame) -> pd.DataFrame:
    """Of the rows of a map of first problems those of exact methods that are not solved where a solution is known, the smallest
    first."""
    failed = rows["known"] & rows["model"].isin(EXACT) & ~rows["verdict"].isin([Verdict.SOLVED, Verdict.SKIPPED])
    return rows[failed].sort_values(["contacts", "i", "j"], kind="stable")
