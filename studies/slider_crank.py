"""The slider-crank in its three independent coordinates, without hinges: no joint equations are left, and nothing drifts."""

from dataclasses import dataclass
from typing import Any

import numpy as np

import frictionbench as fb
from frictionbench.problems import GeneralisedScene, GivenContacts, Scene, generator
from studies.study import Array

CRANK, ROD = 0.153, 0.306  # m, as those of the scene slider_crank


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SliderCrankAngles(GeneralisedScene):
    """q = (a, b, c), the angles of crank, rod and slider. full: the scene with bodies, whose hinges `place` satisfies."""

    full: Scene

    def place(self, q: Array) -> Array:
        """The coordinates x (9,) of the bodies."""
        return _centres(CRANK * _unit(q[0]), ROD * _unit(q[1]), q)

    def slopes(self, q: Array) -> Array:
        """X = dx/dq (9, 3)."""
        a, b, none = CRANK * _across(q[0]), ROD * _across(q[1]), np.zeros(2)
        turns = np.eye(3)
        return np.column_stack([_centres(a, none, turns[0]), _centres(none, b, turns[1]), _centres(none, none, turns[2])])

    def bend(self, q: Array, v: Array) -> Array:
        """dX/dt v (9,)."""
        return _centres(-CRANK * _unit(q[0]) * v[0] ** 2, -ROD * _unit(q[1]) * v[1] ** 2, np.zeros(3))

    def inertia(self, q: Array) -> Array:
        X = self.slopes(q)
        return np.asarray(X.T @ (self.full.weights[:, None] * X))

    def force(self, q: Array, v: Array, t: float) -> Array:
        X = self.slopes(q)
        pull = self.full.force(self.place(q), X @ v, t) - self.full.weights * self.bend(q, v)
        return np.asarray(X.T @ pull)

    def potential(self, q: Array) -> float:
        return self.full.energy(self.place(q), np.zeros(len(self.full.weights)))

    def contacts(self, q: Array, margin: float | None = None) -> GivenContacts:
        full_contacts, X = self.full.contacts(self.place(q), self.touch if margin is None else margin), self.slopes(q)
        nv = len(X)
        N, T = full_contacts.normal_rows.dense(nv) @ X, full_contacts.tangent_rows.dense(nv) @ X
        return GivenContacts(full_contacts.gap, full_contacts.place, full_contacts.bodies, full_contacts.feature, q, N, T)

    def fastest(self, v: Array) -> float:
        return self.full.fastest(self.slopes(self.q0) @ v)

    def coefficients(self, contacts: Any) -> Array:
        return self.full.coefficients(contacts)

    def poses(self, q: Array) -> Array:
        return self.place(q).reshape(-1, 3)

    @property
    def outlines(self) -> tuple[()]:  # studies draw no motion
        return ()


def _centres(crank: Array, rod: Array, turns: Array) -> Array:
    """(9,): the bodies' centres and angles for the vectors (2,) along crank and rod."""
    ends = crank / 2, crank + rod / 2, crank + rod
    return np.concatenate([[*end, turn] for end, turn in zip(ends, turns, strict=True)])


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _across(angle: float) -> Array:
    return np.array([-np.sin(angle), np.cos(angle)])


@generator(restitution=0.4, step=1e-4, duration=0.08)
def slider_crank_angles(
    friction: float = 0.01, clearance: float = 0.001, speed: float = 150.0, tilt: float = 0.0, angle: float = 0.0
) -> SliderCrankAngles:
    """The slider-crank in generalised coordinates: the angles of crank, rod and slider, which its clearance leaves free.

    The motion is that of slider_crank, without joint equations and their drift. The parameters are the same.
    """
    full = fb.scene("slider_crank", friction=friction, clearance=clearance, speed=speed, tilt=tilt, angle=angle)
    at = np.array([2, 5, 8])
    return SliderCrankAngles(full=full, q0=full.q0[at], v0=full.v0[at], size=full.reach)
