"""The maps of a run as tables: every cell at its place, and how robust each solver is over each map.

A solution is known to exist at a place where theory or the counting of all solutions says so (the column `existence`), or where
any solver's verified answer is one; but not where counting finds none, whatever passes for one within the tolerance.
"""

import json
from dataclasses import dataclass
from typing import Any

import pandas as pd

from reports.run import Run
from results.maps import Map, maps_of
from results.schema import SKIPPED, SOLVED

USUAL = "anitescu_potra"


@dataclass(frozen=True, eq=False)
class Cells:
    """A map and its cells: rows of the solves table, or of drives in closed loop, with the columns i, j (the place), tile (the
    width of its tile in grid lines) and known (a solution is)."""

    spec: Map
    rows: pd.DataFrame

    @property
    def entries(self) -> list[str]:
        """The solvers that ran, in the plan's order."""
        ran = self.rows.loc[self.rows["verdict"] != SKIPPED, "entry"]
        return list(dict.fromkeys(ran))

    @property
    def problems(self) -> pd.DataFrame:
        """A row per place."""
        return self.rows.drop_duplicates(["i", "j"])


def map_cells(run: Run) -> list[Cells]:
    """The maps of the run that have rows. Errors: ResultsError where the manifest's maps cannot be read."""
    found = (Cells(spec, _placed(run, spec)) for spec in maps_of(run.manifest))
    return [cells for cells in found if len(cells.rows)]


def _placed(run: Run, spec: Map) -> pd.DataFrame:
    if spec.steps:
        rows = run.mapped_drives[run.mapped_drives["scheme"] == spec.scheme]
    else:
        told = "step" if spec.scheme == USUAL else f"step of {spec.scheme}"
        rows = run.rows[run.rows["phase"] == told]
    rows = rows[rows["scene"] == spec.scene]
    where: dict[str, tuple[float, float, float]] = {}
    for i, j in spec.places():
        tile = 1.0 if i % 1 == 0 and j % 1 == 0 else 0.5 if (2 * i) % 1 == 0 and (2 * j) % 1 == 0 else 0.25
        where.setdefault(json.dumps(spec.at((i, j)), sort_keys=True), (i, j, tile))
    rows = rows[rows["parameters"].isin(where.keys())]
    places = pd.DataFrame([where[told] for told in rows["parameters"]], columns=["i", "j", "tile"], index=rows.index)
    rows = rows.join(places)
    solved = (rows["verdict"] == SOLVED).groupby([rows["i"], rows["j"]]).transform("any")
    if spec.steps:
        return rows.assign(known=solved)
    theory = rows["existence"].isin(["gaps", "pointed", "counted"])
    return rows.assign(known=theory | (solved & (rows["existence"] != "none")))


def robustness(maps: list[Cells]) -> pd.DataFrame:
    """A row per entry: per map the share of places solved among those where a solution is known; `all` and `known` over all
    maps, each place counting once: the share of all places, and of those where a solution is known. Best first."""
    columns: dict[str, Any] = {}
    for cells in maps:
        known = cells.rows[cells.rows["known"] & (cells.rows["verdict"] != SKIPPED)]
        columns[cells.spec.name] = (known["verdict"] == SOLVED).groupby(known["entry"]).mean()
    if not columns:
        return pd.DataFrame()
    rows = pd.concat([cells.rows[["entry", "verdict", "known"]] for cells in maps], ignore_index=True)
    rows = rows[rows["verdict"] != SKIPPED]
    solved = rows["verdict"] == SOLVED
    table = pd.DataFrame(columns)
    table["all"] = solved.groupby(rows["entry"]).mean()
    table["known"] = solved[rows["known"]].groupby(rows["entry"]).mean()
    return table.sort_values("known", ascending=False, kind="stable").rename_axis("entry").reset_index()


def failures(maps: list[Cells], exact: tuple[str, ...] = ("coulomb", "lcp")) -> pd.DataFrame:
    """Cells of exact methods that are not solved where a solution is known: per map and entry the smallest, with the count."""
    lost = []
    for cells in maps:
        rows = cells.rows
        if cells.spec.steps:
            continue
        failed = rows[rows["known"] & rows["model"].isin(exact) & ~rows["verdict"].isin([SOLVED, SKIPPED])]
        first = failed.sort_values(["contacts", "i", "j"], kind="stable").drop_duplicates("entry")
        lost.append(first.assign(map=cells.spec.name, count=first["entry"].map(failed["entry"].value_counts())))
    return pd.concat(lost) if lost else pd.DataFrame(columns=["map", "entry", "count", "verdict", "contacts", "key"])


def costs(run: Run) -> pd.DataFrame:
    """A row per drive with failed steps that was gone on with in several ways: what each way costs."""
    drives = run.drives[(run.drives["unsolved"] > 0)]
    ways = drives.groupby(["scene", "parameters", "scheme", "variant"])["after_failure"].transform("nunique")
    order = {"answer": 0, "velocity": 1, "relaxation": 2}
    several = drives[ways > 1]
    return several.assign(way=several["after_failure"].map(order)).sort_values(["scene", "parameters", "variant", "way"])


def changes(cells: Cells) -> list[str]:
    """Of a map over which nothing may change: the entries whose verdict or work does."""
    kinds = cells.rows.groupby("entry", sort=False)[["verdict", "work"]].nunique().max(axis=1)
    return list(kinds.index[kinds > 1])
