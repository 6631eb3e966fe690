"""Hinges: revolute joints, which hold a point of one body on a point of another, or of the ground."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from problems import check
from problems.check import Array, require


@dataclass(frozen=True, eq=False)
class Hinge:
    """bodies: the two bodies' numbers, -1 for the ground. points: (2, 2), m, the pin's place in each one's own frame.

    Bodies on a common hinge do not collide with each other.
    """

    bodies: tuple[int, int]
    points: Array

    def __post_init__(self) -> None:
        require(self.bodies[0] != self.bodies[1] and min(self.bodies) >= -1, "bodies", f"expected two, got {self.bodies}")
        points = check.vector("points", np.ravel(self.points), 4).reshape(2, 2)
        object.__setattr__(self, "points", points)


def hinge_equations(hinges: tuple[Hinge, ...], q: Array) -> tuple[Array, sparse.csr_array]:
    """How far apart each hinge's two points are, Theta (2 hinges,), m, x before y, and its Jacobian F (2 hinges, nv)."""
    theta = np.zeros((len(hinges), 2))
    rows: list[int] = []
    columns: list[int] = []
    entries: list[float] = []
    for k, hinge in enumerate(hinges):
        for body, point, sign in zip(hinge.bodies, hinge.points, (1.0, -1.0), strict=True):
            if body < 0:
                theta[k] += sign * point
                continue
            x, y, angle = q[3 * body : 3 * body + 3]
            cos, sin = np.cos(angle), np.sin(angle)
            arm = np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])
            theta[k] += sign * (np.array([x, y]) + arm)
            rows += [2 * k, 2 * k + 1, 2 * k, 2 * k + 1]
            columns += [3 * body, 3 * body + 1, 3 * body + 2, 3 * body + 2]
            entries += [sign, sign, -sign * arm[1], sign * arm[0]]
    F = sparse.coo_array((entries, (rows, columns)), shape=(2 * len(hinges), len(q)))
    return theta.ravel(), sparse.csr_array(F)
