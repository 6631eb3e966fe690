"""A statically indeterminate table."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import count, number
from frictionbench.problems.planar.bodies import Body, Shape, box, half_plane
from frictionbench.problems.scene import Scene


@generator()
def redundant_table(
    legs: int = 4, friction: float = 0.5, speed: float = 1.0, step: float = 0.01, duration: float = 1.0
) -> Scene:
    """A table on a row of legs: the distribution of its weight over the legs is not determined.

    Only the resultant m g h, its moment about the middle and the velocity are. While it slides, friction mu m g decelerates
    it. The top is 4 by 0.2, its middle 1 m above the ground; the legs have no mass. speed: m/s, to the right; with 0 it rests,
    and friction has nothing to do.
    """
    feet = np.linspace(-1.5, 1.5, count("legs", legs, least=2))
    mass = 4.0 * 0.2
    shapes = (box(4.0, 0.2), *(Shape(np.array([[x, -1.0], [x, 0.0]])) for x in feet))
    return Scene(
        bodies=(Body(mass, mass * (4.0**2 + 0.2**2) / 12, shapes),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 1.0, 0.0]),
        v0=np.array([number("speed", speed), 0.0, 0.0]),
        friction=friction,
        step=step,
        duration=duration,
    )
