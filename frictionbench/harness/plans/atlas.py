"""The maps of the suite `maps`: how existence, solutions and verdicts depend on the physical parameters of scenes.

The axes are written as on the command line:

    friction=.1:3:30               30 values from .1 to 3, both ends among them
    mass_ratio=log:1e-6:1e6:13     13 values, a constant factor apart
    jitter=zero:1e-12:1e-2:7       0 and six values, a constant factor apart
    overlap=both:1e-12:1e-1:13     -1e-1 ... -1e-12, 0, 1e-12 ... 1e-1
"""

import math
import tomllib
from pathlib import Path
from typing import Any, get_args

from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scenes
from frictionbench.problems.check import require
from frictionbench.problems.spec import parse
from frictionbench.results.maps import Axis, Map, Scale

MAPS = Path(__file__).with_name("atlas.toml")  # by name: the fields of a Map, scene and axes as on the command line
SCALES = get_args(Scale)
MOST_LINES = 200  # values along an axis: finer than a map can show


def atlas() -> tuple[Map, ...]:
    """Return all maps of the suite."""
    maps = []
    for name, entry in tomllib.loads(MAPS.read_text("utf-8")).items():
        scene, parameters = parse("scene", entry.pop("scene"))
        axes = axis("x", entry.pop("x"), scene), axis("y", entry.pop("y"), scene)
        maps.append(Map(name, scene, *axes, parameters, thresholds=tuple(entry.pop("thresholds", ())), **entry))
    return tuple(maps)


def axis(field: str, text: str, name: str) -> Axis:
    """Parse the axis of a scene's parameter. Errors: InputError naming the field."""
    parameter, _, values = text.partition("=")
    *scale, first, last, number = values.split(":") if values.count(":") in (2, 3) else ("", "", "", "", "")
    kind: Any = scale[0] if scale else "linear"
    try:
        low, high, count = float(first), float(last), int(number)
    except ValueError:
        raise InputError(f"{field}: cannot read {text!r}; write PARAMETER=FROM:TO:N or PARAMETER=log:FROM:TO:N") from None
    require(kind in SCALES, field, f"unknown scale {kind!r}; known are {', '.join(SCALES)}")
    require(kind == "linear" or 0 < low < high, field, f"{text!r} needs 0 < FROM < TO")
    many = 0 < high - low < math.inf and 2 <= count <= MOST_LINES
    require(many, field, f"{text!r} needs FROM < TO and 2 to {MOST_LINES} values")
    require(kind != "both" or count % 2 == 1, field, f"{text!r} needs an odd number of values, one of them 0")
    parameter = parameter.strip()
    whole = name in scenes() and isinstance(scenes()[name].parameters.get(parameter), int)
    return Axis(parameter, low, high, count, kind, whole)
