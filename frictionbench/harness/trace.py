"""Thresholds of theory over a map: where a property of the problem changes along grid lines, and along lines between them.

Each line is sampled at steps of half a grid line, and a change is located by bisection. No solver is involved.
"""

import json
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.thresholds import THRESHOLDS
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import first_problem_of
from frictionbench.results.files import subfolder, write_text
from frictionbench.results.maps import Axis, GridPoint, Map, thresholds_file

LINES = 11  # along each axis at least, so that a curve drawn through the points looks smooth
HALVINGS = 7  # of half a grid line: to 1/256 of it, finer than a printed map shows


def trace(spec: Map, folder: Path) -> None:
    """Write the map's thresholds to folder, unless they have been written."""
    path = thresholds_file(folder, spec)
    if not spec.thresholds or path.exists():
        return
    subfolder(folder, path.parent.name)
    found = {name: crossings(spec, THRESHOLDS[name]) for name in spec.thresholds}
    write_text(path, json.dumps(found))


def crossings(spec: Map, holds: Callable[[FrictionProblem], bool]) -> list[GridPoint]:
    """The points on lines along both axes where `holds` changes."""

    @cache
    def at(i: float, j: float) -> bool:
        stage = scene(spec.scene, **spec.at((i, j)))
        return holds(first_problem_of(stage, spec.scheme))

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
