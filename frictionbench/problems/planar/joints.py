"""Hinges: revolute joints, which fix a point of one body to a point of another, or of the ground."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.rows import Rows, relative


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
    bodies, points = _as_arrays(hinges)
    of_bodies = check.vector("q", q)[3 * bodies[:, :, None] + np.arange(3)]
    pose = np.where(bodies[:, :, None] >= 0, of_bodies, 0.0)
    cos, sin = np.cos(pose[:, :, 2:]), np.sin(pose[:, :, 2:])
    arms = cos * points + sin * points[:, :, ::-1] * [-1.0, 1.0]
    theta = (pose[:, 0, :2] + arms[:, 0]) - (pose[:, 1, :2] + arms[:, 1])
    spins = arms.transpose(0, 2, 1)[:, ::-1] * [[-1.0], [1.0]]
    return theta.ravel(), relative(bodies, np.broadcast_to(np.eye(2), arms.shape), spins[..., None])


@lru_cache(maxsize=64)
def _as_arrays(hinges: tuple[Hinge, ...]) -> tuple[NDArray[np.int64], Array]:
    """The bodies (hinges, 2) and points (hinges, 2, 2) of the hinges."""
    bodies = np.array([hinge.bodies for hinge in hinges], np.int64).reshape(-1, 2)
    return bodies, np.array([hinge.points for hinge in hinges]).reshape(-1, 2, 2)
