"""Runs of plans with failure maps: first the grid points, then the points of finer grids where verdicts differ.

Each round is the run of a plan with more grid points, in the same folder, so that an interrupted run resumes: which points to
add follows from the rows found. At the end the thresholds of theory are traced over each map, its scene's first steps
are recorded, and for each map and exact solver the smallest failing problem is reduced further.
"""

from dataclasses import replace
from pathlib import Path

from frictionbench.harness.first_steps import store_first_steps
from frictionbench.harness.plans import map_grid
from frictionbench.harness.plans.plan import Plan
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.shrink import ENOUGH, shrink_rows
from frictionbench.harness.trace import trace
from frictionbench.results import store
from frictionbench.results.extras import read_shrunk, write_shrunk
from frictionbench.results.maps import THEORY, GridPoint, Map, at_grid_points, failed_rows
from frictionbench.results.store import Row

MOST_SHRUNK = 100  # failures: with shrink.ENOUGH seconds each, a quarter of an hour at most


def run_maps(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run a plan that has maps. Errors: as of harness.run.run."""
    points: list[dict[GridPoint, None]] = [dict.fromkeys(spec.grid) for spec in plan.maps]
    for level in range(max(spec.levels for spec in plan.maps) + 1):
        if level:
            _refine(plan.maps, points, level, folder)
        run(_with_points(plan, points), folder, jobs, progress, cluster)
    for spec in plan.maps:
        trace(spec, folder)
        store_first_steps(spec, folder)
    _shrink_failures(plan, folder, jobs, progress)


def _shrink_failures(plan: Plan, folder: Path, jobs: int, progress: Progress) -> None:
    """Shrink the smallest failure of each exact solver on each map, where theory guarantees a solution also of the problem with
    fewer contacts."""
    solves, shrunk = store.read_table(folder, "solves"), read_shrunk(folder)
    failed: list[Row] = []
    for rows in (failed_rows(at_grid_points(solves, spec)) for spec in plan.maps if not spec.steps):
        failed += rows[rows["existence"].isin(THEORY)].drop_duplicates("variant").to_dict("records")
    failed = failed[:MOST_SHRUNK]
    left = [row for row in failed if row["key"] not in shrunk]
    with progress.stage("failures shrunk", len(failed), len(failed) - len(left)) as stage:
        for row, small in shrink_rows(folder, left, plan.plugins, plan.memory_limit, jobs, ENOUGH):
            shrunk[row["key"]] = small
            write_shrunk(folder, shrunk)
            stage.advance()


def _refine(specs: tuple[Map, ...], points: list[dict[GridPoint, None]], level: int, folder: Path) -> None:
    rows = [row for table in ("solves", "simulations") for row in store.rows(folder, table)]
    found = map_grid.verdicts(rows)
    for spec, known in zip(specs, points, strict=True):
        if level <= spec.levels:
            known.update(dict.fromkeys(map_grid.finer(spec, set(known), level, found)))


def _with_points(plan: Plan, points: list[dict[GridPoint, None]]) -> Plan:
    both = list(zip(plan.maps, points, strict=True))
    sources = tuple(source for spec, known in both for source in map_grid.sources(spec, known))
    simulated = tuple(cell for spec, known in both for cell in map_grid.simulation_cells(spec, known, plan))
    return replace(plan, map_sources=tuple({source.key: source for source in sources}.values()), map_simulations=simulated)
