"""The scaled LCP that all LCP methods of this package solve, its residual, and the conversion back to impulses.

With a positive diagonal D and a number theta, z = theta D y turns LCP(M, q) into

    w^ = (D M D) y + (D q) / theta,      D_i = 1/sqrt(M_ii),      theta = max |D q|,

which has a unit diagonal, a right-hand side of unit size, and the same solutions and signs, so that tolerances inside a method
are dimensionless. A row without a diagonal entry (the sliding speed of a friction contact) is scaled by the column through
which it acts: D_i = 1 / max_j D_j |M_ji|. Rows and columns of zeros are not scaled.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean
from frictionbench.problems.forms.delassus import write_partners
from frictionbench.problems.forms.islands import EPSILON
from frictionbench.problems.forms.lcp import impulse, tangent_basis, write_in_basis
from frictionbench.problems.residual import polygon_residual, residual
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.inverse_basis import Matrix, symmetrised
from frictionbench.solvers.pivots.lemke_path import FINEST, LemkeState, add_matrix_product, basic_values
from frictionbench.solvers.pivots.vectors import put

# Indexed by how a path ends (solvers.pivots.lemke_path).
STATUSES = Status.SOLVED, Status.RAY, Status.WORK_LIMIT, Status.BREAKDOWN, Status.STALLED


class ScaledLCP(NamedTuple):
    """The scaled LCP w = M y + q, with z = stretch * y. unit (2, n): the factors of y and w in the residual.

    problem: the friction problem, with a polygon of so many facets in space, or a bare LCP. contacts, basis: as in LCP.
    """

    problem: FrictionProblem | LCP
    facets: int
    contacts: tuple[int, int]
    basis: Array | None
    stretch: Array
    M: Matrix
    q: Array
    unit: Array

    def answer(self, y: Array, status: Status, detail: str = "", clock: float | None = None, **work: int) -> Answer:
        """The answer of a scaled solution y (n,)."""
        z = self.stretch * y
        r = np.zeros((0, 0)) if self.basis is None else impulse(self.basis, z, self.contacts[0])
        return Answer(r, status, work, z=z, detail=detail, clock=clock)

    def residual(self, y: Array) -> float:
        """The residual to which tol refers: of the friction problem, of its polygon if it is in space, or of a bare LCP."""
        z = self.stretch * y
        if isinstance(self.problem, LCP):
            return self.problem.residual(z)
        if self.problem.dimension == 3:
            return polygon_residual(self.problem, self.problem.lcp(self.facets), z)
        return residual(self.problem, impulse(self.basis, z, self.contacts[0]))


def scaled_lcp(problem: FrictionProblem | LCP, facets: int) -> ScaledLCP:
    """The scaled LCP of a friction problem, in space with so many facets, or of a bare LCP."""
    if isinstance(problem, LCP):
        return ScaledLCP(problem, facets, problem.contacts, problem.basis, *scaled_bare_lcp(*problem.rows, problem.q))
    d, mu, b_f = problem.dimension, problem.friction, problem.friction_bias
    basis = tangent_basis(d, facets)
    scaled = scaled_friction_lcp(*problem.blocks, problem.q, mu, b_f, basis, problem.scale, problem.units)
    return ScaledLCP(problem, facets, (len(mu), d), basis, *scaled)


@kernel
def scaled_bare_lcp(start, column, value, q):  # type: ignore[no-untyped-def]
    """The stretch, the scaled matrix on its symmetrised pattern, the scaled right-hand side, and the units of LCP.residual."""
    M, n, size = symmetrised(start, column, value), len(q), 0.0
    D, right, unit = np.zeros(n), np.empty(n), np.empty((2, n))
    for j in range(n):
        size = max(size, abs(q[j]))
        for e in range(M.start[j], M.start[j + 1]):
            if M.rows[e] == j and M.column[e] != 0.0:
                D[j] = 1 / np.sqrt(abs(M.column[e]))
    theta = _scale_symmetrised(M.start, M.rows, M.column, M.row, q, D, unit[0])
    size = size if size > 0 else 1.0
    for j in range(n):
        _write_unit(unit, D, theta, j, 1.0 / size, 1.0 / size)
        right[j] = D[j] * q[j] / theta
        D[j] *= theta
    return D, M, right, unit


@kernel
def scaled_friction_lcp(first, neighbours, block, q, friction, friction_bias, basis, scale, units):  # type: ignore[no-untyped-def]
    """The same for a friction LCP; the units are those of problems.residual."""
    nc, width = len(friction), basis.shape[1]
    n, partner = nc * (width + 1), np.empty(len(neighbours), np.int32)
    write_partners(first, neighbours, partner, np.empty(nc, np.int32))
    entries, part = most_entries(len(neighbours), nc, width), np.empty((len(neighbours), width, width))
    start, rows, column, row = np.empty(n + 1, np.int64), np.empty(entries, np.uint32), np.empty(entries), np.empty(entries)
    stretch, right, unit = np.empty(n), np.empty(n), np.empty((2, n))
    write_in_basis(block, len(neighbours), basis, part)
    law = friction, friction_bias
    write_scaled_lcp(
        first, neighbours, part, partner, q, *law, basis, scale, units, start, rows, column, row, stretch, right, unit
    )
    return stretch, Matrix(start, rows[: start[n]], column[: start[n]], row[: start[n]]), right, unit


@lean
def most_entries(blocks, nc, width):  # type: ignore[no-untyped-def]
    """An upper bound of the matrix's entries."""
    return blocks * width * width + 2 * nc * width


