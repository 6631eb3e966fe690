"""Closed forms of motions that scenes in the plane and in space share."""

import numpy as np

from frictionbench.problems.check import Array


def sliding(start: Array, along: Array, speed: float, pull: float, rate: float, time: float) -> Array:
    """The centre (1, d) on a straight line: pull, m/s^2, along it, and friction of up to rate, m/s^2, against it."""
    if speed == 0 and pull <= rate:
        return start[None]
    direction = np.sign(speed) or 1.0
    until = min(time, abs(speed) / (rate - pull)) if rate > pull else time
    return np.array([start + along * (speed * until + direction * (pull - rate) * until**2 / 2)])
