"""A ball on the ground and a bead in a bowl."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import Body, Shape, half_plane, hollow, rigid_disc
from frictionbench.problems.scene import Scene


@generator()
def bouncing_ball(
    height: float = 1.0,
    restitution: float = 0.8,
    friction: float = 0.0,
    speed: float = 0.0,
    spin: float = 0.0,
    step: float = 0.001,
    duration: float = 3.0,
) -> Scene:
    """A ball dropped on the ground.

    Its apexes are height e^(2k), k = 0, 1, ..., and it comes to rest at sqrt(2 height/g) (1 + e)/(1 - e). height: m, of the
    ball's lowest point. speed: m/s, to the right. spin: rad/s.
    """
    return Scene(
        bodies=(rigid_disc(0.5),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 0.5 + number("height", height, least=0), 0.0]),
        v0=np.array([number("speed", speed), 0.0, number("spin", spin)]),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )


@generator()
def bowl(friction: float = 0.1, radius: float = 1.0, angle: float = 1.0, step: float = 0.01, duration: float = 2.0) -> Scene:
    """A bead slides to and fro in a circular bowl: curved ground, from which straight steps deviate.

    Schemes on velocities drift out of the bowl by O(h), schemes on gaps by O(h^2). The bead is a flywheel of 1 kg and 1 kg m^2
    and a millimetre across, so that it hardly rolls. radius: m, of its path. angle: rad, from the lowest point, at the start.
    """
    radius, angle = number("radius", radius, least=0.01), number("angle", angle, least=-3, most=3)
    bead = 5e-4
    return Scene(
        bodies=(Body(1.0, 1.0, (Shape(np.zeros((1, 2)), bead),)),),
        obstacles=(hollow(radius + bead),),
        q0=np.array([radius * np.sin(angle), -radius * np.cos(angle), 0.0]),
        friction=friction,
        step=step,
        duration=duration,
    )