@lean
def write_scaled_lcp(  # type: ignore[no-untyped-def]
    first, neighbours, part, partner, q, friction, friction_bias, basis, scale, units, start, rows, column, row, D, right, unit
):
    """Write the results of scaled_friction_lcp, D being the stretch, to arrays that are long enough.

    part, partner: of the blocks of W, see write_in_basis and write_partners.
    """
    nc, (d, width) = len(friction), basis.shape
    K = width - 1
    n = nc * (width + 1)
    start[0] = at = j = 0
    for tangential in range(2):  # the columns of c, then those of beta contact by contact, as problems.forms.lcp orders them
        for i in range(nc):
            for b in range(1, width) if tangential else range(1):
                right[j] = D[j] = 0.0
                for a in range(d):
                    right[j] += basis[a, b] * q[i * d + a]
                for k in range(first[i], first[i + 1]):
                    rows[at], column[at], row[at] = neighbours[k], part[partner[k], 0, b], part[k, b, 0]
                    if b == 0 and neighbours[k] == i and column[at] != 0.0:
                        D[j] = 1 / np.sqrt(abs(column[at]))
                    at += column[at] != 0.0 or row[at] != 0.0
                for k in range(first[i], first[i + 1]):
                    for m in range(1, width):
                        rows[at], column[at], row[at] = (
                            nc + neighbours[k] * K + m - 1,
                            part[partner[k], m, b],
                            part[k, b, m],
                        )
                        if b == m and neighbours[k] == i and column[at] != 0.0:
                            D[j] = 1 / np.sqrt(abs(column[at]))
                        at += column[at] != 0.0 or row[at] != 0.0
                if b:
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
    """Scale the matrix and complete D, which is given for nonzero diagonal entries; return theta. reach (n,): workspace.

    Rows without a diagonal entry are scaled by their columns, then the remaining ones by their rows.
    """
    n, theta = len(q), 0.0
    for by_rows in range(2):
        for j in range(n):
            reach[j] = 0.0
            if D[j] == 0.0:
                for e in range(start[j], start[j + 1]):
                    reach[j] = max(reach[j], D[rows[e]] * abs(row[e] if by_rows else column[e]))
        for j in range(n):
            if reach[j] > 0:
                D[j] = 1 / reach[j]
    for j in range(n):
        D[j] = D[j] if D[j] != 0 else 1.0
        theta = max(theta, abs(D[j] * q[j]))
    for j in range(n):
        for e in range(start[j], start[j + 1]):
            share = D[j] * D[rows[e]]
            column[e] *= share
            row[e] *= share
    return theta if theta > 0 else 1.0


@lean
def _write_residual_units(D, theta, scale, friction, units, unit):  # type: ignore[no-untyped-def]
    """Write to unit (2, n) the factors that make y and w velocities relative to the contact's unit, as in problems.residual.

    Impulses are multiplied by s, also in the friction row mu c - e'beta, and tangential defects by 1 + mu.
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
    """The residual of y; w is overwritten with M y + q."""
    put(w, q)
    add_matrix_product(M, y, w)
    return measured(unit, y, w)


@lean
def measured(unit: Array, y: Array, w: Array) -> float:
    """max |min(unit_0 y, unit_1 w)|; infinity if an entry is NaN."""
    worst = 0.0
    for i in range(len(y)):
        defect = abs(min(unit[0, i] * y[i], unit[1, i] * w[i]))
        worst = max(worst, defect) if defect < np.inf else np.inf
    return worst


@lean
def scaled_rounding(M: Matrix, q: Array, unit: Array, y: Array, size: Array) -> float:
    """The scaled residual that rounding alone may leave in w = M y + q; size (n,) is workspace."""
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
    """Solve a complementary basis for the unperturbed q; y is the z part, without negative entries. Returns the residual."""
    basis = state.basis
    basic_values(basis, q, state.x, FINEST)
    for i in range(len(q)):
        state.y[i] = max(state.x[i], 0.0) if basis.row[i] >= 0 else 0.0
    return scaled_residual(basis.M, q, unit, state.y, state.v)
