"""The talk's examples 1 and 2 (Anitescu 1999): a long bar dropped on three posts; the geometry is ours."""

import math

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import box, rigid_box
from frictionbench.problems.scene import Scene


@generator(example_1={"friction": 0.05}, example_2={"friction": 0.2})
def long_bar(
    friction: float = 0.05, restitution: float = 0.6, tilt: float = math.radians(6), speed: float = 2.0, step: float = 0.01
) -> Scene:
    """A tilted bar, 10 by 0.4, dropped on three posts while it moves along them.

    It rattles from post to post and then slides. With friction 0.05 it still slides after 3 s, with 0.2 it has stopped.
    Friction decelerates the resting bar by mu g. tilt: rad. speed: m/s, to the right.
    """
    tilt = number("tilt", tilt, least=-0.2, most=0.2)
    return Scene(
        bodies=(rigid_box(10.0, 0.4),),
        obstacles=tuple(box(1.0, 1.0, centre=(x, -0.5)) for x in (-4.0, 0.0, 4.0)),
        q0=np.array([0.0, 1.2, tilt]),
        v0=np.array([number("speed", speed), 0.0, 0.0]),
        friction=friction,
        restitution=restitution,
        step=step,
    )
