"""Mechanisms with hinges."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import Body, box, rigid_rod
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene

CRANK, ROD = 0.153, 0.306  # m, of the slider-crank


@generator()
def pendulum(angle: float = 1.0, length: float = 1.0, spin: float = 0.0, step: float = 0.01, duration: float = 2.0) -> Scene:
    """A uniform rod that hangs from a hinge at one end, without contacts.

    The energy is constant; the period of small swings is 2 pi sqrt(2 length/(3 g)). angle: rad, from the vertical. length: m.
    spin: rad/s.
    """
    half, spin = number("length", length, above=0) / 2, number("spin", spin)
    direction = number("angle", angle) - np.pi / 2
    x, y = half * np.cos(direction), half * np.sin(direction)
    return Scene(
        bodies=(rigid_rod(half),),
        hinges=(Hinge((0, -1), np.array([[-half, 0.0], [0.0, 0.0]])),),
        q0=np.array([x, y, direction]),
        v0=np.array([-spin * y, spin * x, spin]),
        friction=0.0,
        step=step,
        duration=duration,
    )


@generator()
def slider_crank(
    friction: float = 0.01,
    restitution: float = 0.4,
    clearance: float = 0.001,
    speed: float = 150.0,
    tilt: float = 0.0,
    angle: float = 0.0,
    step: float = 1e-4,
    duration: float = 0.08,
) -> Scene:
    """A crank drives a slider that has a little clearance between its two guides (Flores, Leine and Glocker 2010).

    Contacts at the end of a chain of three hinges: the slider rattles between the guides, which alone dissipate energy.
    Crank 0.153 m, rod 0.306 m, slider 0.1 m by 0.05 m, masses as in the reference. The crank turns once in about
    0.07 s. clearance: m, on each side. speed: rad/s, of the crank. tilt: rad, of the slider. angle: rad, of the crank, 0
    where it is in line with the rod.
    """
    clearance, w = number("clearance", clearance, least=0, most=0.01), number("speed", speed)
    crank, rod, length, height = CRANK, ROD, 0.1, 0.05
    guide = (height + 0.1) / 2 + clearance  # the height of a guide's centre
    angle = number("angle", angle)
    cos, sin = np.cos(angle), np.sin(angle)
    lean = -np.arcsin(crank / rod * sin)
    along = np.cos(lean)
    swing = -w * crank * cos / (rod * along)  # the rod's spin
    return Scene(
        bodies=(Body(0.038, 7.4e-5, ()), Body(0.038, 5.9e-4, ()), Body(0.076, 2.7e-6, (box(length, height),))),
        obstacles=tuple(box(1.0, 0.1, centre=(crank + rod, side * guide)) for side in (-1, 1)),
        hinges=(
            Hinge((0, -1), np.array([[-crank / 2, 0.0], [0.0, 0.0]])),
            Hinge((1, 0), np.array([[-rod / 2, 0.0], [crank / 2, 0.0]])),
            Hinge((2, 1), np.array([[0.0, 0.0], [rod / 2, 0.0]])),
        ),
        q0=np.array(
            [
                [crank / 2 * cos, crank / 2 * sin, angle],
                [crank * cos + rod / 2 * along, crank / 2 * sin, lean],
                [crank * cos + rod * along, 0.0, number("tilt", tilt, least=-0.1, most=0.1)],
            ]
        ),
        v0=np.array(
            [
                [-w * crank / 2 * sin, w * crank / 2 * cos, w],
                [-w * crank * sin + swing * crank / 2 * sin, w * crank / 2 * cos, swing],
                [-w * crank * sin + swing * crank * sin, 0.0, 0.0],
            ]
        ),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )
