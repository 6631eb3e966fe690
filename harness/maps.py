"""Maps run: the problems of their grids first, then the places between that a finer grid adds where verdicts differ.

A map needs nothing that a run does not do. Each round is the run of a plan with more places, in the same folder, so that what
was broken off goes on where it stopped: what to refine follows from the rows that are there. At the end the thresholds of
theory are traced over each map.
"""

from dataclasses import replace
from pathlib import Path

from harness.plans import maps
from harness.plans.plan import Plan
from harness.progress import Progress
from harness.run import run
from harness.trace import trace
from results import store
from results.maps import Map, Place


def run_maps(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run a plan and its maps. Errors: as of harness.run.run."""
    known: list[dict[Place, None]] = [dict.fromkeys(spec.grid) for spec in plan.maps]
    for level in range(max((spec.levels for spec in plan.maps), default=0) + 1):
        if level:
            _refine(plan.maps, known, level, folder)
        run(_with_places(plan, known), folder, jobs, progress, cluster)
    for spec in plan.maps:
        trace(spec, folder)


def _refine(specs: tuple[Map, ...], known: list[dict[Place, None]], level: int, folder: Path) -> None:
    rows = [row for table in ("solves", "drives") for row in store.rows(folder, table)]
    found = maps.verdicts(rows)
    for spec, places in zip(specs, known, strict=True):
        if level <= spec.levels:
            places.update(dict.fromkeys(maps.finer(spec, set(places), level, found)))


def _with_places(plan: Plan, known: list[dict[Place, None]]) -> Plan:
    both = list(zip(plan.maps, known, strict=True))
    placed = tuple(source for spec, places in both for source in maps.sources(spec, places))
    driven = tuple(cell for spec, places in both for cell in maps.drive_cells(spec, places, plan))
    return replace(plan, placed=tuple({source.key: source for source in placed}.values()), placed_drives=driven)
