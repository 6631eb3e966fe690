"""Piles and packings of spheres: many contacts, few degrees of freedom."""

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import cKDTree

from frictionbench.problems.catalogue import instance
from frictionbench.problems.check import Array, count, number
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.instances.bodies import GROUND, falling, touching
from frictionbench.problems.rows import Index64
from frictionbench.problems.spatial.rotation import frames

TOUCHING_GAP = 1e-4  # m: the gap up to which spheres, of radii near 0.5 m, count as touching


@instance()
def sphere_pyramid(
    seed: int = 0, levels: int = 4, friction: float = 0.5, noise: float = 0.0, mass_ratio: float = 1.0, step: float = 0.01
) -> FrictionProblem:
    """A square pyramid of unit spheres, each touching its neighbours in its layer and four below: hyperstatic.

    The normals between spheres are perturbed at random by 1e-3. noise: m/s, standard deviation of every velocity, added to
    gravity. mass_ratio: masses are log-uniform in [1, mass_ratio] kg.
    """
    levels = count("levels", levels)
    random = np.random.default_rng([count("seed", seed, least=0), levels])
    centre = np.array(
        [(i + k / 2, j + k / 2, k / np.sqrt(2)) for k in range(levels) for i in range(levels - k) for j in range(levels - k)]
    )
    near = cKDTree(centre).query_pairs(1.01, output_type="ndarray")
    near = np.array(sorted((max(pair), min(pair)) for pair in near.tolist()), dtype=int).reshape(-1, 2)
    floor = np.arange(levels**2)
    bodies = np.vstack([np.column_stack([floor, np.full(len(floor), GROUND)]), near])
    arms, frame = np.zeros((len(bodies), 2, 3)), np.zeros((len(bodies), 3, 3))
    for i, (a, b) in enumerate(bodies):
        between = np.array([0.0, 0.0, 1.0]) if b == GROUND else centre[a] - centre[b]
        normal = between + (1e-3 * random.standard_normal(3) if b != GROUND else 0)
        frame[i] = np.linalg.qr(np.column_stack([normal, random.standard_normal((3, 2))]))[0].T
        frame[i, 0] = normal / np.linalg.norm(normal)
        arms[i] = -between / 2, between / 2
    velocity = number("noise", noise, least=0) * random.standard_normal((len(centre), 6))
    velocity += falling(len(centre), number("step", step, above=0))
    mass = number("mass_ratio", mass_ratio, least=1) ** random.random(len(centre))
    return touching(
        bodies, arms, frame, _weights(mass, np.full(len(centre), 0.5)), velocity, number("friction", friction, least=0)
    )


@instance()
def packed_spheres(
    seed: int = 0,
    spheres: int = 50,
    fraction: float = 0.64,
    friction: float = 0.5,
    noise: float = 0.1,
    mass_ratio: float = 1.0,
    step: float = 0.01,
) -> FrictionProblem:
    """Spheres packed at random in a closed box. fraction: of the box that they fill; random close packing has .64 in large
    boxes and less in small ones, because of the walls.

    The diameters are 0.95 to 1.05 m. Random centres are moved to a local minimum of the sum of squared overlaps. Spheres that
    touch there have contacts with gap 0. noise: m/s, standard deviation of every velocity, added to gravity. mass_ratio: masses
    are log-uniform in [1, mass_ratio] kg.
    """
    n = count("spheres", spheres)
    random = np.random.default_rng([count("seed", seed, least=0), n])
    radius = 0.5 * random.uniform(0.95, 1.05, n)
    side = float(np.cbrt(4 / 3 * np.pi * (radius**3).sum() / number("fraction", fraction, above=0, most=0.7)))
    centre = _least_overlap(random.uniform(0, side, (n, 3)), radius, side)
    bodies, normal = _touching_pairs(centre, radius, side)
    arms = np.zeros((len(bodies), 2, 3))
    for which, sign in ((0, -1.0), (1, 1.0)):
        arms[:, which] = sign * radius[bodies[:, which]][:, None] * normal
    velocity = number("noise", noise, least=0) * random.standard_normal((n, 6)) + falling(n, number("step", step, above=0))
    mass = number("mass_ratio", mass_ratio, least=1) ** random.random(n)
    return touching(bodies, arms, frames(normal), _weights(mass, radius), velocity, number("friction", friction, least=0))


def _weights(mass: Array, radius: Array) -> Array:
    inertia = 0.4 * mass * radius**2
    return np.column_stack([mass, mass, mass, inertia, inertia, inertia])


def _least_overlap(centre: Array, radius: Array, side: float) -> Array:
    """Centres (n, 3) at a local minimum of the sum of squared overlaps of spheres and walls."""
    n = len(radius)

    def energy(flat: Array) -> tuple[float, Array]:
        x = flat.reshape(n, 3)
        pairs = cKDTree(x).query_pairs(2 * radius.max(), output_type="ndarray")
        between = x[pairs[:, 0]] - x[pairs[:, 1]]
        distance = np.maximum(np.linalg.norm(between, axis=1), 1e-12)
        overlap = np.maximum(radius[pairs].sum(axis=1) - distance, 0.0)
        push = (overlap / distance)[:, None] * between
        low, high = np.maximum(radius[:, None] - x, 0.0), np.maximum(x + radius[:, None] - side, 0.0)
        slope = high - low
        ends, push = np.concatenate([pairs[:, 0], pairs[:, 1]]), np.vstack([-push, push])
        slope += np.column_stack([np.bincount(ends, along, minlength=n) for along in push.T])
        return float((overlap**2).sum() + (low**2).sum() + (high**2).sum()) / 2, slope.ravel()

    minimum = minimize(energy, centre.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": 1000, "gtol": 1e-7})
    return np.asarray(minimum.x).reshape(n, 3)


def _touching_pairs(centre: Array, radius: Array, side: float) -> tuple[Index64, Array]:
    """The bodies (nc, 2) and normals (nc, 3) of spheres that touch each other or a wall."""
    pairs = np.array(sorted(cKDTree(centre).query_pairs(2.1 * radius.max())), dtype=int).reshape(-1, 2)
    between = centre[pairs[:, 0]] - centre[pairs[:, 1]]
    distance = np.linalg.norm(between, axis=1)
    close = distance - radius[pairs].sum(axis=1) <= TOUCHING_GAP
    bodies, normal = [pairs[close]], [between[close] / distance[close][:, None]]
    for axis, sign in ((axis, sign) for axis in range(3) for sign in (1.0, -1.0)):
        gap = (centre[:, axis] if sign > 0 else side - centre[:, axis]) - radius
        at = np.flatnonzero(gap <= TOUCHING_GAP)
        bodies.append(np.column_stack([at, np.full(len(at), GROUND)]))
        normal.append(np.broadcast_to(sign * np.eye(3)[axis], (len(at), 3)))
    return np.vstack(bodies), np.vstack(normal)
