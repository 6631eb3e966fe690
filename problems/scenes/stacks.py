"""A stack, a brick wall and a pyramid of boxes: many contacts, exact ties, more contacts than degrees of freedom."""

import numpy as np

from frictionbench.problems.parameters import count, number
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.scene import Scene
from frictionbench.problems.scenes.catalogue import generator


@generator()
def stack(
    blocks: int = 10,
    friction: float = 0.5,
    mass_ratio: float = 1.0,
    push: float = 0.0,
    shear: float = 0.0,
    jitter: float = 0.0,
    step: float = 0.01,
) -> Scene:
    """A straight stack of unit boxes, the lowest pushed sideways.

    With push = 0 it rests, and the two contacts of interface i together carry the weight of all boxes above it: with equal
    masses, m g h (blocks - i). mass_ratio: the densities grow by one factor from each box to the next, the topmost box having
    mass_ratio times the lowest one's: large ones slow down iterations over contacts. push: m/s, of the lowest box. shear:
    1/s, velocities increase with height by so much. jitter: the relative random variation of the boxes' masses and
    of their offsets; with 0 every contact is an exact tie.
    """
    n = count("blocks", blocks)
    ratio = number("mass_ratio", mass_ratio, above=0)
    level = np.arange(n)
    aside, heavier = number("jitter", jitter, least=0, most=0.4) * np.random.default_rng(0).uniform(-1, 1, (n, 2)).T + 0.0
    density = ratio ** (level / max(n - 1, 1)) * (1 + heavier)
    velocity = np.zeros((n, 3))
    velocity[:, 0] = number("shear", shear) * (level + 0.5)
    velocity[0, 0] += number("push", push)
    return Scene(
        bodies=tuple(rigid_box(1.0, 1.0, float(rho)) for rho in density),
        obstacles=(half_plane(),),
        q0=np.column_stack([aside, level + 0.5, np.zeros(n)]),
        v0=velocity,
        friction=friction,
        step=step,
    )


@generator()
def wall(rows: int = 5, columns: int = 5, friction: float = 0.5, push: float = 0.0, step: float = 0.01) -> Scene:
    """A brick wall in running bond, bricks 2 by 1, flush on all sides, the lowest left one pushed towards the others.

    With push = 0 it rests. Every second row has one brick fewer, so that no brick overhangs. Each contact is an exact tie.
    push: m/s, of the lowest left brick.
    """
    rows, columns = count("rows", rows), count("columns", columns, least=2)
    place = [(2.0 * i + (row % 2), row + 0.5, 0.0) for row in range(rows) for i in range(columns - row % 2)]
    velocity = np.zeros((len(place), 3))
    velocity[0, 0] = number("push", push)
    return Scene(
        bodies=tuple(rigid_box(2.0, 1.0) for _ in place),
        obstacles=(half_plane(),),
        q0=np.array(place),
        v0=velocity,
        friction=friction,
        step=step,
    )


@generator()
def pyramid(rows: int = 5, friction: float = 0.5, push: float = 0.0, shear: float = 0.0, step: float = 0.01) -> Scene:
    """A pyramid of unit boxes, each resting on two that stand apart, the topmost pushed sideways.

    With push = 0 it rests. The boxes of a row are 0.2 apart. push: m/s, of the topmost box. shear: 1/s, velocities
    increase with height by so much.
    """
    rows = count("rows", rows)
    place = [(1.2 * (i + row / 2), row + 0.5, 0.0) for row in range(rows) for i in range(rows - row)]
    velocity = np.zeros((len(place), 3))
    velocity[:, 0] = number("shear", shear) * np.array(place)[:, 1]
    velocity[-1, 0] += number("push", push)
    return Scene(
        bodies=tuple(rigid_box(1.0, 1.0) for _ in place),
        obstacles=(half_plane(),),
        q0=np.array(place),
        v0=velocity,
        friction=friction,
        step=step,
    )
