"""Random friction problems of mechanical origin: bodies, contact points and normals, so that W = J M^-1 J'.

Every draw has b >= 0, so it has a solution and Lemke's method reaches one (Anitescu and Potra 1997). They cover what is rare in
scenes: large mu, irregular contact graphs, mass ratios, more contacts than degrees of freedom.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.rows import planar_relative


def random_problem(
    seed: int, contacts: int = 10, bodies: int | None = None, friction: float | None = None, mass_ratio: float = 10.0
) -> FrictionProblem:
    """Planar bodies (3 degrees of freedom each) touching each other or the ground at random points.

    bodies: by default a draw between 1 and contacts. friction: one coefficient for all, by default drawn per problem
    log-uniformly from [.05, 10] and varied by a factor of up to 2 per contact. mass_ratio: masses are log-uniform in
    [1, mass_ratio] kg. Contacts can number up to twice the degrees of freedom, so W is often rank deficient.
    """
    count("contacts", contacts)
    number("mass_ratio", mass_ratio, least=1)
    random = np.random.default_rng(count("seed", seed, least=0))
    nb = int(random.integers(max(1, contacts // 6), contacts + 1)) if bodies is None else count("bodies", bodies)
    mass = mass_ratio ** random.random(nb)
    inertia = mass * random.uniform(0.05, 0.5, nb)
    first = random.integers(nb, size=contacts)
    second = np.where(random.random(contacts) < 0.5, -1, random.integers(nb, size=contacts))
    second[second == first] = -1  # the ground
    angle = random.uniform(0, 2 * np.pi, contacts)
    n = np.column_stack([np.cos(angle), np.sin(angle)])
    t = np.column_stack([-n[:, 1], n[:, 0]])
    pair, arms = np.column_stack([first, second]), np.zeros((contacts, 2, 2))
    arms[pair >= 0] = random.uniform(-1, 1, ((pair >= 0).sum(), 2))
    mu = 10 ** random.uniform(np.log10(0.05), 1) if friction is None else number("friction", friction, least=0)
    spread = random.uniform(0.5, 1, contacts) if friction is None else np.ones(contacts)
    return FrictionProblem(
        mass=sparse.diags_array(np.column_stack([mass, mass, inertia]).ravel()),
        normal=planar_relative(pair, arms, n),
        tangent=planar_relative(pair, arms, t),
        friction=mu * spread,
        free_velocity=random.standard_normal(3 * nb),
        bias=np.where(random.random(contacts) < 0.3, random.random(contacts), 0.0),
    )
