"""One block on the ground: sliding to a stop or down a slope, tipping over, rocking."""

from functools import partial

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array, number
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.scene import GRAVITY, Scene


def sliding(start: Array, along: Array, speed: float, pull: float, rate: float, time: float) -> Array:
    """The centre (1, d) on a straight line, with the accelerations pull along it and up to rate against it, m/s^2."""
    if speed == 0 and pull <= rate:
        return start[None]
    direction = np.sign(speed) or 1.0
    until = min(time, abs(speed) / (rate - pull)) if rate > pull else time
    return np.array([start + along * (speed * until + direction * (pull - rate) * until**2 / 2)])


@generator(duration=1.0)
def stopping_block(friction: float = 0.5, speed: float = 1.0) -> Scene:
    """A block, 2 by 1, slides on the ground to a stop.

    Anitescu and Potra's scheme gives v^{k+1} = max(0, v^k - mu g h) exactly. If v0 is a multiple of mu g h, its stopping
    distance is v0 h/2 less than v0^2/(2 mu g). The block does not tip over for mu <= 2. speed: m/s, to the right.
    """
    speed, friction = number("speed", speed), number("friction", friction, least=0, most=2)
    return Scene(
        bodies=(rigid_box(2.0, 1.0),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, 0.5, 0.0]),
        v0=np.array([speed, 0.0, 0.0]),
        path=partial(sliding, np.array([0.0, 0.5]), np.array([1.0, 0.0]), speed, 0.0, friction * GRAVITY),
    )


@generator(friction=0.5, duration=1.0)
def two_corner_block(aspect: float = 1.0, velocity: float = 1.0, fall: float = 0.0, spin: float = 0.0) -> Scene:
    """A block with both lower corners on the ground: the smallest problem with coupled contacts.

    Its friction LCP has a P0 matrix iff friction * aspect <= 1; beyond this bound the sliding block tips over. With friction of
    2 or more, some velocities have three solutions. aspect: height divided by width, which is 1 m. velocity: m/s, to the right.
    fall: m/s, downwards. spin: rad/s.
    """
    aspect = number("aspect", aspect, above=0)
    return Scene(
        bodies=(rigid_box(1.0, aspect),),
        obstacles=(half_plane(),),
        q0=np.array([0.0, aspect / 2, 0.0]),
        v0=np.array([number("velocity", velocity), -number("fall", fall), number("spin", spin)]),
    )


@generator(duration=1.0)
def incline(angle: float = 0.5, friction: float = 0.3, speed: float = 0.0) -> Scene:
    """A block, 2 by 1, on a slope.

    It rests iff friction >= tan(angle), else it slides down with the acceleration g (sin(angle) - friction cos(angle)). It
    does not tip over if tan(angle) and friction are below 2. angle: rad. speed: m/s, initial, downhill.
    """
    angle, speed = number("angle", angle, least=0, most=1.1), number("speed", speed)
    cos, sin, mu = np.cos(angle), np.sin(angle), number("friction", friction, least=0, most=2)
    start, downhill = np.array([-0.5 * sin, 0.5 * cos]), np.array([-cos, -sin])
    return Scene(
        bodies=(rigid_box(2.0, 1.0),),
        obstacles=(half_plane(slope=angle),),
        q0=np.array([*start, angle]),
        v0=np.array([*speed * downhill, 0.0]),
        path=partial(sliding, start, downhill, speed, GRAVITY * sin, mu * GRAVITY * cos) if speed >= 0 else None,
    )


@generator(friction=1.0, step=0.005, duration=5.0)
def rocking_block(slenderness: float = 0.25, tilt: float = 0.1, spin: float = 0.0) -> Scene:
    """A tall block tilted over one corner falls back and rocks from corner to corner (Housner 1963).

    With alpha = atan(slenderness), each impact changes the spin from w to w (1 - 3/2 sin(alpha)^2) if the corner does not slip,
    which requires friction >= 3 t/(4 + t^2) with t = slenderness. slenderness: width divided by height, which is 2 m. tilt:
    rad, over the left corner; the block falls back if it is below alpha. spin: rad/s, about that corner.
    """
    slenderness = number("slenderness", slenderness, above=0, most=1)
    tilt, spin = number("tilt", tilt, least=0, most=1), number("spin", spin)
    cos, sin = np.cos(tilt), np.sin(tilt)
    x, y = cos * slenderness - sin, sin * slenderness + cos  # the centre, from the corner on which it stands
    return Scene(
        bodies=(rigid_box(2 * slenderness, 2.0),),
        obstacles=(half_plane(),),
        q0=np.array([x, y, tilt]),
        v0=np.array([-spin * y, spin * x, spin]),
    )
