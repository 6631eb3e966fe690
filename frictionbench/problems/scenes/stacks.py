"""A stack, a brick wall, a pyramid and a pile of discs: many contacts, exact ties, more contacts than degrees of freedom.

The boxes are pushed by default, because at rest on level ground friction does not act. On a slope, friction alone holds them
unless they tip over; if they slide or fall, it opposes the motion.
"""

import numpy as np

from frictionbench.problems.catalogue import generator
from frictionbench.problems.check import Array, count, number
from frictionbench.problems.planar.bodies import Body, half_plane, rigid_box, rigid_disc
from frictionbench.problems.scene import GRAVITY, Scene


@generator(friction=0.5)
def stack(
    blocks: int = 10,
    smooth: float = 1.0,
    mass_ratio: float = 1.0,
    push: float = 1.0,
    shear: float = 0.0,
    slope: float = 0.0,
    fall: float = 0.0,
    jitter: float = 0.0,
) -> Scene:
    """A straight stack of unit boxes, the lowest pushed sideways.

    With push = 0 it rests, and the two contacts of interface i together carry the weight of all boxes above it: with equal
    masses, m g h (blocks - i). smooth: the roughness of the third and fourth of every four boxes; that of the others is 1, so
    that the friction of interfaces differs. mass_ratio: the density of the topmost box divided by that of the lowest, geometric
    in between; large ratios slow down iterations over contacts. push: m/s, of the lowest box. shear: 1/s, the increase of the
    horizontal velocity with height. slope: rad, of the ground, downhill to the right, in a frame that is tilted with it. fall:
    m/s, downwards. jitter: the relative random variation of the boxes' masses and of their offsets; with 0, every contact is an
    exact tie.
    """
    n = count("blocks", blocks)
    ratio, roughness = number("mass_ratio", mass_ratio, above=0), number("smooth", smooth, least=0)
    level = np.arange(n)
    aside, heavier = number("jitter", jitter, least=0, most=0.4) * np.random.default_rng(0).uniform(-1, 1, (n, 2)).T + 0.0
    density = ratio ** (level / max(n - 1, 1)) * (1 + heavier)
    place = np.column_stack([aside, level + 0.5, np.zeros(n)])
    bodies = tuple(
        rigid_box(1.0, 1.0, float(rho), 1.0 if i % 4 < 2 else roughness) for i, rho in zip(level, density, strict=True)
    )
    return _pile(bodies, place, 0, push, shear, slope, fall)


@generator(friction=0.5)
def wall(
    rows: int = 5, columns: int = 5, push: float = 1.0, shear: float = 0.0, slope: float = 0.0, fall: float = 0.0
) -> Scene:
    """A brick wall in running bond, bricks 2 by 1, flush on all sides, the lowest left one pushed towards the others.

    With push = 0 it rests. Every second row has one brick fewer, so that no brick overhangs. Each contact is an exact tie.
    push: m/s, of the lowest left brick. shear, slope, fall: as in stack.
    """
    rows, columns = count("rows", rows), count("columns", columns, least=2)
    place = np.array([(2.0 * i + (row % 2), row + 0.5, 0.0) for row in range(rows) for i in range(columns - row % 2)])
    return _pile((rigid_box(2.0, 1.0),) * len(place), place, 0, push, shear, slope, fall)


@generator(friction=0.5)
def pyramid(rows: int = 5, push: float = 1.0, shear: float = 0.0, slope: float = 0.0, fall: float = 0.0) -> Scene:
    """A pyramid of unit boxes, each resting on two that stand apart, the topmost pushed sideways.

    With push = 0 it rests. The boxes of a row are 0.2 apart. push: m/s, of the topmost box. shear, slope, fall: as in stack.
    """
    rows = count("rows", rows)
    place = np.array([(1.2 * (i + row / 2), row + 0.5, 0.0) for row in range(rows) for i in range(rows - row)])
    return _pile((rigid_box(1.0, 1.0),) * len(place), place, -1, push, shear, slope, fall)


@generator(friction=0.5)
def disc_pile(
    rows: int = 5, push: float = 0.0, shear: float = 0.0, slope: float = 0.0, fall: float = 0.0, mass_ratio: float = 1.0
) -> Scene:
    """A triangular pile of discs, each resting on two, held together by friction: without it the pile spreads at once.

    The discs have the diameter 1 and touch their neighbours in the row. mass_ratio: densities are log-uniform at random in
    [1, mass_ratio]. push: m/s, of the topmost disc. shear, slope, fall: as in stack.
    """
    rows = count("rows", rows)
    place = np.array([(i + row / 2, 0.5 + row * np.sqrt(0.75), 0.0) for row in range(rows) for i in range(rows - row)])
    density = number("mass_ratio", mass_ratio, least=1) ** np.random.default_rng(0).random(len(place))
    bodies = tuple(rigid_disc(0.5, float(rho)) for rho in density)
    return _pile(bodies, place, -1, push, shear, slope, fall)


def _pile(bodies: tuple[Body, ...], place: Array, pushed: int, push: float, shear: float, slope: float, fall: float) -> Scene:
    """Bodies at their places (n, 3) on the ground, one of them pushed; see stack."""
    velocity = np.zeros(place.shape)
    velocity[:, 0] = number("shear", shear) * place[:, 1]
    velocity[:, 1] = -number("fall", fall)
    velocity[pushed, 0] += number("push", push)
    slope = number("slope", slope, least=-1.5, most=1.5)
    return Scene(
        bodies=bodies,
        obstacles=(half_plane(),),
        q0=place,
        v0=velocity,
        gravity=(GRAVITY * np.sin(slope), -GRAVITY * np.cos(slope)),
    )
