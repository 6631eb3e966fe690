"""A block that slides to a stop: the simplest scene with friction, with a closed form for every step."""

from functools import partial

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.parameters import number
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.scene import GRAVITY, Scene
from frictionbench.problems.scenes.closed_forms import sliding


@generator()
def stopping_block(friction: float = 0.5, speed: float = 1.0, step: float = 0.01, duration: float = 1.0) -> Scene:
    """A block, 2 by 1, slides on the ground to a stop.

    Anitescu and Potra's scheme gives v^{k+1} = max(0, v^k - mu g h) exactly, and a stopping distance short of v0^2/(2 mu g)
    by v0 h/2 where v0 is a multiple of mu g h. The block does not tip over while mu <= 2. speed: m/s, to the right.
    """
    speed, friction = number("speed", speed), number("friction", friction, least=0, most=2)
    return Scene(
        bodies=(rigid_box(2.0, 1.0),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 0.5, 0.0]),
        v0=np.array([speed, 0.0, 0.0]),
        friction=friction,
        step=step,
        duration=duration,
        path=partial(sliding, np.array([0.0, 0.5]), np.array([1.0, 0.0]), speed, 0.0, friction * GRAVITY),
    )
