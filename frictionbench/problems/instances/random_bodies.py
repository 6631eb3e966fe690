"""Random contacts between random bodies: irregular contact graphs and directions, which are rare in scenes."""

import numpy as np

from frictionbench.problems.catalogue import instance
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import touching
from frictionbench.problems.parameters import count, number
from frictionbench.problems.random_problem import random_problem


@instance
def random_bodies(seed: int = 0, contacts: int = 20, friction: float = 0.5, mass_ratio: float = 10.0) -> FrictionProblem:
    """Spatial contacts in random directions between random pairs of bodies, with half as many bodies as contacts.

    mass_ratio: masses are log-uniform in [1, mass_ratio] kg.
    """
    nc = count("contacts", contacts)
    random = np.random.default_rng(count("seed", seed, least=0))
    bodies = max(2, nc // 2)
    pair, arms, frame = np.zeros((nc, 2), int), np.zeros((nc, 2, 3)), np.zeros((nc, 3, 3))
    for i in range(nc):
        frame[i] = np.linalg.qr(random.standard_normal((3, 3)))[0]
        pair[i] = random.choice(bodies, 2, replace=False)
        arms[i] = random.uniform(-0.5, 0.5, 3), random.uniform(-0.5, 0.5, 3)
    mass = number("mass_ratio", mass_ratio, least=1) ** random.random(bodies)
    weights = np.outer(mass, [1, 1, 1, 1 / 6, 1 / 6, 1 / 6])
    velocity = random.standard_normal((bodies, 6))
    return touching(pair, arms, frame, weights, velocity, number("friction", friction, least=0))


@instance
def random(
    seed: int = 0, contacts: int = 10, bodies: int | None = None, friction: float | None = None, mass_ratio: float = 10.0
) -> FrictionProblem:
    """Planar bodies touching each other or the ground at random points (problems.random_problem)."""
    return random_problem(seed, contacts, bodies, friction, mass_ratio)
