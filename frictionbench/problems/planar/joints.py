"""Hinges: revolute joints, which fix a point of one body to a point of another, or of the ground."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import kernel
from frictionbench.problems.rows import Rows


@dataclass(frozen=True, eq=False)
class Hinge:
    """bodies: the two bodies' numbers, -1 for the ground. points: (2, 2), m, the pin in each body's frame.

    Bodies on a common hinge do not collide with each other.
    """

    bodies: tuple[int, int]
    points: Array

    def __post_init__(self) -> None:
        require(self.bodies[0] != self.bodies[1] and min(self.bodies) >= -1, "bodies", f"must be two, got {self.bodies}")
        points = check.vector("points", np.ravel(self.points), 4).reshape(2, 2)
        object.__setattr__(self, "points", points)


def hinge_equations(hinges: tuple[Hinge, ...], q: Array) -> tuple[Array, Rows]:
    """The difference of each hinge's two points, Theta (2 hinges,), m, x before y, and its Jacobian F by rows."""
    theta, *rows = _equations(*_as_arrays(hinges), check.vector("q", q))
    return theta, Rows(*rows)


@lru_cache(maxsize=64)
def _as_arrays(hinges: tuple[Hinge, ...]) -> tuple[NDArray[np.int64], Array]:
    """The bodies (hinges, 2) and points (hinges, 2, 2) of the hinges."""
    bodies = np.array([hinge.bodies for hinge in hinges], np.int64).reshape(-1, 2)
    return bodies, np.array([hinge.points for hinge in hinges]).reshape(-1, 2, 2)


@kernel
def _equations(bodies, points, q):  # type: ignore[no-untyped-def]
    theta, at = np.zeros(2 * len(bodies)), 0
    start = np.zeros(2 * len(bodies) + 1, np.int32)
    column, value = np.empty(8 * len(bodies), np.int32), np.empty(8 * len(bodies))
    for k in range(len(bodies)):
        for axis in range(2):
            for n in range(2):  # columns ascending
                side = n if bodies[k, 0] < bodies[k, 1] else 1 - n
                body, sign, x, y = bodies[k, side], 1.0 if side == 0 else -1.0, points[k, side, 0], points[k, side, 1]
                if body < 0:
                    theta[2 * k + axis] += sign * (y if axis else x)
                    continue
                cos, sin = np.cos(q[3 * body + 2]), np.sin(q[3 * body + 2])
                arm, across = cos * x - sin * y, sin * x + cos * y
                if axis:
                    arm, across = across, -arm
                theta[2 * k + axis] += sign * (q[3 * body + axis] + arm)
                column[at], value[at] = 3 * body + axis, sign
                at += 1
                if across != 0:
                    column[at], value[at] = 3 * body + 2, -sign * across
                    at += 1
            start[2 * k + axis + 1] = at
    return theta, start, column[:at], value[:at]
