"""A ball sliding on a table, in closed loop: a spatial motion with a closed form that needs no collision detection.

The lowest point of a ball of radius R slides at s = v + omega x (0, 0, -R). Friction mu m g against s shortens s and leaves its
direction, s' = -7/2 mu g s/|s|, until the ball rolls at the time 2 |s_0| / (7 mu g). Until then it moves on a straight line
where s_0 is along v_0, ending with 5/7 of its speed if it did not spin, and on a parabola otherwise. With a polygon in place of
Coulomb's cone friction acts along one of the corners, which turns s and bends the path: this shows the polygon's error. Angular
momentum about the lowest point is conserved, so that the velocity of rolling does not depend on the section.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import GROUND, touching
from frictionbench.problems.scene import GRAVITY

MASS, RADIUS = 1.0, 0.1  # kg, m
SPEED, SIDE_SPIN, FRICTION = 2.0, 14.0, 0.3  # m/s, 1/s, none: the lowest point then slides at (2, 1.4) m/s at first
UPRIGHT = np.array([[[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]])


class Path(NamedTuple):
    """time (steps+1,); place (steps+1, 2) on the table, m; velocity (steps+1, 6), translation and spin."""

    time: Array
    place: Array
    velocity: Array

    @property
    def slip(self) -> Array:
        """The velocity of the lowest point (steps+1, 2)."""
        v = self.velocity
        return np.column_stack([v[:, 0] - RADIUS * v[:, 4], v[:, 1] + RADIUS * v[:, 3]])


def problem(velocity: Array, friction: float, step: float) -> FrictionProblem:
    """Anitescu and Potra's problem of one step from a velocity (6,)."""
    free = velocity.copy()
    free[2] -= GRAVITY * step
    inertia = 0.4 * MASS * RADIUS**2
    weights = np.array([[MASS] * 3 + [inertia] * 3])
    return touching(np.array([[0, GROUND]]), np.array([[[0, 0, -RADIUS], [0, 0, 0]]]), UPRIGHT, weights, free[None], friction)


def roll(
    solve: Callable[[FrictionProblem], Array],
    velocity: tuple[float, float],
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    friction: float = FRICTION,
    step: float = 0.01,
    steps: int = 100,
) -> Path:
    """The path of a ball set down with a velocity, m/s, and a spin, 1/s; solve gives the impulses (1, 3) of a problem."""
    states, place = [np.array([*velocity, 0.0, *spin])], [np.zeros(2)]
    for _ in range(steps):
        met = problem(states[-1], friction, step)
        states.append(met.velocity(solve(met)))
        place.append(place[-1] + step * states[-1][:2])
    return Path(np.arange(steps + 1.0) * step, np.array(place), np.array(states))


def slide(solve: Callable[[FrictionProblem], Array], step: float) -> tuple[Array, Array]:
    """The path (steps+1, 2), m, of a ball set down with a side spin, for as long as it slides, and the parabola it is on."""
    slip = np.array([SPEED, RADIUS * SIDE_SPIN])
    speed = float(np.linalg.norm(slip))
    steps = int(2 * speed / (7 * FRICTION * GRAVITY) / step)
    path = roll(solve, (SPEED, 0.0), (SIDE_SPIN, 0.0, 0.0), step=step, steps=steps)
    bend = FRICTION * GRAVITY / 2 * np.outer(path.time**2, slip / speed)
    return path.place, np.outer(path.time, [SPEED, 0.0]) - bend


def apart(one: Array, other: Array) -> float:
    """The largest distance of two paths at the same times, m."""
    return float(np.linalg.norm(one - other, axis=1).max())
