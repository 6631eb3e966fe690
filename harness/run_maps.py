"""Maps run: the problems of their grids first, then the places between that a finer grid adds where verdicts differ.

A map needs nothing that a run does not do. Each round is the run of a plan with more places, in the same folder, so that what
was broken off goes on where it stopped: what to refine follows from the rows that are there. At the end the thresholds of
theory are traced over each map, and of each map and exact solver the smallest failure is made smaller still.
"""

from dataclasses import replace
from pathlib import Path

from frictionbench.harness.plans import map_grid
from frictionbench.harness.plans.plan import Plan
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.shrink import ENOUGH, shrink_rows
from frictionbench.harness.trace import trace
from frictionbench.results import store
from frictionbench.results.map_rows import THEORY, at_grid_points, failed_rows
from frictionbench.results.map_spec import GridPoint, Map
from frictionbench.results.shrunk import read_shrunk, write_shrunk
from frictionbench.results.store import Row

MOST_SHRUNK = 100  # failures


def run_maps(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run a plan that has maps. Errors: as of harness.run.run."""
    known: list[dict[GridPoint, None]] = [dict.fromkeys(spec.grid) for spec in plan.maps]
    for level in range(max(spec.levels for spec in plan.maps) + 1):
        if level:
            _refine(plan.maps, known, level, folder)
        run(_with_places(plan, known), folder, jobs, progress, cluster)
    for spec in plan.maps:
        trace(spec, folder)
    _keep_failures(plan, folder, jobs, progress)


def _keep_failures(plan: Plan, folder: Path, jobs: int, progress: Progress) -> None:
    """Shrink the smallest failure of each exact solver on each map, where theory says that its problem's parts have a solution,
    too."""
    solves, found = store.read_table(folder, "solves"), read_shrunk(folder)
    failed: list[Row] = []
    for rows in (failed_rows(at_grid_points(solves, spec)) for spec in plan.maps if not spec.steps):
        failed += rows[rows["existence"].isin(THEORY)].drop_duplicates("variant").to_dict("records")
    failed = failed[:MOST_SHRUNK]
    left = [row for row in failed if row["key"] not in found]
    with progress.stage("failures made small", len(failed), len(failed) - len(left)) as stage:
        for row, small in shrink_rows(folder, left, plan.plugins, plan.memory_limit, jobs, ENOUGH):
            found[row["key"]] = small
            write_shrunk(folder, found)
            stage.advance()


def _refine(specs: tuple[Map, ...], known: list[dict[GridPoint, None]], level: int, folder: Path) -> None:
    rows = [row for table in ("solves", "simulations") for row in store.rows(folder, table)]
    found = map_grid.verdicts(rows)
    for spec, places in zip(specs, known, strict=True):
        if level <= spec.levels:
            places.update(dict.fromkeys(map_grid.finer(spec, set(places), level, found)))


def _with_places(plan: Plan, known: list[dict[GridPoint, None]]) -> Plan:
    both = list(zip(plan.maps, known, strict=True))
    found = tuple(source for spec, places in both for source in map_grid.sources(spec, places))
    simulated = tuple(cell for spec, places in both for cell in map_grid.simulation_cells(spec, places, plan))
    return replace(plan, map_sources=tuple({source.key: source for source in found}.values()), map_simulations=simulated)
