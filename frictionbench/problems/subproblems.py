"""Problems reduced to some contacts, separated into parts, and combined.

The parts of a problem are not connected by any body, joint, or entry of the mass matrix or of W. Each can be solved by itself,
exactly. The islands of problems.forms.islands differ: they ignore couplings below rounding.
"""

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.rows import Index64


def keep_contacts(problem: FrictionProblem, contacts: list[int]) -> FrictionProblem:
    """The problem with only these contacts.

    Velocities that no contact or joint acts on are removed, unless the mass matrix couples them to others that stay.
    """
    chosen, none = np.array(contacts, dtype=int), np.zeros(0, dtype=int)
    if not problem.mechanical:
        return _taken(problem, chosen, none, none)
    _, block = connected_components(problem.mass, directed=False)
    touched = np.append(problem.jacobian[_rows(chosen, problem.dimension)].tocoo().col, problem.joints.tocoo().col)
    stay = np.flatnonzero(np.isin(block, block[touched]))
    return _taken(problem, chosen, stay, np.arange(len(problem.joint_bias)))


def separate(problem: FrictionProblem) -> Iterator[tuple[Index64, FrictionProblem]]:
    """The parts one by one, each with the numbers of its contacts. If there is only one part, it is the problem itself."""
    part, nc, nv = problem.parts, problem.contacts, len(problem.free_velocity)
    count = int(part.max(initial=0)) + 1
    if count == 1:
        yield np.arange(nc), problem
        return
    for k in range(count):
        contacts, velocities, joints = (np.flatnonzero(of == k) for of in np.split(part, [nc, nc + nv]))
        yield contacts, _taken(problem, contacts, velocities, joints)


def _taken(problem: FrictionProblem, contacts: Index64, velocities: Index64, joints: Index64) -> FrictionProblem:
    """The problem with only these contacts and, if it is mechanical, these velocities and joint equations."""
    d, mu, b = problem.dimension, problem.friction[contacts], problem.friction_bias[contacts]
    if not problem.mechanical:
        rows = _rows(contacts, d)
        return FrictionProblem.from_delassus(problem.W[rows][:, rows], problem.q[rows], mu, d, b)
    return FrictionProblem(
        mass=problem.mass[velocities][:, velocities],
        normal=problem.normal[contacts][:, velocities],
        tangent=problem.tangent[_rows(contacts, d - 1)][:, velocities],
        friction=mu,
        free_velocity=problem.free_velocity[velocities],
        bias=problem.bias[contacts],
        friction_bias=b,
        joints=problem.joints[joints][:, velocities],
        joint_bias=problem.joint_bias[joints],
        dimension=d,
    )


def _rows(contacts: Index64, count: int) -> Index64:
    """The rows of these contacts, `count` rows for each."""
    return (contacts[:, None] * count + np.arange(count)).ravel()


def side_by_side(*problems: FrictionProblem) -> FrictionProblem:
    """Problems of the same dimension combined into one, without any coupling."""
    matrices = {
        name: sparse.block_diag([getattr(problem, name) for problem in problems], format="csr")
        for name in ("mass", "normal", "tangent", "joints")
    }
    names = ("friction", "free_velocity", "bias", "friction_bias", "joint_bias")
    vectors = {name: np.concatenate([getattr(problem, name) for problem in problems]) for name in names}
    return FrictionProblem(**matrices, **vectors, dimension=problems[0].dimension)
