"""A ball that slides on a table, and one that falls on it: spatial motions with closed forms."""

from functools import partial

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array, number
from frictionbench.problems.scene import GRAVITY, Scene
from frictionbench.problems.spatial.bodies import LEVEL_GROUND, solid_sphere
from frictionbench.problems.spatial.rotation import NO_ROTATION

RADIUS = 0.1  # m


@generator(dimension=3, duration=0.4)
def sliding_ball(speed: float = 2.0, side_spin: float = 14.0, friction: float = 0.3) -> Scene:
    """A ball slides on a table until it rolls: with a side spin on a parabola, otherwise straight, finally at 5/7 of its speed.

    The lowest point of a ball of radius R slides at s = v + omega x (0, 0, -R). Friction mu m g against s reduces s and keeps
    its direction, s' = -7/2 mu g s/|s|, until the ball rolls at the time 2 |s_0| / (7 mu g). If a polygon replaces Coulomb's
    cone, s turns and the path bends. Angular momentum about the lowest point is conserved, so that the rolling velocity does
    not depend on the cone's section. speed: m/s, along x. side_spin: rad/s, about x. The ball has a radius of 0.1 m.
    """
    velocity, spin = np.array([number("speed", speed), 0.0, 0.0]), np.array([number("side_spin", side_spin), 0.0, 0.0])
    slip = velocity + np.cross(spin, [0.0, 0.0, -RADIUS])
    return Scene(
        bodies=(solid_sphere(RADIUS),),
        obstacles=(LEVEL_GROUND,),
        q0=np.array([0.0, 0.0, RADIUS, *NO_ROTATION]),
        v0=np.concatenate([velocity, spin]),
        path=partial(_rolling, velocity, slip, number("friction", friction, least=0) * GRAVITY),
    )


def _rolling(velocity: Array, slip: Array, rate: float, time: float) -> Array:
    """The centre (1, 3). rate: the deceleration by friction, m/s^2."""
    size = float(np.linalg.norm(slip))
    push = rate * slip / size if size else slip
    sliding = min(time, 2 * size / (7 * rate)) if rate else time
    rolling = velocity - push * sliding
    return np.array([[0.0, 0.0, RADIUS] + velocity * sliding - push * sliding**2 / 2 + rolling * (time - sliding)])


@generator(dimension=3, friction=0.5, step=0.002, duration=0.6)
def dropped_ball(height: float = 0.2, restitution: float = 0.0) -> Scene:
    """A ball falls on a table and rebounds repeatedly, each time to e^2 of its height. height: m, of its lowest point."""
    height = number("height", height, least=0)
    return Scene(
        bodies=(solid_sphere(RADIUS),),
        obstacles=(LEVEL_GROUND,),
        q0=np.array([0.0, 0.0, RADIUS + height, *NO_ROTATION]),
        path=partial(_bouncing, height, number("restitution", restitution, least=0, most=1)),
    )


def _bouncing(height: float, e: float, time: float) -> Array:
    """The centre (1, 3)."""
    start, speed = -np.sqrt(2 * height / GRAVITY), np.sqrt(2 * height * GRAVITY)  # of a flight that begins on the table
    while speed > 1e-9 and time > start + 2 * speed / GRAVITY:
        start, speed = start + 2 * speed / GRAVITY, e * speed
    flown = time - start
    above = speed * flown - GRAVITY * flown**2 / 2 if speed > 1e-9 else 0.0
    return np.array([[0.0, 0.0, RADIUS + above]])
