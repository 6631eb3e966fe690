"""Smaller problems out of larger ones: fewer contacts, and no bodies that nothing touches any more."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.friction import FrictionProblem


def keep_contacts(problem: FrictionProblem, kept: list[int]) -> FrictionProblem:
    """The problem with only these contacts; velocities that no contact and no joint reaches go, with all coupled to them."""
    d = problem.dimension
    rows = (np.array(kept, dtype=int)[:, None] * d + np.arange(d)).ravel()
    mu, b = problem.friction[kept], problem.friction_bias[kept]
    if not problem.mechanical:
        return FrictionProblem.from_delassus(problem.W[rows][:, rows], problem.q[rows], mu, d, b)
    tangents = (np.array(kept, dtype=int)[:, None] * (d - 1) + np.arange(d - 1)).ravel()
    normal, tangent = problem.normal[kept], problem.tangent[tangents]
    _, block = connected_components(problem.mass, directed=False)
    touched = sparse.vstack([normal, tangent, problem.joints], format="csr").tocoo().col
    stay = np.flatnonzero(np.isin(block, block[touched]))
    return FrictionProblem(
        mass=problem.mass[stay][:, stay],
        normal=normal[:, stay],
        tangent=tangent[:, stay],
        friction=mu,
        free_velocity=problem.free_velocity[stay],
        bias=problem.bias[kept],
        friction_bias=b,
        joints=problem.joints[:, stay],
        joint_bias=problem.joint_bias,
        dimension=d,
    )
