"""A stack of cubes in space: hyperstatic, with exact ties."""

import numpy as np

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import touching
from frictionbench.problems.scene import GRAVITY


@instance()
def cubes(
    boxes: int = 5,
    friction: float = 0.5,
    smooth: float = 1.0,
    push: float = 1.0,
    twist: float = 0.0,
    slope: float = 0.0,
    fall: float = 0.0,
    mass_ratio: float = 1.0,
    step: float = 0.01,
) -> FrictionProblem:
    """A stack of unit cubes in space that touch at their four corners, pushed sideways.

    With push = 0 it rests, and friction does not act. smooth: the friction of every second interface divided by that of the
    others. push: m/s, in an oblique direction, increasing with height. twist: rad/s, of the topmost cube about the vertical,
    increasing with height, so that every contact slides in its own direction. slope: rad, of the ground, downhill in an oblique
    direction. fall: m/s, downwards. mass_ratio: of the topmost cube to the lowest, geometric in between.
    """
    boxes, h = count("boxes", boxes), number("step", step, above=0)
    box, corner = np.repeat(np.arange(boxes), 4), np.array([(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
    across = np.tile(corner, (boxes, 1))
    arms = np.stack([np.column_stack([across, np.full(4 * boxes, z)]) for z in (-0.5, 0.5)], axis=1)
    upright = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    ratio = number("mass_ratio", mass_ratio, above=0)
    mass = np.geomspace(1, ratio, boxes) if boxes > 1 else np.ones(1)
    height, slope = np.arange(1, boxes + 1) / boxes, number("slope", slope, least=-1.5, most=1.5)
    velocity = np.zeros((boxes, 6))
    velocity[:, :2] = np.outer(number("push", push) * height, [0.8, 0.6]) + h * GRAVITY * np.sin(slope) * np.array([0.6, -0.8])
    velocity[:, 2] = -h * GRAVITY * np.cos(slope) - number("fall", fall)
    velocity[:, 5] = number("twist", twist) * height
    share = np.where(box % 2 == 0, 1.0, number("smooth", smooth, least=0))
    return touching(
        np.column_stack([box, box - 1]),
        arms,
        np.broadcast_to(upright, (4 * boxes, 3, 3)),
        np.outer(mass, [1, 1, 1, 1 / 6, 1 / 6, 1 / 6]),
        velocity,
        number("friction", friction, least=0) * share,
    )
