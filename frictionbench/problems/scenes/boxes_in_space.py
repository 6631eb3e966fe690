"""Boxes in space: on a slope, on top of each other, in a groove. They rest or slide, with motions in closed form.

A slope tilts gravity and not the ground: x points downhill, and z is normal to the slope.
"""

from functools import partial

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array, count, number
from frictionbench.problems.scene import GRAVITY, Scene
from frictionbench.problems.scenes.one_block import sliding
from frictionbench.problems.spatial.bodies import LEVEL_GROUND, HalfSpace, solid_box
from frictionbench.problems.spatial.rotation import NO_ROTATION

HALF_EDGE = 0.1  # m, half an edge of a cube


@generator(dimension=3, duration=0.6)
def sliding_box(
    slope: float = 0.0, friction: float = 0.5, speed: float = 2.0, heading: float = 0.0, aspect: float = 1.0
) -> Scene:
    """A box that is thrown on level ground or put on a slope: it slides straight on, stops, stays at rest, or tips over.

    On level ground it stops after v^2/(2 mu g), in the direction of the throw. On a slope below atan(mu) it stays at rest and
    does not creep. It tips over if tan(slope) > 1/aspect. slope, heading: rad. speed: m/s. aspect: height divided by width,
    which is 0.2 m.
    """
    slope, speed, heading = number("slope", slope, least=0, most=1.2), number("speed", speed), number("heading", heading)
    half, mu = (HALF_EDGE, HALF_EDGE, HALF_EDGE * number("aspect", aspect, above=0)), number("friction", friction, least=0)
    along = np.array([np.cos(heading), np.sin(heading), 0.0])
    down, normal = GRAVITY * np.sin(slope), GRAVITY * np.cos(slope)
    straight = slope == 0 or (heading == 0 and speed >= 0)  # otherwise the path bends or turns back
    upright = max(mu if speed else min(mu, np.tan(slope)), 0.0) * aspect <= 1
    return Scene(
        bodies=(solid_box(half),),
        obstacles=(LEVEL_GROUND,),
        q0=np.array([0.0, 0.0, half[2], *NO_ROTATION]),
        v0=np.array([*speed * along, 0.0, 0.0, 0.0]),
        gravity=(down, 0.0, -normal),
        path=partial(sliding, np.array([0, 0, half[2]]), along, speed, down, mu * normal) if straight and upright else None,
    )


@generator(dimension=3, duration=0.3)
def box_tower(boxes: int = 5, mass_ratio: float = 1.0, slope: float = 0.1, friction: float = 0.5) -> Scene:
    """A tower of cubes on a slope, held at rest by friction.

    It tips over if, for some face, tan(slope) exceeds half an edge divided by the height above the face of the centre of mass
    of the cubes on it. mass_ratio: of the highest to the lowest cube, geometric in between. slope: rad, 0 for level ground.
    """
    n = count("boxes", boxes)
    mass = number("mass_ratio", mass_ratio, above=0) ** (np.arange(n) / max(n - 1, 1))
    slope, mu = number("slope", slope, least=0, most=1.2), number("friction", friction, least=0)
    place = np.array([[0.0, 0.0, HALF_EDGE * (2 * i + 1)] for i in range(n)])
    standing = [np.average(place[i:, 2], weights=mass[i:]) - 2 * i * HALF_EDGE for i in range(n)]  # heights above each face
    holds = np.tan(slope) <= min(mu, HALF_EDGE / max(standing))
    return Scene(
        bodies=tuple(solid_box((HALF_EDGE, HALF_EDGE, HALF_EDGE), float(m)) for m in mass),
        obstacles=(LEVEL_GROUND,),
        q0=np.hstack([place, np.tile(NO_ROTATION, (n, 1))]),
        gravity=(GRAVITY * np.sin(slope), 0.0, -GRAVITY * np.cos(slope)),
        path=partial(_resting, place) if holds else None,
    )


def _resting(place: Array, time: float) -> Array:
    return place


@generator(dimension=3, duration=0.5)
def box_in_groove(slope: float = 0.5, friction: float = 0.2) -> Scene:
    """A cube slides on an edge down a right-angled groove, between two planes that both press on it.

    Its acceleration is g (sin(slope) - sqrt(2) mu cos(slope)); if that is negative, it stays at rest. slope: rad.
    """
    slope, mu, side = number("slope", slope, least=0, most=1.2), number("friction", friction, least=0), np.sqrt(0.5)
    down, normal = GRAVITY * np.sin(slope), GRAVITY * np.cos(slope)
    start = np.array([0.0, 0.0, HALF_EDGE / side])
    return Scene(
        bodies=(solid_box((HALF_EDGE, HALF_EDGE, HALF_EDGE)),),
        obstacles=tuple(HalfSpace(np.array([0.0, sign * side, side])) for sign in (-1, 1)),
        q0=np.array([*start, np.cos(np.pi / 8), np.sin(np.pi / 8), 0.0, 0.0]),
        gravity=(down, 0.0, -normal),
        path=partial(sliding, start, np.array([1.0, 0, 0]), 0.0, down, mu * normal / side),
    )
