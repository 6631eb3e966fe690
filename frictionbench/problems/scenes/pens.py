"""Blocks that collide between walls: the talk's examples 5 and 7 (Anitescu 1999); the geometry is ours."""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import Shape, half_plane, rigid_box, vertical_wall
from frictionbench.problems.scene import Scene


@generator(example_5={})
def multiple_collisions(
    friction: float = 0.3, restitution: float = 0.9, speed: float = 4.0, step: float = 0.005, duration: float = 2.0
) -> Scene:
    """Two blocks and a plank thrown at each other in a pen 5 m wide.

    Dozens of impacts, some of several contacts at once; energy must never rise. speed: m/s, of the two blocks, 1 by 1, towards
    each other; the plank, 1.5 by 0.5, is thrown up between them at half of it.
    """
    speed = number("speed", speed)
    return Scene(
        bodies=(rigid_box(1.0, 1.0), rigid_box(1.0, 1.0), rigid_box(1.5, 0.5)),
        obstacles=_pen(5.0),
        q0=np.array([[-1.7, 1.6, 0.2], [1.7, 1.4, -0.3], [0.0, 0.5, 0.05]]),
        v0=np.array([[speed, 0.0, 1.0], [-speed, 0.5, -2.0], [0.0, speed / 2, 0.0]]),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )


@generator(example_7={})
def several_blocks(
    friction: float = 0.2, restitution: float = 1.0, drop: float = 1.0, step: float = 0.005, duration: float = 2.0
) -> Scene:
    """Five tilted blocks dropped side by side in a pen 7 m wide.

    They bounce, spin and hit each other; the energy must never rise, also with restitution 1, and friction dissipates some.
    drop: m, from the middle of the lowest block to where it would be at rest; each further one starts a quarter of it higher.
    """
    drop = number("drop", drop, least=0.25)
    x = np.linspace(-2.6, 2.6, 5)
    return Scene(
        bodies=tuple(rigid_box(1.0, 1.0) for _ in x),
        obstacles=_pen(7.0),
        q0=np.column_stack([x, 0.5 + drop * (1 + np.arange(5) / 4), [0.0, 0.2, -0.1, 0.1, 0.3]]),
        friction=friction,
        restitution=restitution,
        step=step,
        duration=duration,
    )


def _pen(width: float) -> tuple[Shape, ...]:
    return half_plane(), vertical_wall(-width / 2, side=-1), vertical_wall(width / 2, side=1)
