"""Smaller problems from larger ones: a subset of the contacts, without the bodies that have none left."""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.friction import FrictionProblem


def keep_contacts(problem: FrictionProblem, contacts: list[int]) -> FrictionProblem:
    """The problem with only these contacts.

    Velocities that no contact or joint acts on are removed, unless the mass matrix couples them to others that stay.
    """
    d = problem.dimension
    rows = (np.array(contacts, dtype=int)[:, None] * d + np.arange(d)).ravel()
    mu, b = problem.friction[contacts], problem.friction_bias[contacts]
    if not problem.mechanical:
        return FrictionProblem.from_delassus(problem.W[rows][:, rows], problem.q[rows], mu, d, b)
    tangents = (np.array(contacts, dtype=int)[:, None] * (d - 1) + np.arange(d - 1)).ravel()
    normal, tangent = problem.normal[contacts], problem.tangent[tangents]
    _, block = connected_components(problem.mass, directed=False)
    touched = sparse.vstack([normal, tangent, problem.joints], format="csr").tocoo().col
    stay = np.flatnonzero(np.isin(block, block[touched]))
    return FrictionProblem(
        mass=problem.mass[stay][:, stay],
        normal=normal[:, stay],
        tangent=tangent[:, stay],
        friction=mu,
        free_velocity=problem.free_velocity[stay],
        bias=problem.bias[contacts],
        friction_bias=b,
        joints=problem.joints[:, stay],
        joint_bias=problem.joint_bias,
        dimension=d,
    )
