"""The scaled LCP that all pivoting methods work on, and the conversion back to impulses."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean
from frictionbench.problems.forms.delassus import with_partners, write_partners
from frictionbench.problems.forms.lcp import impulse, tangent_basis, write_in_basis
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.inverse_basis import Matrix, compress
from frictionbench.solvers.pivots.lemke_path import FINEST, LemkeState, add_matrix_product, basic_values
from frictionbench.solvers.pivots.scaling import complete, scale_reached, scaling
from frictionbench.solvers.pivots.vectors import put

EPSILON = float(np.finfo(float).eps)
MARGIN = 0.5  # of tol: rows measure a contact's normal and tangent apart, and add up in another order
# By how a path ends (solvers.pivots.lemke_path).
STATUSES = Status.SOLVED, Status.RAY, Status.WORK_LIMIT, Status.BREAKDOWN, Status.STALLED


class ScaledLCP(NamedTuple):
    """w = M y + q, scaled; z = stretch * y. unit (2, n) is what the residual multiplies y and w by.

    problem: the friction problem, with so many facets, or the LCP itself; contacts and basis as in LCP.
    """

    problem: FrictionProblem | LCP
    facets: int
    contacts: tuple[int, int]
    basis: Array | None
    stretch: Array
    M: Matrix
    q: Array
    unit: Array

    @property
    def lcp(self) -> LCP:
        """The unscaled LCP, built on access."""
        return self.problem if isinstance(self.problem, LCP) else self.problem.lcp(self.facets)

    def answer(self, y: Array, ended: int, **work: int) -> Answer:
        z = self.stretch * y
        r = np.zeros((0, 0)) if self.basis is None else impulse(self.basis, z, self.contacts[0])
        return Answer(r, STATUSES[ended], work, z=z)


def scaled_lcp(problem: FrictionProblem | LCP, facets: int) -> ScaledLCP:
    """The scaled LCP of a friction problem, in space with so many facets, or a bare LCP scaled."""
    if isinstance(problem, LCP):
        scale = scaling(problem)
        unit = scale.theta * np.array([scale.D, 1 / scale.D]) / (np.abs(problem.q).max(initial=0.0) or 1.0)
        M, q = compress(problem.rows, scale.D), scale.vector(problem.q)
        return ScaledLCP(problem, facets, problem.contacts, problem.basis, scale.theta * scale.D, M, q, unit)
    d, mu, b_f = problem.dimension, problem.friction, problem.friction_bias
    basis = tangent_basis(d, facets)
    start, rows, column, row, *parts = scaled_friction_lcp(
        *problem.blocks, problem.q, mu, b_f, basis, problem.scale, problem.units
    )
    return ScaledLCP(problem, facets, (len(mu), d), basis, parts[0], Matrix(start, rows, column, row), *parts[1:])


@kernel
def scaled_friction_lcp(first, neighbours, block, q, friction, friction_bias, basis, scale, units):  # type: ignore[no-untyped-def]
    """The scaled matrix on its symmetrised pattern, the stretch, the scaled right side and the units."""
    nc, width = len(friction), basis.shape[1]
    n, partner, following = nc * (width + 1), np.empty(len(neighbours), np.int32), np.empty(nc, np.int32)
    if not write_partners(first, neighbours, partner, following):
        first, neighbours, block = with_partners(first, neighbours, block)
        partner = np.empty(len(neighbours), np.int32)
        write_partners(first, neighbours, partner, following)
    entries, part = most_entries(len(neighbours), nc, width), np.empty((len(neighbours), width, width))
    start, rows, column, row = np.empty(n + 1, np.int64), np.empty(entries, np.uint32), np.empty(entries), np.empty(entries)
    stretch, right, unit = np.empty(n), np.empty(n), np.empty((2, n))
    write_in_basis(block, len(neighbours), basis, part)
    law = friction, friction_bias
    write_scaled_lcp(
        first, neighbours, part, partner, q, *law, basis, scale, units, start, rows, column, row, stretch, right, unit
    )
    return start, rows[: start[n]], column[: start[n]], row[: start[n]], stretch, right, unit


@lean
def most_entries(blocks, nc, width):  # type: ignore[no-untyped-def]
    """An upper bound of the matrix's entries."""
    return blocks * width * width + 2 * nc * width


