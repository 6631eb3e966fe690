"""Mechanisms with hinges: a pendulum, a slider-crank, and a chain with any number of contacts and joints."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import count, number
from frictionbench.problems.planar.bodies import Body, box, half_plane, rigid_box, rigid_rod
from frictionbench.problems.planar.joints import Hinge
from frictionbench.problems.scene import Scene

CRANK, ROD = 0.153, 0.306  # m, of the slider-crank


@generator(duration=2.0)
def pendulum(angle: float = 1.0, length: float = 1.0, spin: float = 0.0) -> Scene:
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
    )


@generator(friction=0.01, restitution=0.4, step=1e-4, duration=0.08)
def slider_crank(clearance: float = 0.001, speed: float = 150.0, tilt: float = 0.0, angle: float = 0.0) -> Scene:
    """A crank drives a slider that has a little clearance between its two guides (Flores, Leine and Glocker 2010).

    The slider is the end of a chain of three hinges and rattles between the guides. Energy is dissipated only there.
    Crank 0.153 m, rod 0.306 m, slider 0.1 m by 0.05 m, masses as in the reference. The crank turns once in about
    0.07 s. clearance: m, on each side. speed: rad/s, of the crank. tilt: rad, of the slider. angle: rad, of the crank, 0
    if it is in line with the rod.
    """
    clearance, w = number("clearance", clearance, least=0, most=0.01), number("speed", speed)
    crank, rod, length, height = CRANK, ROD, 0.1, 0.05
    guide = (height + 0.1) / 2 + clearance  # the height of a guide's centre
    angle = number("angle", angle)
    cos, sin = np.cos(angle), np.sin(angle)
    rod_angle = -np.arcsin(crank / rod * sin)
    along = np.cos(rod_angle)
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
                [crank * cos + rod / 2 * along, crank / 2 * sin, rod_angle],
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
    )


@generator(friction=0.5, duration=1.0)
def chain(links: int = 5, pull: float = 1.0, ripple: float = 0.0, fall: float = 0.0, mass_ratio: float = 1.0) -> Scene:
    """A row of boxes, 1 by 0.2, flat on the ground and hinged to each other at half their height, is pulled along.

    pull: m/s, of all boxes, to the right. ripple: rad/s, initial spins of alternating sign, which lift every second hinge.
    fall: m/s, downwards. mass_ratio: the mass of the last link divided by that of the first, geometric in between.
    """
    n, spin = count("links", links), number("ripple", ripple)
    density = number("mass_ratio", mass_ratio, above=0) ** (np.arange(n) / max(n - 1, 1))
    velocity = np.zeros((n, 3))
    velocity[:, 0] = number("pull", pull)
    velocity[:, 1] = spin / 2 - number("fall", fall)  # the spin lifts one end of a link; the other stays
    velocity[:, 2] = spin * (-1.0) ** np.arange(n)
    return Scene(
        bodies=tuple(rigid_box(1.0, 0.2, float(rho)) for rho in density),
        obstacles=(half_plane(),),
        hinges=tuple(Hinge((i + 1, i), np.array([[-0.5, 0.0], [0.5, 0.0]])) for i in range(n - 1)),
        q0=np.column_stack([np.arange(n), np.full(n, 0.1), np.zeros(n)]),
        v0=velocity,
    )
