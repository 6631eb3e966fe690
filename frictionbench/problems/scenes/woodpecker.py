"""The woodpecker toy: a sleeve on a pole, a spring, and a woodpecker that pecks its way down."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array
from frictionbench.problems.generalised import GeneralisedScene, GivenContacts
from frictionbench.problems.planar.bodies import Shape, box
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.scene import GRAVITY

POLE, HOLE, HALF_SLEEVE = 0.0025, 0.0031, 0.0058  # m: the radius of the pole and the inner radius and half height of the sleeve
TO_SPRING, TO_BIRD = 0.010, 0.015  # m: from the sleeve to the spring, from the spring to the woodpecker's centre of mass
BEAK_UP, BEAK_OUT = 0.02, 0.0201  # m: from the woodpecker's centre of mass to the tip of its beak
SLEEVE, BIRD = 0.0003, 0.0045  # kg
SLEEVE_INERTIA, BIRD_INERTIA = 5e-9, 7e-7  # kg m^2
SPRING = 0.0056  # N m/rad


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Woodpecker(GeneralisedScene):
    """q = (y, angle of the sleeve, angle of the woodpecker), for small angles. Contacts: beak, lower and upper sleeve edge.

    `restitution` is that of the beak; it is zero at the sleeve's edges.
    """

    arms: ClassVar[Array] = np.array([1.0, TO_SPRING, TO_BIRD])  # the woodpecker's height along the coordinates
    spring: ClassVar[Array] = SPRING * np.array([[0.0, 0, 0], [0, 1, -1], [0, -1, 1]])
    mass_: ClassVar[Array] = BIRD * np.outer(arms, arms) + np.diag([SLEEVE, SLEEVE_INERTIA, BIRD_INERTIA])
    open_: ClassVar[Array] = np.array([TO_SPRING + TO_BIRD - BEAK_OUT - POLE, HOLE - POLE, HOLE - POLE])  # gaps at q = 0
    closing: ClassVar[Array] = np.array([[0, 0, -BEAK_UP], [0, HALF_SLEEVE, 0], [0, -HALF_SLEEVE, 0]])
    sinking: ClassVar[Array] = -np.array([[1, TO_SPRING, TO_BIRD - BEAK_OUT], [1, HOLE, 0], [1, HOLE, 0]])
    heights: ClassVar[Array] = np.array([BEAK_UP, -HALF_SLEEVE, HALF_SLEEVE])

    @property
    def stiffness(self) -> Array:
        return self.spring

    def inertia(self, q: Array) -> Array:
        return self.mass_

    def force(self, q: Array, v: Array, t: float) -> Array:
        weight = BIRD * self.arms + np.array([SLEEVE, 0, 0])
        return np.asarray(-GRAVITY * weight - self.spring @ q)

    def potential(self, q: Array) -> float:
        return float(GRAVITY * (BIRD * self.arms @ q + SLEEVE * q[0]) + q @ self.spring @ q / 2)

    def contacts(self, q: Array, margin: float | None = None) -> GivenContacts:
        gap = self.open_ + self.closing @ q
        height = q[0] + np.array([TO_SPRING * q[1] + TO_BIRD * q[2], 0, 0]) + self.heights
        place = np.column_stack([np.full(3, POLE), height, np.ones(3), np.zeros(3)])
        bodies, feature = np.array([[2, -1], [0, -1], [0, -1]]), np.array([[0, 0], [1, 0], [2, 0]])
        touching = gap <= (self.touch if margin is None else margin)
        return GivenContacts(gap, place, bodies, feature, q, self.closing, self.sinking).only(touching)

    def coefficients(self, contacts: Contacts) -> Array:
        return np.full(len(contacts), self.friction)

    def restitutions(self, contacts: Contacts) -> Array:
        return np.where(contacts.feature[:, 0] == 0, self.restitution, 0.0)

    def poses(self, q: Array) -> Array:
        y, sleeve, bird = q
        spring = y + TO_SPRING * sleeve
        return np.array([[0, y, sleeve], [TO_SPRING, spring, bird], [TO_SPRING + TO_BIRD, spring + TO_BIRD * bird, bird]])

    @property
    def outlines(self) -> tuple[tuple[int, Shape], ...]:
        """The sleeve cut open, the spring as a leg, and a woodpecker with head, beak, crest and tail."""
        wall, turn = 0.0012, np.linspace(0, 2 * np.pi, 24, endpoint=False)
        belly = np.column_stack([0.0068 * np.cos(turn) - 0.0005, 0.0145 * np.sin(turn) + 0.001])
        return (
            (-1, box(2 * POLE, 0.6, centre=(0.0, -0.2))),
            *((0, box(wall, 2 * HALF_SLEEVE, centre=(side * (HOLE + wall / 2), 0.0))) for side in (-1, 1)),
            (0, Shape(np.array([[HOLE + wall, 0.0], [TO_SPRING, 0.0]]))),
            (1, Shape(np.array([[0.0, 0.0], [TO_BIRD - 0.005, 0.0]]))),
            (2, Shape(belly)),
            (2, Shape(np.array([[-0.0055, BEAK_UP - 0.002]]), 0.0048)),
            (2, Shape(np.array([[-BEAK_OUT, BEAK_UP], [-0.0098, BEAK_UP - 0.0028], [-0.0098, BEAK_UP + 0.0012]]))),
            (2, Shape(np.array([[-0.006, BEAK_UP + 0.0025], [0.0022, BEAK_UP - 0.002], [0.0015, BEAK_UP + 0.0065]]))),
            (2, Shape(np.array([[0.0005, -0.011], [0.0025, -0.027], [0.0065, -0.0265], [0.0042, -0.009]]))),
            (2, Shape(np.array([[-0.0067, BEAK_UP - 0.0008]]), 0.0009)),
        )


@generator(friction=0.3, restitution=0.5, step=1e-4, duration=0.6)
def woodpecker() -> Woodpecker:
    """A toy woodpecker pecks its way down a pole, in three generalised coordinates (Glocker 1995; Leine and others 2003).

    The sleeve jams on the pole, and its friction holds the swinging woodpecker. Then it comes free and falls, until the beak
    hits the pole and it jams again. A cycle takes 0.146 s and 19 mm. restitution: of the beak; it is zero for the sleeve.
    """
    return Woodpecker(
        q0=np.array([0.0, -(HOLE - POLE) / HALF_SLEEVE, -0.2788]),  # the sleeve's lower edge is closed
        v0=np.array([-0.3411, 0.0, -7.4583]),
        size=TO_BIRD,
    )
