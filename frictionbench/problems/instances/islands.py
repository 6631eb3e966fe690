"""Several problems side by side that share no body, with velocities of unlike size: a part may be lost in the whole."""

import numpy as np

from frictionbench.problems.catalogue import instance
from frictionbench.problems.combine import side_by_side
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.parameters import count, number
from frictionbench.problems.random_problem import random_problem


@instance
def unlike_islands(
    seed: int = 0, islands: int = 4, contacts: int = 5, velocity_ratio: float = 1e4, friction: float = 0.5
) -> FrictionProblem:
    """Planar random problems (problems.random_problem) of five contacts each, side by side, with velocities of unlike size.

    velocity_ratio: the free velocities and gaps of the first island over those of the last, geometric in between.
    """
    n, nc = count("islands", islands), count("contacts", contacts)
    mu = number("friction", friction, least=0)
    speed = np.geomspace(number("velocity_ratio", velocity_ratio, above=0), 1.0, n)
    first = n * count("seed", seed, least=0)
    parts = [random_problem(first + k, nc, friction=mu) for k in range(n)]
    scaled = (
        part.replace(free_velocity=v * part.free_velocity, bias=v * part.bias) for v, part in zip(speed, parts, strict=True)
    )
    return side_by_side(*scaled)
