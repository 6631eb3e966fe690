"""The talk's numbered examples (Anitescu 1999, page 30): a bar on posts, blocks on tables, blocks between walls.

The talk does not give the geometry; it was chosen here.
"""

import math

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import number
from frictionbench.problems.planar.bodies import Shape, box, half_plane, rigid_box, vertical_wall
from frictionbench.problems.scene import Scene


@generator(friction=0.05, restitution=0.6, example_1={"friction": 0.05}, example_2={"friction": 0.2})
def long_bar(tilt: float = math.radians(6), speed: float = 2.0) -> Scene:
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
    )


@generator(friction=0.02, restitution=0.2, duration=3.0, example_3={"friction": 0.02}, example_4={"friction": 0.1})
def two_blocks(speed: float = 3.0) -> Scene:
    """A block slides over a table into another one.

    After 2 m they meet at V = sqrt(speed^2 - 4 mu g) and part at V (1-e)/2 and V (1+e)/2; each then travels v^2/(2 mu g). With
    friction 0.02: V = 2.87, 1.15 and 1.72 m/s, 3.35 and 7.54 m; with 0.1: 2.25, .90 and 1.35 m/s, .41 and .93 m.
    The blocks are 1 by 1, with centres initially 3 m apart; the second stands in the middle of a table 16 m wide.
    """
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0)),
        obstacles=(box(16.0, 1.0, centre=(0.0, -0.5)),),
        q0=np.array([[-3.0, 0.5, 0.0], [0.0, 0.5, 0.0]]),
        v0=np.array([[number("speed", speed), 0.0, 0.0], [0.0, 0.0, 0.0]]),
    )


@generator(friction=0.05, restitution=0.6, duration=3.0, example_6={"friction": 0.05})
def three_blocks(speed: float = 5.0) -> Scene:
    """A block slides over a table into the lower block of a tower of two.

    The lower block is pushed out from under the upper one, which hardly moves sideways and drops.
    """
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0), rigid_box(1.0, 1.0)),
        obstacles=(box(20.0, 1.0, centre=(0.0, -0.5)),),
        q0=np.array([[-5.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 1.5, 0.0]]),
        v0=np.array([[number("speed", speed), 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    )


@generator(friction=0.3, restitution=0.9, step=0.005, duration=2.0, example_5={})
def multiple_collisions(speed: float = 4.0) -> Scene:
    """Two blocks and a plank thrown at each other in a pen 5 m wide.

    There are dozens of impacts, some at several contacts at once. The energy must never increase. speed: m/s, of the two
    blocks, 1 by 1, towards each other; the plank, 1.5 by 0.5, is thrown up between them at half this speed.
    """
    speed = number("speed", speed)
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0), rigid_box(1.5, 0.5)),
        obstacles=_pen(5.0),
        q0=np.array([[-1.7, 1.6, 0.2], [1.7, 1.4, -0.3], [0.0, 0.5, 0.05]]),
        v0=np.array([[speed, 0.0, 1.0], [-speed, 0.5, -2.0], [0.0, speed / 2, 0.0]]),
    )


@generator(friction=0.2, restitution=1.0, step=0.005, duration=2.0, example_7={})
def several_blocks(drop: float = 1.0) -> Scene:
    """Five tilted blocks dropped side by side in a pen 7 m wide.

    They bounce, spin and hit each other. The energy must never increase, even with restitution 1; friction dissipates some.
    drop: m, the height of the leftmost block above its position at rest; each further block starts a quarter of it higher.
    """
    drop = number("drop", drop, least=0.25)
    x = np.linspace(-2.6, 2.6, 5)
    return Scene(
        bodies=tuple(rigid_box(1.0, 1.0) for _ in x),
        obstacles=_pen(7.0),
        q0=np.column_stack([x, 0.5 + drop * (1 + np.arange(5) / 4), [0.0, 0.2, -0.1, 0.1, 0.3]]),
    )


def _pen(width: float) -> tuple[Shape, ...]:
    return half_plane(), vertical_wall(-width / 2, side=-1), vertical_wall(width / 2, side=1)
