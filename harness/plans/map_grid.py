"""Maps as work: the problems at their places, the places that refinement adds, and a map as the command line writes it.

friction=.1:3:30               30 values from .1 to 3, both ends among them
mass_ratio=log:1e-6:1e6:13     13 values, a constant factor apart
jitter=zero:1e-12:1e-2:7       0 and six values, a constant factor apart
overlap=both:1e-12:1e-1:13     -1e-1 ... -1e-12, 0, 1e-12 ... 1e-1
"""

import json
from collections.abc import Iterable, Mapping

from frictionbench.harness.plans.plan import Plan, SimulationCell, Source
from frictionbench.problems import InputError, scene, scenes
from frictionbench.results.conventions import first_phase
from frictionbench.results.map_spec import Axis, GridPoint, Map
from frictionbench.results.store import Row

SCALES = ("linear", "log", "zero", "both")
MOST_LINES = 200
REPEATS = 2  # a map's second layer tells times to a factor; a table of times needs more
Verdicts = dict[str, dict[str, str]]  # by where a problem comes from (see `home`), then by variant


def axis(field: str, text: str, name: str) -> Axis:
    """An axis of the scene of that name, from its text. Errors: InputError naming the field."""
    parameter, _, told = text.partition("=")
    *scale, low, high, count = told.split(":") if told.count(":") in (2, 3) else ("", "", "", "", "")
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


def checked(spec: Map) -> Map:
    """The map, if the scene can be made in its corners. Errors: InputError naming the parameter."""
    for place in ((0.0, 0.0), (0.0, spec.y.count - 1.0), (spec.x.count - 1.0, 0.0), (spec.x.count - 1.0, spec.y.count - 1.0)):
        scene(spec.scene, **spec.at(place))
    return spec


def sources(spec: Map, places: Iterable[GridPoint]) -> list[Source]:
    """The problems at these places; none for a map in closed loop."""
    if spec.steps:
        return []
    return [Source(spec.scene, spec.at(place), scheme=spec.scheme, repeats=REPEATS) for place in places]


def simulation_cells(spec: Map, places: Iterable[GridPoint], plan: Plan) -> list[SimulationCell]:
    """The simulations at these places, no longer than the scene's own duration; none for a map of first problems."""
    cells = []
    for place in places if spec.steps else ():
        parameters = spec.at(place)
        steps = min(spec.steps, scene(spec.scene, **parameters).steps)
        cells += [
            SimulationCell(spec.scene, parameters, variant, plan.simulation_tol, spec.scheme, steps)
            for variant in plan.simulation_solvers
        ]
    return cells


def verdicts(rows: Iterable[Row]) -> Verdicts:
    """The verdicts of rows of either table."""
    found: Verdicts = {}
    for row in rows:
        told = row["scheme"] if "scheme" in row else row.get("phase")
        found.setdefault(home(row["scene"], row["parameters"], str(told)), {})[row["variant"]] = row["verdict"]
    return found


def finer(spec: Map, known: set[GridPoint], level: int, found: Verdicts) -> list[GridPoint]:
    """New places between known ones of the level before whose verdicts differ, those with the most changes first."""
    step = 0.5**level
    told = {place: _verdicts_at(spec, place, found) for place in known}
    gain: dict[GridPoint, int] = {}
    for (i, j), own in told.items():
        for di, dj in ((1, 0), (0, 1), (1, 1), (1, -1)):
            neighbour = (i + 2 * di * step, j + 2 * dj * step)
            other = told.get(neighbour, own)
            changes = sum(other.get(variant) != verdict for variant, verdict in own.items())
            between = (i + di * step, j + dj * step)
            if changes and between not in known:
                gain[between] = max(gain.get(between, 0), changes)
    seen = {json.dumps(spec.at(place), sort_keys=True) for place in known}
    new: list[GridPoint] = []
    for place in sorted(gain, key=lambda place: (-gain[place], place)):
        where = json.dumps(spec.at(place), sort_keys=True)
        if where not in seen and len(new) < spec.most:
            seen.add(where)
            new.append(place)
    return new


def _verdicts_at(spec: Map, place: GridPoint, found: Verdicts) -> Mapping[str, str]:
    told = spec.scheme if spec.steps else first_phase(spec.scheme)
    return found.get(home(spec.scene, json.dumps(spec.at(place), sort_keys=True), told), {})


def home(scene_name: str, parameters: str, told: str) -> str:
    """Where a row's problem or simulation comes from."""
    return f"{scene_name} {parameters} {told}"
