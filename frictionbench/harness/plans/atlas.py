"""The maps of the suite `maps`: how existence, solutions and verdicts depend on the physical parameters of scenes.

They stand in atlas.txt, a paragraph each, in three parts: of first problems, of units, and of simulations. The first line has
the map's name, the scene, both axes, the thresholds and, if it is not the default, the scheme; the next its title; the others
a note. An axis is written as on the command line:

    friction=.1:3:30               30 values from .1 to 3, both ends among them
    mass_ratio=log:1e-6:1e6:13     13 values, a constant factor apart
    jitter=zero:1e-12:1e-2:7       0 and six values, a constant factor apart
    overlap=both:1e-12:1e-1:13     -1e-1 ... -1e-12, 0, 1e-12 ... 1e-1
"""

import math
from pathlib import Path
from typing import Any, get_args

from frictionbench.problems import InputError
from frictionbench.problems.check import require
from frictionbench.problems.scenes import scenes
from frictionbench.problems.spec import parse
from frictionbench.results.maps import Axis, Map, Scale

GAPS = "stewart_trinkle"  # the scheme whose contacts keep their gaps
SCALES = get_args(Scale)
MOST_LINES = 200  # along an axis: finer than a map can show


def atlas() -> tuple[Map, ...]:
    """All of them."""
    text = Path(__file__).with_name("atlas.txt").read_text(encoding="utf-8")
    of_problems, of_units, of_loops = text.split("---\n")
    same = "The same problem in other units, powers of two from 1e-12 to 1e12: not even rounding differs, nothing may change."
    loops = _maps(of_loops, "At most 30 steps of each size.", scheme=GAPS, steps=30, levels=0)
    return (*_maps(of_problems), *_maps(of_units, same, constant=True), *loops)


def _maps(table: str, common_note: str = "", **common: Any) -> tuple[Map, ...]:
    """The maps in a text. common: fields that all have."""
    found = []
    for block in table.strip().split("\n\n"):
        head, title, *note = map(str.strip, block.splitlines())
        name, spec, x, y, *more = head.split()
        scene, parameters = parse("scene", spec)
        schemes: Any = dict(each.split("=") for each in more if "=" in each)
        thresholds = tuple(each for each in more if "=" not in each)
        axes = axis("x", x, scene), axis("y", y, scene)
        told = " ".join(note) or common_note
        found.append(Map(name, scene, *axes, parameters, thresholds=thresholds, title=title, note=told, **schemes | common))
    return tuple(found)


def axis(field: str, text: str, name: str) -> Axis:
    """The axis of a scene's parameter that a text describes. Errors: InputError naming the field."""
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
