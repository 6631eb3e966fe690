"""Failure maps: their grids, their runs, and the theoretical thresholds drawn over them.

First the grid points are run, then points midway between neighbours whose verdicts differ, by a plan with more points in the
same folder. These follow from the verdicts at the grid points, so that an interrupted run resumes. At the end the theoretical
thresholds of each map are traced along lines by bisection, without a solver.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from frictionbench.harness.plans.atlas import axis
from frictionbench.harness.plans.plan import Plan, Plugin, SimulationCell, Source
from frictionbench.harness.plans.suites import MAPPED
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import now, run
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.analysis.thresholds import THRESHOLDS
from frictionbench.problems.catalogue import find_scene, scene
from frictionbench.problems.schemes import require_scheme
from frictionbench.problems.simulate import first_problem_of
from frictionbench.problems.spec import parse
from frictionbench.results import store
from frictionbench.results.conventions import DEFAULT_SCHEME, count
from frictionbench.results.files import subfolder, write_text
from frictionbench.results.maps import Axis, GridPoint, Map, at_grid_points, thresholds_file

SOLVERS = (*MAPPED, "relaxation_ip")  # default solvers of a map
REPEATS = 2  # timed solves: a map shows times by colour, which need not be accurate
LINES = 11  # least number of lines along each axis, so that a curve drawn through the points looks smooth
HALVINGS = 7  # bisections of half a grid spacing, down to 1/256 of the spacing: finer than a printed map shows
Verdicts = dict[GridPoint, dict[str, str]]  # verdict by grid point and variant


def plan_map(
    scene_spec: str,
    x: str,
    y: str,
    variants: tuple[str, ...] = (),
    plugins: tuple[Plugin, ...] = (),
    tol: float = 1e-6,
    time_limit: float = 1.0,
    scheme: str = DEFAULT_SCHEME,
    steps: int = 0,
) -> Plan:
    """Return the plan of one map, of simulations if steps > 0. No scene is built. Errors: InputError naming the field."""
    name, settings = parse("scene", scene_spec)
    find_scene(name, settings)
    require_scheme(scheme)
    across, upwards = axis("x", x, name), axis("y", y, name)
    if across.parameter == upwards.parameter:
        raise InputError(f"y: {upwards.parameter} is already on the other axis; name another parameter")
    spec = Map(
        name=f"{name}_{across.parameter}_{upwards.parameter}",
        scene=name,
        x=across,
        y=upwards,
        parameters=settings,
        scheme=scheme,
        steps=steps,
        most=across.count * upwards.count,
        thresholds=() if steps else ("p", "P0", "pointed", "gaps"),
        title=scene_spec,
    )
    return Plan(
        suite="map",
        sources=(),
        solvers=variants or SOLVERS,
        tolerances=(tol,),
        simulation_solvers=variants or SOLVERS,
        simulation_tol=tol,
        maps=(spec,),
        time_limit=time_limit,
        plugins=plugins,
    )


def corners(spec: Map) -> list[GridPoint]:
    """Return the four corners of the grid."""
    return [(x, y) for x in (0.0, spec.x.count - 1.0) for y in (0.0, spec.y.count - 1.0)]


def finer(spec: Map, verdicts: Verdicts) -> list[GridPoint]:
    """Return at most spec.most points midway between neighbouring grid points with different verdicts, most differences first.

    verdicts: those at other points, which an interrupted run may have found, are ignored, so that a resumed run adds the same.
    """
    gain: dict[GridPoint, int] = {}
    for i, j in spec.grid:
        here = verdicts.get((i, j), {})
        for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
            there = verdicts.get((i + di, j + dj), here)
            changes = sum(there.get(variant) != verdict for variant, verdict in here.items())
            between = (i + di / 2, j + dj / 2)
            if changes:
                gain[between] = max(gain.get(between, 0), changes)
    seen = {json.dumps(spec.at(point), sort_keys=True) for point in spec.grid}
    new: list[GridPoint] = []
    for point in sorted(gain, key=lambda point: (-gain[point], point)):
        parameters = json.dumps(spec.at(point), sort_keys=True)
        if parameters not in seen and len(new) < spec.most:
            seen.add(parameters)
            new.append(point)
    return new


def trace(spec: Map, folder: Path) -> None:
    """Write the map's thresholds to folder, unless it has them."""
    path = thresholds_file(folder, spec)
    if not spec.thresholds or path.exists():
        return
    subfolder(folder, path.parent.name)
    write_text(path, json.dumps({name: crossings(spec, THRESHOLDS[name]) for name in spec.thresholds}))


