"""Problems made smaller, taken apart and put together.

The parts of a problem are what nothing connects: no body, no joint, no entry of the mass matrix or of W. Each can be solved by
itself, exactly. That differs from the islands of problems.forms.islands, in which couplings below rounding count as none.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.rows import Index64, from_matrix


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


Parts = list[tuple[Index64, FrictionProblem]]


def separate(problem: FrictionProblem) -> Parts:
    """The parts, each with the contacts that are in it; one that is the whole problem is the problem itself."""
    part = parts(problem)
    count = int(part.max(initial=0)) + 1
    if count == 1:
        return [(np.arange(problem.contacts), problem)]
    if problem.mechanical:
        return _separate_mechanics(problem, part, count)
    order, first = _by_part(part, count)
    return [(own, keep_contacts(problem, own.tolist())) for own in np.split(order, first[1:-1])]


def parts(problem: FrictionProblem) -> Index64:
    """The part (nc,) that each contact is in, numbered from 0; with given mechanics followed by those of the velocities and of
    the joints' equations, -1 where no contact is connected with them."""
    nc, d = problem.contacts, problem.dimension
    if not problem.mechanical:
        W = problem.W.tocoo()
        return _components([W.row // d], [W.col // d], nc, nc)
    nv, nj = len(problem.free_velocity), len(problem.joint_bias)
    N, T, F, M = (matrix.tocoo() for matrix in (problem.normal, problem.tangent, problem.joints, problem.mass))
    rows = [N.row, T.row // (d - 1), nc + nv + F.row, nc + M.row]
    return _components(rows, [nc + matrix.col for matrix in (N, T, F, M)], nc + nv + nj, nc)


def _components(rows: list[Index64], columns: list[Index64], n: int, nc: int) -> Index64:
    """The component (n,) of each node, those of the first nc nodes numbered from 0, all others -1."""
    row, column = np.concatenate(rows), np.concatenate(columns)
    graph = sparse.coo_matrix((np.ones(len(row)), (row, column)), shape=(n, n))
    count, component = connected_components(graph, directed=False)
    number = np.full(count, -1)
    touched = np.unique(component[:nc])
    number[touched] = np.arange(len(touched))
    return np.asarray(number[component])


def _by_part(part: Index64, count: int) -> tuple[Index64, Index64]:
    """The items of each part, one part after the other, and where each begins, with the end of the last."""
    order = np.argsort(part, kind="stable")
    return order, np.searchsorted(part[order], np.arange(count + 1))


def _separate_mechanics(problem: FrictionProblem, part: Index64, count: int) -> Parts:
    nc, nv, d = problem.contacts, len(problem.free_velocity), problem.dimension
    of_contacts, of_velocities, of_joints = np.split(part, [nc, nc + nv])
    (contact, c), (velocity, v), (joint, j) = (_by_part(of, count) for of in (of_contacts, of_velocities, of_joints))
    tangents = (contact[:, None] * (d - 1) + np.arange(d - 1)).ravel()
    # With rows and columns in order, a part is a block.
    rows = problem.normal[contact], problem.tangent[tangents], problem.joints[joint], problem.mass[velocity]
    N, T, F, M = (matrix[:, velocity] for matrix in rows)
    found = []
    for k in range(count):
        own, bodies, joints = contact[c[k] : c[k + 1]], slice(v[k], v[k + 1]), slice(j[k], j[k + 1])
        found.append(
            (
                own,
                FrictionProblem(
                    mass=from_matrix(M[bodies, bodies]),
                    normal=from_matrix(N[c[k] : c[k + 1], bodies]),
                    tangent=from_matrix(T[c[k] * (d - 1) : c[k + 1] * (d - 1), bodies]),
                    friction=problem.friction[own],
                    free_velocity=problem.free_velocity[velocity[bodies]],
                    bias=problem.bias[own],
                    friction_bias=problem.friction_bias[own],
                    joints=from_matrix(F[joints, bodies]),
                    joint_bias=problem.joint_bias[joint[joints]],
                    dimension=d,
                ),
            )
        )
    return found


def side_by_side(*problems: FrictionProblem) -> FrictionProblem:
    """Problems of one dimension as one, without any coupling."""
    matrices = {
        name: sparse.block_diag([getattr(problem, name) for problem in problems], format="csr")
        for name in ("mass", "normal", "tangent", "joints")
    }
    names = ("friction", "free_velocity", "bias", "friction_bias", "joint_bias")
    vectors = {name: np.concatenate([getattr(problem, name) for problem in problems]) for name in names}
    return FrictionProblem(**matrices, **vectors, dimension=problems[0].dimension)
