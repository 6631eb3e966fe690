"""Discs: on the ground, in a bowl, between two walls.

Between walls the friction cones of a disc's two contacts can contain opposite directions.
"""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import number
from frictionbench.problems.planar.bodies import Body, Shape, half_plane, hollow, rigid_disc, vertical_wall
from frictionbench.problems.scene import Scene

RADIUS = 0.5  # m, of the discs between walls
DENSITY = 1 / (np.pi * RADIUS**2)  # of a disc of 1 kg


@generator(friction=0.0, restitution=0.8, step=0.001, duration=3.0)
def bouncing_ball(height: float = 1.0, speed: float = 0.0, spin: float = 0.0) -> Scene:
    """A ball dropped on the ground.

    Its apexes are height e^(2k), k = 0, 1, ..., and it comes to rest at sqrt(2 height/g) (1 + e)/(1 - e). height: m, of the
    ball's lowest point. speed: m/s, to the right. spin: rad/s.
    """
    return Scene(
        bodies=(rigid_disc(0.5),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 0.5 + number("height", height, least=0), 0.0]),
        v0=np.array([number("speed", speed), 0.0, number("spin", spin)]),
    )


@generator(friction=0.1, duration=2.0)
def bowl(radius: float = 1.0, angle: float = 1.0) -> Scene:
    """A bead slides to and fro in a circular bowl: curved ground, from which straight steps deviate.

    Schemes with velocity constraints drift out of the bowl by O(h), schemes with gap constraints by O(h^2). The bead has 1 kg,
    1 kg m^2 and a diameter of 1 mm, so that it hardly rolls. radius: m, of its path. angle: rad, the initial one from below.
    """
    radius, angle = number("radius", radius, least=0.01), number("angle", angle, least=-3, most=3)
    bead = 5e-4
    return Scene(
        bodies=(Body(1.0, 1.0, (Shape(np.zeros((1, 2)), bead),)),),
        obstacles=(hollow(radius + bead),),
        q0=np.array([radius * np.sin(angle), -radius * np.cos(angle), 0.0]),
    )


@generator(friction=0.5, duration=1.0)
def jam(speed: float = 1.0, overlap: float = 0.0, sideways: float = 0.0) -> Scene:
    """A disc of 1 kg slides up between two vertical walls one diameter apart: jammed, a hard case of Anitescu (1999).

    The normals cancel, so normal impulses of any size have no effect, and the friction cone is not pointed. The solutions are
    not unique, and their set is not convex: with V = speed - g h, normal impulses c = s V/(2 mu) on both walls slow the disc to
    (1-s) V, for s in [0, 1], and any larger ones stop it (page 22 of Anitescu 1999). overlap: m, by which the walls overlap the
    disc, so that a scheme with gap constraints has no solution; negative for a gap. speed, sideways: m/s, up and to the right.
    With sideways = 0, zero impulses are a solution of the first step; otherwise friction acts at the wall that is hit.
    """
    squeeze = number("overlap", overlap, least=-RADIUS, most=RADIUS) / 2
    return Scene(
        bodies=(rigid_disc(RADIUS, DENSITY),),
        obstacles=(vertical_wall(squeeze - RADIUS, side=-1), vertical_wall(RADIUS - squeeze, side=1)),
        q0=np.zeros(3),
        v0=np.array([number("sideways", sideways), number("speed", speed), 0.0]),
    )


@generator(friction=0.3, duration=1.0)
def wedge(angle: float = 0.5, speed: float = 1.0, spin: float = 5.0, depth: float = 0.0) -> Scene:
    """A spinning disc of 1 kg hits both walls of an upright wedge at once.

    Without a spin it stops in every solution, u = 0, and friction is not needed. The impulses are bounded for
    friction < tan(angle). For a larger friction the disc can jam: the walls press against each other through it. angle: rad, of
    each wall from the vertical. speed: m/s, downwards. spin: rad/s. depth: m, the initial overlap of the disc and both walls.
    """
    angle = number("angle", angle, above=0, most=1.5)
    return Scene(
        bodies=(rigid_disc(RADIUS, DENSITY),),
        obstacles=(half_plane(slope=angle - np.pi / 2), half_plane(slope=np.pi / 2 - angle)),
        q0=np.array([0.0, (RADIUS - number("depth", depth, least=0, most=RADIUS)) / np.sin(angle), 0.0]),
        v0=np.array([0.0, -number("speed", speed), number("spin", spin)]),
    )
