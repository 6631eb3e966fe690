"""The maps of a run as tables: the cells at their grid points, and the robustness of each solver over each map.

results.maps defines where a solution is known to exist.
"""

from dataclasses import dataclass
from typing import Any

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports.run import Run
from frictionbench.results.maps import Map, at_grid_points, maps_of

EXACT_MODELS = ("coulomb", "lcp")  # models


@dataclass(frozen=True, eq=False)
class MapCells:
    """A map and its rows, with the columns that results.maps.at_grid_points adds."""

    spec: Map
    rows: pd.DataFrame

    @property
    def by_label(self) -> dict[str, pd.DataFrame]:
        """The rows of each solver that ran, in the order of the plan."""
        ran = self.rows.loc[measured(self.rows), "label"].unique()
        return {label: self.rows[self.rows["label"] == label] for label in ran}

    @property
    def problems(self) -> pd.DataFrame:
        """A row per grid point."""
        return self.rows.drop_duplicates(["i", "j"])


def map_cells(run: Run) -> list[MapCells]:
    """Return the maps of the run that have rows. Errors: ResultsError if the maps in the manifest cannot be read."""
    tables = {False: run.rows, True: run.map_simulations}
    mapped = (MapCells(spec, at_grid_points(tables[spec.steps > 0], spec)) for spec in maps_of(run.manifest))
    return [cells for cells in mapped if len(cells.rows)]


def robustness(maps: list[MapCells]) -> pd.DataFrame:
    """Return a row per label, the best first: for each map the share of grid points solved among those with a known solution;
    `known`: the same over all maps; `all`: the share among all grid points."""
    columns: dict[str, Any] = {}
    for cells in maps:
        known = cells.rows[cells.rows["known"] & measured(cells.rows)]
        columns[cells.spec.name] = (known["verdict"] == Verdict.SOLVED).groupby(known["label"]).mean()
    if not columns:
        return pd.DataFrame()
    rows = pd.concat([cells.rows[["label", "verdict", "known"]] for cells in maps], ignore_index=True)
    rows = rows[measured(rows)]
    solved = rows["verdict"] == Verdict.SOLVED
    table = pd.DataFrame(columns)
    table["all"] = solved.groupby(rows["label"]).mean()
    table["known"] = solved[rows["known"]].groupby(rows["label"]).mean()
    return table.sort_values("known", ascending=False, kind="stable").rename_axis("label").reset_index()


def failures(maps: list[MapCells]) -> pd.DataFrame:
    """Return the cells of exact methods on maps of first problems that are not solved though a solution is known, the smallest
    problems of each map first. map: its name."""
    parts = [cells.rows.assign(map=cells.spec.name) for cells in maps if not cells.spec.steps]
    if not parts:
        return pd.DataFrame(columns=["map", "label", "key"])
    rows = pd.concat([part.sort_values(["contacts", "i", "j"], kind="stable") for part in parts])
    return rows[rows["known"] & rows["model"].isin(EXACT_MODELS) & ~rows["verdict"].isin([Verdict.SOLVED, Verdict.SKIPPED])]


def smallest(failed: pd.DataFrame) -> pd.DataFrame:
    """Return for each map and label the failed cell of the smallest problem. count: the number of failed cells."""
    counts = failed.groupby(["map", "label"]).size().rename("count")
    return failed.drop_duplicates(["map", "label"]).join(counts, on=["map", "label"])


def changes(cells: MapCells) -> list[str]:
    """Return the labels whose verdict or work changes over a map on which both must be constant."""
    kinds = cells.rows.groupby("label", sort=False)[["verdict", "work"]].nunique().max(axis=1)
    return list(kinds.index[kinds > 1])
