"""The slider-crank in its three independent coordinates, without hinges."""

from dataclasses import dataclass

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array
from frictionbench.problems.generalised import ReducedScene
from frictionbench.problems.scenes.mechanisms import CRANK, ROD, slider_crank


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SliderCrankAngles(ReducedScene):
    """q = (a, b, c), the angles of crank, rod and slider."""

    def place(self, q: Array) -> Array:
        return _centres(CRANK * _unit(q[0]), ROD * _unit(q[1]), q)

    def slopes(self, q: Array) -> Array:
        a, b, none = CRANK * _across(q[0]), ROD * _across(q[1]), np.zeros(2)
        turns = np.eye(3)
        return np.column_stack([_centres(a, none, turns[0]), _centres(none, b, turns[1]), _centres(none, none, turns[2])])

    def bend(self, q: Array, v: Array) -> Array:
        return _centres(-CRANK * _unit(q[0]) * v[0] ** 2, -ROD * _unit(q[1]) * v[1] ** 2, np.zeros(3))


def _centres(crank: Array, rod: Array, turns: Array) -> Array:
    """(9,): the bodies' centres and angles for the vectors (2,) along crank and rod."""
    ends = crank / 2, crank + rod / 2, crank + rod
    return np.concatenate([[*end, turn] for end, turn in zip(ends, turns, strict=True)])


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _across(angle: float) -> Array:
    return np.array([-np.sin(angle), np.cos(angle)])


@generator()
def slider_crank_angles(
    friction: float = 0.01,
    restitution: float = 0.4,
    clearance: float = 0.001,
    speed: float = 150.0,
    tilt: float = 0.0,
    angle: float = 0.0,
    step: float = 1e-4,
    duration: float = 0.08,
) -> SliderCrankAngles:
    """The slider-crank in generalised coordinates: the angles of crank, rod and slider, which its clearance leaves free.

    The same motion as slider_crank, without joint equations and their drift. Parameters as there.
    """
    full = slider_crank(friction, restitution, clearance, speed, tilt, angle, step, duration)
    at = np.array([2, 5, 8])
    return SliderCrankAngles(
        full=full,
        q0=full.q0[at],
        v0=full.v0[at],
        size=full.reach,
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )
