"""The maps of a run as tables: every cell at its place, and how robust each solver is over each map.

Where a solution is known to exist results.map_rows says.
"""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.reports.run import Run
from frictionbench.results.files import write_text
from frictionbench.results.map_rows import at_grid_points, failed_rows
from frictionbench.results.map_spec import Map, maps_of
from frictionbench.results.shrunk import Shrunk
from frictionbench.results.verdicts import Verdict

NOT_TRIED = Shrunk("", 0, 0, whole=False)


@dataclass(frozen=True, eq=False)
class Cells:
    """A map and its cells: rows of solves, or of simulations in closed loop, with the columns i, j (the grid point), tile (the
    width of its tile in grid lines) and known (a solution is)."""

    spec: Map
    rows: pd.DataFrame

    @property
    def labels(self) -> list[str]:
        """The solvers that ran, in the plan's order."""
        ran = self.rows.loc[self.rows["verdict"] != Verdict.SKIPPED, "label"]
        return list(dict.fromkeys(ran))

    @property
    def problems(self) -> pd.DataFrame:
        """A row per place."""
        return self.rows.drop_duplicates(["i", "j"])


def map_cells(run: Run) -> list[Cells]:
    """The maps of the run that have rows. Errors: ResultsError where the manifest's maps cannot be read."""
    tables = {False: run.rows, True: run.map_simulations}
    found = (Cells(spec, at_grid_points(tables[spec.steps > 0], spec)) for spec in maps_of(run.manifest))
    return [cells for cells in found if len(cells.rows)]


def robustness(maps: list[Cells]) -> pd.DataFrame:
    """A row per label: per map the share of places solved among those where a solution is known; `all` and `known` over all
    maps, each place counting once: the share of all places, and of those where a solution is known. Best first."""
    columns: dict[str, Any] = {}
    for cells in maps:
        known = cells.rows[cells.rows["known"] & (cells.rows["verdict"] != Verdict.SKIPPED)]
        columns[cells.spec.name] = (known["verdict"] == Verdict.SOLVED).groupby(known["label"]).mean()
    if not columns:
        return pd.DataFrame()
    rows = pd.concat([cells.rows[["label", "verdict", "known"]] for cells in maps], ignore_index=True)
    rows = rows[rows["verdict"] != Verdict.SKIPPED]
    solved = rows["verdict"] == Verdict.SOLVED
    table = pd.DataFrame(columns)
    table["all"] = solved.groupby(rows["label"]).mean()
    table["known"] = solved[rows["known"]].groupby(rows["label"]).mean()
    return table.sort_values("known", ascending=False, kind="stable").rename_axis("label").reset_index()


def failures(maps: list[Cells], shrunk: Mapping[str, Shrunk]) -> pd.DataFrame:
    """Cells of exact methods that are not solved where a solution is known: per map and label the smallest, with the count, and
    what is left of its problem made small: file and left, its contacts."""
    parts = []
    for cells in maps:
        if cells.spec.steps:
            continue
        failed = failed_rows(cells.rows)
        first = failed.drop_duplicates("label")
        small = first["key"].map(lambda key: shrunk.get(key, NOT_TRIED))
        parts.append(
            first.assign(
                map=cells.spec.name,
                count=first["label"].map(failed["label"].value_counts()),
                file=small.map(lambda one: one.file),
                left=small.map(lambda one: one.contacts),
            )
        )
    return pd.concat(parts) if parts else pd.DataFrame(columns=["map", "label", "count", "key"])


def write_failures(folder: Path, maps: list[Cells]) -> int:
    """Write DIR/failures.txt: of every cell that `failures` counts the command that runs it again, and what it is; how many."""
    rows = [row for cells in maps if not cells.spec.steps for row in failed_rows(cells.rows).to_dict("records")]
    lines = [
        f"{shlex.join(['frictionbench', 'rerun', str(folder), row['key']])}"
        f"  # {row['label']}: {row['verdict']}, {row['scene']} {row['parameters']}, {row['contacts']:.0f} contacts"
        for row in rows
    ]
    if lines:
        write_text(folder / "failures.txt", "\n".join(lines) + "\n")
    return len(lines)


def costs(run: Run) -> pd.DataFrame:
    """A row per simulation with failed steps that was continued in several ways: what each way costs. Those of a scene stand
    behind a simulation without failed steps, where there is one."""
    simulations = run.simulations.assign(
        way=run.simulations["after_failure"].map({"answer": 0, "velocity": 1, "relaxation": 2})
    )
    same = ["scene", "parameters", "scheme"]
    failed = simulations[simulations["unsolved"] > 0]
    several = failed[failed.groupby([*same, "variant"])["after_failure"].transform("nunique") > 1]
    clean = simulations[(simulations["unsolved"] == 0) & (simulations["verdict"] == Verdict.SOLVED)].drop_duplicates(same)
    clean = clean.merge(several[same].drop_duplicates()).assign(way=-1)
    found = pd.concat([clean.assign(first=0), several.assign(first=1)])
    return found.sort_values([*same, "first", "variant", "way"], kind="stable")


def changes(cells: Cells) -> list[str]:
    """Of a map over which nothing may change: the labels whose verdict or work does."""
    kinds = cells.rows.groupby("label", sort=False)[["verdict", "work"]].nunique().max(axis=1)
    return list(kinds.index[kinds > 1])
