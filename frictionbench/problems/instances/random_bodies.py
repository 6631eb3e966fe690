"""Random contacts between random bodies: irregular contact graphs and directions, large mu, mass ratios, and more contacts than
degrees of freedom, which are rare in scenes.

In slots, every point has a pair of contacts, whose normals enclose the angle pi - tilt. The two can press on each other without
moving anything if their friction cones overlap, mu > tan(tilt/2). The total friction cone is then not pointed, and the data do
not bound the impulses. In unlike_islands, a norm over the whole problem may hide the error of a slow island.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import touching, touching_in_plane
from frictionbench.problems.subproblems import side_by_side


@instance()
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


@instance(dimension=2, name="random")
def random_problem(
    seed: int = 0, contacts: int = 10, bodies: int | None = None, friction: float | None = None, mass_ratio: float = 10.0
) -> FrictionProblem:
    """Planar bodies (3 degrees of freedom each) touching each other or the ground at random points.

    bodies: by default random, between contacts/6 and contacts. friction: one coefficient for all contacts; by default random
    for each problem, log-uniform in [.05, 10], and varied by a factor of up to 2 per contact. mass_ratio: masses are
    log-uniform in [1, mass_ratio] kg. There can be twice as many contacts as degrees of freedom, so W is often rank deficient.
    Since b >= 0, every problem has a solution, which Lemke's method reaches (Anitescu and Potra 1997).
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
    pair, arms = np.column_stack([first, second]), np.zeros((contacts, 2, 2))
    arms[pair >= 0] = random.uniform(-1, 1, ((pair >= 0).sum(), 2))
    mu = 10 ** random.uniform(np.log10(0.05), 1) if friction is None else number("friction", friction, least=0)
    spread = random.uniform(0.5, 1, contacts) if friction is None else np.ones(contacts)
    velocity = random.standard_normal(3 * nb)
    gaps = np.where(random.random(contacts) < 0.3, random.random(contacts), 0.0)
    return touching_in_plane(pair, arms, angle, np.column_stack([mass, mass, inertia]), velocity, mu * spread, gaps)


@instance(dimension=2)
def slots(seed: int = 0, points: int = 5, tilt: float = 0.01, excess: float = 1e-3) -> FrictionProblem:
    """Planar bodies held at random points in slots that open by `tilt` (rad), without play: nearly jammed.

    Bodies, points and velocities are those of random; each point has two contacts. excess: the friction
    coefficient is (1 + excess) tan(tilt/2); if excess is positive, the friction cone is not pointed.
    """
    nc = count("points", points)
    tilt = number("tilt", tilt, above=0, most=3.0)
    mu = (1 + number("excess", excess, above=-1)) * np.tan(tilt / 2)
    side = random_problem(count("seed", seed, least=0), nc, friction=mu)
    n, t, cos, sin = side.normal, side.tangent, np.cos(tilt), np.sin(tilt)
    return FrictionProblem(
        mass=side.mass,
        normal=sparse.vstack([n, sin * t - cos * n]),
        tangent=sparse.vstack([t, -sin * n - cos * t]),
        friction=np.full(2 * nc, mu),
        free_velocity=side.free_velocity,
        bias=np.zeros(2 * nc),
    )


@instance(dimension=2)
def unlike_islands(
    seed: int = 0, islands: int = 4, contacts: int = 5, velocity_ratio: float = 1e4, friction: float = 0.5
) -> FrictionProblem:
    """Several random planar problems (random) side by side, with velocities of different magnitudes.

    contacts: of each. velocity_ratio: the free velocities and gaps of the first island divided by those of the last, geometric
    in between.
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
