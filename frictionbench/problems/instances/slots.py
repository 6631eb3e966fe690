"""Bodies whose contact points are held in slots: pairs of contacts at one point with nearly opposite normals, nearly jammed.

The normals of a pair enclose the angle pi - tilt. The two contacts can press on each other, without moving anything, if their
friction cones overlap, mu > tan(tilt/2): the cone of all contacts is then not pointed, and the data do not bound impulses.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.catalogue import instance
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.parameters import count, number
from frictionbench.problems.random_problem import random_problem


@instance
def slots(seed: int = 0, points: int = 5, tilt: float = 0.01, excess: float = 1e-3) -> FrictionProblem:
    """Planar bodies held at random points in slots that open by `tilt` (rad), without play: nearly jammed.

    Bodies, points and velocities are those of problems.random_problem; each point has two contacts. excess: the friction
    coefficient is (1 + excess) tan(tilt/2); where it is positive the friction cone is not pointed.
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
