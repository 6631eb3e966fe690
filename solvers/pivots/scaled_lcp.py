"""The scaled LCP that all pivoting methods work on, and the conversion back to impulses."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean, part
from frictionbench.problems.forms.lcp import friction_rows, impulse, tangent_basis
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.inverse_basis import InverseBasis, Matrix, compress, symmetrised
from frictionbench.solvers.pivots.lemke_path import FINEST, add_matrix_product, basic_values
from frictionbench.solvers.pivots.scaling import diagonal_scaling, scaling
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
    start, column, value, right = friction_rows(first, neighbours, block, q, friction, friction_bias, basis)
    D, theta = diagonal_scaling(start, column, value, right)
    begin, rows, below, across = symmetrised(start, column, value, D)
    unit = _residual_units(D, theta, scale, friction, units)
    for i in range(len(D)):
        right[i] = D[i] * right[i] / theta
        D[i] *= theta
    return begin, rows, below, across, D, right, unit


@part
def _residual_units(D, theta, scale, friction, units):  # type: ignore[no-untyped-def]
    """(2, n): what turns y and w into velocities relative to the contact's unit, as problems.residual measures them.

    An impulse counts s times, in its own row and in the friction row mu c - e'beta; a tangential defect counts 1 + mu times.
    """
    n, nc = len(D), len(scale)
    unit = np.empty((2, n))
    width = n // nc if nc else 0
    for i in range(nc):
        s, free = scale[i], units[i] if units[i] > 0 else 1.0
        for m in range(width):  # c, beta and lambda of contact i
            j = i if m == 0 else nc + i * (width - 2) + m - 1 if m < width - 1 else n - nc + i
            more = 1.0 if m == 0 else 1.0 + friction[i]
            unit[0, j] = theta * D[j] * ((s if m < width - 1 else 1.0) * more / free)
            unit[1, j] = theta * (1 / D[j]) * ((1.0 if m < width - 1 else s) * more / free)
    return unit


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


@part
def finish(M: Matrix, d: Array, basis: InverseBasis, q: Array, unit: Array, x: Array, y: Array, out: Array) -> float:
    """Solve a complementary basis for q itself, as exactly as can be: x (n+1,), y = its z part, cut off at 0; the residual."""
    basic_values(M, d, basis, q, x, out, FINEST)
    for i in range(len(q)):
        y[i] = max(x[i], 0.0) if basis.row[i] >= 0 else 0.0
    return scaled_residual(M, q, unit, y, out)
