"""A stack of cubes in space: hyperstatic, with exact ties."""

import numpy as np

from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import falling, touching
from frictionbench.problems.instances.catalogue import instance
from frictionbench.problems.parameters import count, number


@instance
def cubes(
    boxes: int = 5, friction: float = 0.5, push: float = 0.0, mass_ratio: float = 1.0, step: float = 0.01
) -> FrictionProblem:
    """A stack of unit cubes touching at their four corners, in space.

    push: m/s, in an oblique direction, increasing with height. mass_ratio: mass of the topmost over that of the lowest cube,
    geometric in between.
    """
    boxes, push = count("boxes", boxes), number("push", push)
    box, corner = np.repeat(np.arange(boxes), 4), np.array([(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
    across = np.tile(corner, (boxes, 1))
    arms = np.stack([np.column_stack([across, np.full(4 * boxes, z)]) for z in (-0.5, 0.5)], axis=1)
    upright = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    ratio = number("mass_ratio", mass_ratio, above=0)
    mass = np.geomspace(1, ratio, boxes) if boxes > 1 else np.ones(1)
    velocity = falling(boxes, number("step", step, above=0))
    velocity[:, :2] = push * np.outer(np.arange(1, boxes + 1) / boxes, [0.8, 0.6])
    return touching(
        np.column_stack([box, box - 1]),
        arms,
        np.broadcast_to(upright, (4 * boxes, 3, 3)),
        np.outer(mass, [1, 1, 1, 1 / 6, 1 / 6, 1 / 6]),
        velocity,
        number("friction", friction, least=0),
    )