@lean
def write_scaled_lcp(  # type: ignore[no-untyped-def]
    first, neighbours, part, partner, q, friction, friction_bias, basis, scale, units, start, rows, column, row, D, right, unit
):
    """The results of scaled_friction_lcp, D the stretch, over arrays that are long enough.

    part, partner: of the blocks of W, see write_in_basis and write_partners.
    """
    nc, (d, width) = len(friction), basis.shape
    K = width - 1
    n = nc * (width + 1)
    start[0] = at = j = 0
    for tangential in range(2):  # the columns of c, then those of beta contact by contact, as problems.forms.lcp orders them
        for i in range(nc):
            for own in range(1, width) if tangential else range(1):
                right[j] = D[j] = 0.0
                for a in range(d):
                    right[j] += basis[a, own] * q[i * d + a]
                for k in range(first[i], first[i + 1]):
                    rows[at], column[at], row[at] = neighbours[k], part[partner[k], 0, own], part[k, own, 0]
                    if own == 0 and neighbours[k] == i and column[at] != 0.0:
                        D[j] = 1 / np.sqrt(abs(column[at]))
                    at += column[at] != 0.0 or row[at] != 0.0
                for k in range(first[i], first[i + 1]):
                    for m in range(1, width):
                        rows[at], column[at], row[at] = (
                            nc + neighbours[k] * K + m - 1,
                            part[partner[k], m, own],
                            part[k, own, m],
                        )
                        if own == m and neighbours[k] == i and column[at] != 0.0:
                            D[j] = 1 / np.sqrt(abs(column[at]))
                        at += column[at] != 0.0 or row[at] != 0.0
                if own:
                    rows[at], column[at], row[at] = nc * width + i, -1.0, 1.0
                    at += 1
                elif friction[i] != 0.0:
                    rows[at], column[at], row[at] = nc * width + i, friction[i], 0.0
                    at += 1
                j += 1
                start[j] = at
    for i in range(nc):  # the columns of lambda
        right[j], D[j] = friction_bias[i], 0.0
        if friction[i] != 0.0:
            rows[at], column[at], row[at] = i, 0.0, friction[i]
            at += 1
        for m in range(K):
            rows[at], column[at], row[at] = nc + i * K + m, 1.0, -1.0
            at += 1
        j += 1
        start[j] = at
    theta = _scale_symmetrised(start, rows, column, row, right, D, unit[0])
    _write_residual_units(D, theta, scale, friction, units, unit)
    for j in range(n):
        right[j] = D[j] * right[j] / theta
        D[j] *= theta


@lean
def _scale_symmetrised(start, rows, column, row, q, D, reach):  # type: ignore[no-untyped-def]
    """Scale the matrix as solvers.pivots.scaling says, D there where the diagonal is not zero; theta. reach (n,): workspace."""
    n = len(q)
    for by_rows in range(2):
        for j in range(n):
            reach[j] = 0.0
            if D[j] == 0.0:
                for e in range(start[j], start[j + 1]):
                    reach[j] = max(reach[j], D[rows[e]] * abs(row[e] if by_rows else column[e]))
        scale_reached(D, reach)
    theta = complete(D, q)
    for j in range(n):
        for e in range(start[j], start[j + 1]):
            share = D[j] * D[rows[e]]
            column[e] *= share
            row[e] *= share
    return theta


@lean
def _write_residual_units(D, theta, scale, friction, units, unit):  # type: ignore[no-untyped-def]
    """Over unit (2, n), what turns y and w into velocities relative to the contact's unit, as problems.residual measures them.

    An impulse counts s times, in its own row and in the friction row mu c - e'beta; a tangential defect counts 1 + mu times.
    """
    n, nc = len(D), len(scale)
    K = n // nc - 2 if nc else 0
    for i in range(nc):
        s, free, more = scale[i], units[i] if units[i] > 0 else 1.0, 1.0 + friction[i]
        _write_unit(unit, D, theta, i, s / free, 1.0 / free)
        force, speed = s * more / free, more / free
        for j in range(nc + i * K, nc + i * K + K):
            _write_unit(unit, D, theta, j, force, speed)
        _write_unit(unit, D, theta, n - nc + i, speed, force)


@lean
def _write_unit(unit, D, theta, j, force, speed):  # type: ignore[no-untyped-def]
    unit[0, j], unit[1, j] = theta * D[j] * force, theta * (1 / D[j]) * speed


@lean
def scaled_residual(M: Matrix, q: Array, unit: Array, y: Array, w: Array) -> float:
    """max |min(unit_0 y, unit_1 w)|, w = M y + q; infinity where that is not a number."""
    put(w, q)
    add_matrix_product(M, y, w)
    worst = 0.0
    for i in range(len(q)):
        defect = abs(min(unit[0, i] * y[i], unit[1, i] * w[i]))
        worst = max(worst, defect) if defect < np.inf else np.inf
    return worst


@lean
def scaled_rounding(M: Matrix, q: Array, unit: Array, y: Array, size: Array) -> float:
    """The scaled residual that rounding alone may leave in w = M y + q, at most the floor of problems.residual; size (n,) is
    workspace."""
    for i in range(len(q)):
        size[i] = abs(q[i])
    for j in range(len(q)):
        if y[j] != 0.0:
            for e in range(M.start[j], M.start[j + 1]):
                size[M.rows[e]] += abs(M.column[e] * y[j])
    worst = 0.0
    for i in range(len(q)):
        worst = max(worst, unit[0, i] * y[i] + unit[1, i] * size[i])
    return 2 * EPSILON * worst


@lean
def finish(state: LemkeState, q: Array, unit: Array) -> float:
    """Solve a complementary basis for q itself, as exactly as can be: y = the z part of x, cut off at 0; the residual."""
    basis = state.basis
    basic_values(basis, q, state.x, FINEST)
    for i in range(len(q)):
        state.y[i] = max(state.x[i], 0.0) if basis.row[i] >= 0 else 0.0
    return scaled_residual(basis.M, q, unit, state.y, state.v)
