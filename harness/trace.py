"""Thresholds of theory traced over a map: where along its grid lines, and lines between, a property of the problem changes.

Each line is looked at in steps of half a grid line, and a change is narrowed down by bisection. No solver takes part.
"""

import json
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from frictionbench.harness.cells.collect import first_problem_of
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.analysis.thresholds import THRESHOLDS
from frictionbench.results.files import subfolder, write_text
from frictionbench.results.map_spec import Axis, GridPoint, Map, thresholds_file

LINES = 11
HALVINGS = 7


def trace(spec: Map, folder: Path) -> None:
    """Leave the map's thresholds in folder, unless they are there."""
    path = thresholds_file(folder, spec)
    if not spec.thresholds or path.exists():
        return
    subfolder(folder, path.parent.name)
    found = {name: crossings(spec, THRESHOLDS[name]) for name in spec.thresholds}
    write_text(path, json.dumps(found))


def crossings(spec: Map, holds: Callable[[FrictionProblem], bool]) -> list[GridPoint]:
    """The places on lines along both axes where `holds` changes."""

    @cache
    def at(i: float, j: float) -> bool:
        stage = scene(spec.scene, **spec.at((i, j)))
        return holds(first_problem_of(stage, spec.scheme))

    upwards = [(i, j) for i in _lines(spec.x) for j in _changes(spec.y, lambda j, i=i: at(i, j))]  # type: ignore[misc]
    across = [(i, j) for j in _lines(spec.y) for i in _changes(spec.x, lambda i, j=j: at(i, j))]  # type: ignore[misc]
    return sorted({*upwards, *across})


def _lines(axis: Axis) -> list[float]:
    count = axis.count if axis.whole else max(LINES, axis.count)
    return [float(place) for place in np.linspace(0, axis.count - 1, count)]


def _changes(axis: Axis, holds: Callable[[float], bool]) -> list[float]:
    steps = [k / 2 for k in range(2 * axis.count - 1)]
    places = []
    for low, high in pairwise(steps):
        if holds(low) == holds(high):
            continue
        a, b = low, high
        for _ in range(0 if axis.whole else HALVINGS):
            middle = (a + b) / 2
            a, b = (middle, b) if holds(middle) == holds(low) else (a, middle)
        places.append((a + b) / 2)
    return places
