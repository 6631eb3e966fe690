"""What every pivoting method here works on: the scaled LCP, and the way back to impulses."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit

from problems import LCP, FrictionProblem
from problems.check import Array
from problems.forms.lcp import friction_rows, tangent_basis
from problems.rows import Rows
from solvers.interface import Answer, Status
from solvers.pivots.inverse_basis import Basis, Matrix, compress, symmetrised
from solvers.pivots.lemke_path import COMPLEMENTARY, LIMIT, LOST, RAY, STUCK, add_product, evaluate
from solvers.pivots.scaling import Scaling, diagonal_scaling, scaling
from solvers.pivots.vectors import put

MARGIN = 0.5  # of tol: rows measure a contact's normal and tangent apart, and add up in another order
STATUS = {
    COMPLEMENTARY: Status.SOLVED,
    RAY: Status.RAY,
    LIMIT: Status.WORK_LIMIT,
    LOST: Status.BREAKDOWN,
    STUCK: Status.STALLED,
}


class ScaledLCP(NamedTuple):
    """w = M y + q, scaled; unit (2, n) is what the residual multiplies y and w by."""

    lcp: LCP
    scale: Scaling
    M: Matrix
    q: Array
    unit: Array

    def answer(self, y: Array, ended: int, **work: int) -> Answer:
        z = self.scale.solution(y)
        return Answer(self.lcp.impulse(z), STATUS[ended], work, z=z)


def pivot_by(method: Callable[..., tuple[int, Array, int, int]], lcp: ScaledLCP, tol: float, limit: int | None) -> Answer:
    """The answer of a principal pivoting method within limit pivots, by default 10 000 + 100 n.

    tol is halved: the verifier's norm is another, and it adds up in another order.
    """
    ended, y, pivots, inversions = method(lcp.M, lcp.q, lcp.unit, MARGIN * tol, limit or 10_000 + 100 * len(lcp.q))
    return lcp.answer(y, ended, pivots=pivots, inversions=inversions)


def scaled_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> ScaledLCP:
    """The scaled LCP of a friction problem, in space with so many facets, or a bare LCP scaled."""
    if isinstance(problem, LCP):
        scale = scaling(problem)
        unit = scale.theta * np.array([scale.D, 1 / scale.D]) / (np.abs(problem.q).max(initial=0.0) or 1.0)
        return ScaledLCP(problem, scale, compress(problem.rows, scale.D), scale.vector(problem.q), unit)
    d, mu, b_f = problem.dimension, problem.friction, problem.friction_bias
    basis = tangent_basis(d, facets)
    along = problem.q.reshape(-1, d) @ basis
    parts = _of_friction(*problem.blocks, along, mu, b_f, basis, problem.scale, problem.fastest)
    lcp = LCP.of_friction(Rows(*parts[:3]), parts[3], basis, (len(mu), d))
    return ScaledLCP(lcp, Scaling(*parts[4:6]), Matrix(*parts[6:10]), *parts[10:])


@njit(cache=True, no_cfunc_wrapper=True)
def _of_friction(first, beside, block, along, friction, friction_bias, basis, scale, fastest):  # type: ignore[no-untyped-def]
    """The LCP by rows and its right side, D, theta, the scaled matrix on its symmetrised pattern, q and the units."""
    start, column, value, right = friction_rows(first, beside, block, along, friction, friction_bias, basis)
    D, theta = diagonal_scaling(start, column, value, right)
    q = np.empty(len(D))
    for i in range(len(D)):
        q[i] = D[i] * right[i] / theta
    begin, rows, below, across = symmetrised(start, column, value, D)
    unit = _in_velocities(D, theta, scale, friction, fastest)
    return start, column, value, right, D, theta, begin, rows, below, across, q, unit


@njit(cache=True, no_cfunc_wrapper=True)
def _in_velocities(D, theta, scale, friction, fastest):  # type: ignore[no-untyped-def]
    """(2, n): what turns y and w into velocities relative to the largest free one, as problems.residual measures them.

    An impulse counts s times, in its own row and in the friction row mu c - e'beta; a tangential defect counts 1 + mu times.
    """
    n, nc = len(D), len(scale)
    free = fastest if fastest > 0 else 1.0
    unit = np.empty((2, n))
    for j in range(n):
        i = j if j < nc else j - (n - nc) if j >= n - nc else (j - nc) // ((n - 2 * nc) // nc)
        s = scale[i]
        more = 1.0 if j < nc else 1.0 + friction[i]
        unit[0, j] = theta * D[j] * ((s if j < n - nc else 1.0) * more / free)
        unit[1, j] = theta * (1 / D[j]) * ((1.0 if j < n - nc else s) * more / free)
    return unit


@njit(cache=True, error_model="numpy")
def residual(M: Matrix, q: Array, unit: Array, y: Array, w: Array) -> float:
    """max |min(unit_0 y, unit_1 w)|, w = M y + q; infinity where that is not a number."""
    put(w, q)
    add_product(M, y, w)
    worst = 0.0
    for i in range(len(q)):
        defect = abs(min(unit[0, i] * y[i], unit[1, i] * w[i]))
        worst = max(worst, defect) if defect < np.inf else np.inf
    return worst


@njit(cache=True, error_model="numpy")
def finish(M: Matrix, d: Array, basis: Basis, q: Array, unit: Array, x: Array, y: Array, out: Array) -> float:
    """Solve a complementary basis for q itself, as exactly as can be: x (n+1,), y = its z part, cut off at 0; the residual."""
    evaluate(M, d, basis, q, x, out, 4e-16)  # twice the rounding: asking for less refines in vain
    for i in range(len(q)):
        y[i] = max(x[i], 0.0) if basis.row[i] >= 0 else 0.0
    return residual(M, q, unit, y, out)
