"""The rows of a table at the grid points of a map, and those of them that failed although a solution is known to exist.

A solution is known to exist at a grid point where theory or the enumeration of all solutions says so (column `existence`), or
where the verified answer of some solver is one. It is not known where the enumeration finds none, even if an answer passes
within the tolerance.
"""

import json

import pandas as pd

from frictionbench.results.conventions import first_phase
from frictionbench.results.map_spec import Map
from frictionbench.results.verdicts import Verdict

THEORY = ("gaps", "pointed")  # reasons of existence that also hold for the same problem with fewer contacts
EXACT = ("coulomb", "lcp")  # models


def at_grid_points(rows: pd.DataFrame, spec: Map) -> pd.DataFrame:
    """The rows of a map, taken from simulations for a map in closed loop and from solves otherwise.

    Added columns: i, j (the grid point), tile (width of its tile in grid lines) and known (whether a solution is known).
    """
    rows = rows[rows["scheme"] == spec.scheme] if spec.steps else rows[rows["phase"] == first_phase(spec.scheme)]
    rows = rows[rows["scene"] == spec.scene]
    points: dict[str, tuple[float, float, float]] = {}
    for i, j in spec.grid_points():
        tile = 1.0 if i % 1 == 0 and j % 1 == 0 else 0.5 if (2 * i) % 1 == 0 and (2 * j) % 1 == 0 else 0.25
        points.setdefault(json.dumps(spec.at((i, j)), sort_keys=True), (i, j, tile))
    rows = rows[rows["parameters"].isin(points.keys())]
    found = [points[parameters] for parameters in rows["parameters"]]
    rows = rows.join(pd.DataFrame(found, columns=["i", "j", "tile"], index=rows.index))
    solved = (rows["verdict"] == Verdict.SOLVED).groupby([rows["i"], rows["j"]]).transform("any")
    if spec.steps:
        return rows.assign(known=solved)
    return rows.assign(known=rows["existence"].isin([*THEORY, "counted"]) | (solved & (rows["existence"] != "none")))


def failed_rows(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of exact methods that are not solved where a solution is known, those of the smallest problems first.

    rows: of a map of first problems, see `at_grid_points`.
    """
    wanted = rows["known"] & rows["model"].isin(EXACT) & ~rows["verdict"].isin([Verdict.SOLVED, Verdict.SKIPPED])
    return rows[wanted].sort_values(["contacts", "i", "j"], kind="stable")
