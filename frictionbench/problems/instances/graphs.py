"""Random planar contact graphs of many bodies.

In a local graph each body touches only nearby ones, without a regular pattern. In a random graph any two bodies may touch, so
that every elimination order has much fill.
"""

import numpy as np
from scipy.spatial import cKDTree

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import Array, count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import touching_in_plane
from frictionbench.problems.rows import Index64

REACH = 1.05  # m, the largest distance of the centres of bodies that may touch, with one body per unit area
PAIRS = 1.6  # contacts per body, as in a disordered packing between isostatic (1.5) and hexagonal (3)
FRICTION = (0.1, 3.2)  # the range of the log-uniform coefficients
INERTIA = 0.1  # kg m^2 for 1 kg


@instance(dimension=2)
def local_graph(seed: int = 0, bodies: int = 100, mass_ratio: float = 1.0) -> FrictionProblem:
    """Planar bodies at random points that touch nearby bodies, with random normals: a large irregular contact graph.

    Bodies lie at uniform points of a square with one body per unit area. There are 1.6 contacts per body, at the midpoints of
    random pairs with distances up to 1.05. Friction is log-uniform in [.1, 3.2], and free velocities are standard normal.
    mass_ratio: masses are log-uniform in [1, mass_ratio] kg.
    """
    nb = count("bodies", bodies, least=8)
    random = np.random.default_rng([count("seed", seed, least=0), nb])
    at = random.uniform(0, np.sqrt(nb), (nb, 2))
    near = np.array(sorted(cKDTree(at).query_pairs(REACH)), dtype=int).reshape(-1, 2)
    pair = near[np.sort(random.choice(len(near), min(len(near), int(PAIRS * nb)), replace=False))]
    angle = random.uniform(0, 2 * np.pi, len(pair))
    arm = (at[pair[:, 1]] - at[pair[:, 0]]) / 2
    mass = number("mass_ratio", mass_ratio, least=1) ** random.random(nb)
    return _graph(pair, np.stack([arm, -arm], axis=1), angle, mass, random)


@instance(dimension=2)
def random_graph(seed: int = 0, bodies: int = 100) -> FrictionProblem:
    """Planar bodies that touch any others, near or not, with random points and normals: a contact graph with much fill.

    There are 1.6 contacts per body, with normally distributed arms from both centres, of standard deviation .5 m. Masses are 1
    kg; friction and free velocities are as in local_graph.
    """
    nb = count("bodies", bodies, least=8)
    random = np.random.default_rng([count("seed", seed, least=0), nb])
    nc = int(PAIRS * nb)
    first = random.integers(nb, size=nc)
    pair = np.column_stack([first, (first + random.integers(1, nb, size=nc)) % nb])
    arms = 0.5 * np.stack([random.standard_normal((nc, 2)), random.standard_normal((nc, 2))], axis=1)
    return _graph(pair, arms, random.uniform(0, 2 * np.pi, nc), np.ones(nb), random)


def _graph(pair: Index64, arms: Array, angle: Array, mass: Array, random: np.random.Generator) -> FrictionProblem:
    """The problem of bodies with masses (nb,) and contacts of pairs (nc, 2), with arms (nc, 2, 2) and normals at angles."""
    least, most = FRICTION
    friction = least * (most / least) ** random.random(len(pair))
    velocity = random.standard_normal(3 * len(mass))
    return touching_in_plane(pair, arms, angle, mass[:, None] * [1.0, 1.0, INERTIA], velocity, friction)