def crossings(spec: Map, holds: Callable[[FrictionProblem], bool]) -> list[GridPoint]:
    """Return the points on lines along both axes where `holds` changes."""

    @cache
    def at(i: float, j: float) -> bool:
        return holds(first_problem_of(scene(spec.scene, **spec.at((i, j))), spec.scheme))

    upwards = [(i, j) for i in _lines(spec.x) for j in _changes(spec.y, lambda j, i=i: at(i, j))]  # type: ignore[misc]
    across = [(i, j) for j in _lines(spec.y) for i in _changes(spec.x, lambda i, j=j: at(i, j))]  # type: ignore[misc]
    return sorted({*upwards, *across})


def _lines(axis: Axis) -> list[float]:
    count = axis.count if axis.whole else max(LINES, axis.count)
    return [float(line) for line in np.linspace(0, axis.count - 1, count)]


def _changes(axis: Axis, holds: Callable[[float], bool]) -> list[float]:
    steps = [k / 2 for k in range(2 * axis.count - 1)]
    points = []
    for low, high in pairwise(steps):
        if holds(low) == holds(high):
            continue
        a, b = low, high
        for _ in range(0 if axis.whole else HALVINGS):
            middle = (a + b) / 2
            a, b = (middle, b) if holds(middle) == holds(low) else (a, middle)
        points.append((a + b) / 2)
    return points


def run_maps(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run a plan that has maps. Errors: as for harness.run.run."""
    points = [spec.grid for spec in plan.maps]
    run(_with_points(plan, points), folder, jobs, progress, cluster)
    tables = {table: store.read_table(folder, table) for table in ("solves", "simulations")}
    added = [_added(spec, tables["simulations" if spec.steps else "solves"]) for spec in plan.maps]
    if number := sum(map(len, added)):
        progress.tell(f"{count(number, 'point')} added where verdicts differ between neighbours")
        run(_with_points(plan, [grid + new for grid, new in zip(points, added, strict=True)]), folder, jobs, progress, cluster)
    for spec in plan.maps:
        trace(spec, folder)
    store.write_manifest(folder, store.read_manifest(folder) | {"finished": now()})


def _added(spec: Map, rows: pd.DataFrame) -> list[GridPoint]:
    """Return the points that refine a map. rows: of its table."""
    verdicts: Verdicts = {}
    for row in at_grid_points(rows, spec).itertuples():
        verdicts.setdefault((row.i, row.j), {})[row.variant] = row.verdict
    return finer(spec, verdicts) if spec.refined else []


def _with_points(plan: Plan, points: list[list[GridPoint]]) -> Plan:
    """Return the plan with the problems at these grid points. A map of simulations has simulations there instead, none longer
    than the scene's duration."""
    sources: dict[str, Source] = {}
    cells: list[SimulationCell] = []
    for spec, parameters in ((spec, spec.at(point)) for spec, known in zip(plan.maps, points, strict=True) for point in known):
        if spec.steps:
            steps = min(spec.steps, scene(spec.scene, **parameters).steps)
            given = spec.scene, parameters
            cells += [SimulationCell(*given, v, plan.simulation_tol, spec.scheme, steps) for v in plan.simulation_solvers]
        else:
            source = Source(spec.scene, parameters, scheme=spec.scheme, repeats=REPEATS)
            sources[source.key] = source
    return replace(plan, map_sources=tuple(sources.values()), map_simulations=tuple(cells))
