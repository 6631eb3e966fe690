"""The grid of a failure map: its axes from the command line, the problems at its points, and the points of its refinement.

friction=.1:3:30               30 values from .1 to 3, both ends among them
mass_ratio=log:1e-6:1e6:13     13 values, a constant factor apart
jitter=zero:1e-12:1e-2:7       0 and six values, a constant factor apart
overlap=both:1e-12:1e-1:13     -1e-1 ... -1e-12, 0, 1e-12 ... 1e-1
"""

import json
from collections.abc import Iterable, Mapping
from typing import get_args

from frictionbench.harness.plans.plan import Plan, SimulationCell, Source
from frictionbench.problems import InputError
from frictionbench.problems.scenes import scene, scenes
from frictionbench.results.conventions import first_phase
from frictionbench.results.maps import Axis, GridPoint, Map, Scale
from frictionbench.results.store import Row

SCALES = get_args(Scale)
MOST_LINES = 200  # along an axis: finer than a map can show
REPEATS = 2  # timed solves: a map shows times by colour, to a factor
Verdicts = dict[str, dict[str, str]]  # by `location`, then by variant


def axis(field: str, text: str, name: str) -> Axis:
    """The axis of a scene's parameter that a text describes. Errors: InputError naming the field."""
    parameter, _, values = text.partition("=")
    *scale, low, high, count = values.split(":") if values.count(":") in (2, 3) else ("", "", "", "", "")
    try:
        found = Axis(parameter.strip(), float(low), float(high), int(count), *scale)  # type: ignore[arg-type]
    except ValueError:
        raise InputError(f"{field}: cannot read {text!r}; write PARAMETER=FROM:TO:N or PARAMETER=log:FROM:TO:N") from None
    if found.scale not in SCALES:
        raise InputError(f"{field}: unknown scale {found.scale!r}; known are {', '.join(SCALES)}")
    if found.scale != "linear" and not 0 < found.low < found.high:
        raise InputError(f"{field}: {text!r} needs 0 < FROM < TO")
    if not found.low < found.high or not 2 <= found.count <= MOST_LINES:
        raise InputError(f"{field}: {text!r} needs FROM < TO and 2 to {MOST_LINES} values")
    if found.scale == "both" and found.count % 2 == 0:
        raise InputError(f"{field}: {text!r} needs an odd number of values, one of them 0")
    whole = isinstance(scenes()[name].parameters.get(found.parameter), int) if name in scenes() else False
    return Axis(found.parameter, found.low, found.high, found.count, found.scale, whole)


def corners(spec: Map) -> list[GridPoint]:
    """The four corners of the grid."""
    return [(x, y) for x in (0.0, spec.x.count - 1.0) for y in (0.0, spec.y.count - 1.0)]


def sources(spec: Map, points: Iterable[GridPoint]) -> list[Source]:
    """The problems at these grid points; none for a map of simulations."""
    if spec.steps:
        return []
    return [Source(spec.scene, spec.at(point), scheme=spec.scheme, repeats=REPEATS) for point in points]


def simulation_cells(spec: Map, points: Iterable[GridPoint], plan: Plan) -> list[SimulationCell]:
    """The simulations at these grid points, no longer than the scene's duration; none for a map of first problems."""
    cells = []
    for point in points if spec.steps else ():
        parameters = spec.at(point)
        steps = min(spec.steps, scene(spec.scene, **parameters).steps)
        cells += [
            SimulationCell(spec.scene, parameters, variant, plan.simulation_tol, spec.scheme, steps)
            for variant in plan.simulation_solvers
        ]
    return cells


def verdicts(rows: Iterable[Row]) -> Verdicts:
    """The verdicts in rows of either table."""
    found: Verdicts = {}
    for row in rows:
        kind = row["scheme"] if "scheme" in row else row.get("phase")
        found.setdefault(location(row["scene"], row["parameters"], str(kind)), {})[row["variant"]] = row["verdict"]
    return found


def finer(spec: Map, known: set[GridPoint], level: int, found: Verdicts) -> list[GridPoint]:
    """At most spec.most new grid points between neighbours whose verdicts differ, those with the most differences first."""
    step = 0.5**level
    verdicts_at = {point: _verdicts_at(spec, point, found) for point in known}
    gain: dict[GridPoint, int] = {}
    for (i, j), own in verdicts_at.items():
        for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
            neighbour = (i + 2 * di * step, j + 2 * dj * step)
            other = verdicts_at.get(neighbour, own)
            changes = sum(other.get(variant) != verdict for variant, verdict in own.items())
            between = (i + di * step, j + dj * step)
            if changes and between not in known:
                gain[between] = max(gain.get(between, 0), changes)
    seen = {json.dumps(spec.at(point), sort_keys=True) for point in known}
    new: list[GridPoint] = []
    for point in sorted(gain, key=lambda point: (-gain[point], point)):
        parameters = json.dumps(spec.at(point), sort_keys=True)
        if parameters not in seen and len(new) < spec.most:
            seen.add(parameters)
            new.append(point)
    return new


def _verdicts_at(spec: Map, point: GridPoint, found: Verdicts) -> Mapping[str, str]:
    kind = spec.scheme if spec.steps else first_phase(spec.scheme)
    return found.get(location(spec.scene, json.dumps(spec.at(point), sort_keys=True), kind), {})


def location(scene_name: str, parameters: str, kind: str) -> str:
    """The scene and parameters of a row, with the problem's phase or the simulation's scheme."""
    return f"{scene_name} {parameters} {kind}"
