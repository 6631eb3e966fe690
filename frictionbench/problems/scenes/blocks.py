"""Unit blocks on a table: the talk's examples 3, 4 and 6 (Anitescu 1999); the geometry is ours."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import box, rigid_box
from frictionbench.problems.scene import Scene


@generator(example_3={"friction": 0.02}, example_4={"friction": 0.1})
def two_blocks(
    friction: float = 0.02, restitution: float = 0.2, speed: float = 3.0, step: float = 0.01, duration: float = 3.0
) -> Scene:
    """A block slides over a table into another one.

    After 2 m they meet at V = sqrt(speed^2 - 4 mu g) and part at V (1-e)/2 and V (1+e)/2; each then travels v^2/(2 mu g). With
    friction 0.02: V = 2.87, 1.15 and 1.72 m/s, 3.35 and 7.54 m; with 0.1: 2.25, .90 and 1.35 m/s, .41 and .93 m.
    The blocks are 1 by 1, their centres at first 3 m apart, the second in the middle of a table 16 m wide.
    """
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0)),
        obstacles=(box(16.0, 1.0, centre=(0.0, -0.5)),),
        q0=np.array([[-3.0, 0.5, 0.0], [0.0, 0.5, 0.0]]),
        v0=np.array([[number("speed", speed), 0.0, 0.0], [0.0, 0.0, 0.0]]),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )


@generator(example_6={"friction": 0.05})
def three_blocks(
    friction: float = 0.05, restitution: float = 0.6, speed: float = 5.0, step: float = 0.01, duration: float = 3.0
) -> Scene:
    """A block slides over a table into the lower block of a tower of two.

    The lower block is pushed out from under the upper one, which hardly moves sideways and drops.
    """
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0), rigid_box(1.0, 1.0)),
        obstacles=(box(20.0, 1.0, centre=(0.0, -0.5)),),
        q0=np.array([[-5.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 1.5, 0.0]]),
        v0=np.array([[number("speed", speed), 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )
