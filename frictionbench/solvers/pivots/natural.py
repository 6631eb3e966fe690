"""The natural residual of a scaled LCP, in the measure of problems.residual.

With z = theta D y and w = theta w^ / D (solvers.pivots.scaling) it is max_i g_i |min(y_i, w^_i)|, where

    g_i = (1 + m) theta D_i s_i / max|q|,      s_i = M_ii, or 1 for a row without a diagonal,

which in the problem's own units is (1 + m) max_i |min(M_ii z_i, w_i)| / max|q|: heavy and light bodies have the same weight,
and it is independent of units. Where the LCP is a friction problem's, s_i is at least the contact's s, the step in
problems.residual. m is the largest scaled entry of a row without a diagonal: the friction coefficient, or 1, with which a
defect in the tangent comes back in the normal. That makes it a bound of the exact residual up to a small factor: solvers stop
at MARGIN times the tolerance, and evaluate the exact residual at the end. There max|q| is bounded by the largest of the
contacts' units, and multiplied by the contact's own over that.
"""

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.lcp import contact_of
from frictionbench.problems.residual import polygon_residual, residual
from frictionbench.solvers.pivots.scaling import Scaling, diagonal_scaling

MARGIN = 0.1  # of tol: the natural residual bounds the exact one up to a factor below 10 (tested in test_path_search)


def natural_weight(problem: FrictionProblem | LCP, lcp: LCP, scale: Scaling) -> Array:
    """g (n,) for the LCP of a problem, or a bare one, and its scaling."""
    return _weight(*lcp.rows, lcp.q, scale.D, scale.theta, *own_measures(problem))


def own_measures(problem: FrictionProblem | LCP) -> tuple[Array, Array]:
    """s and the units (nc,) of a friction problem's contacts, or empty arrays for a bare LCP."""
    return (problem.scale, problem.units) if isinstance(problem, FrictionProblem) else (_NOTHING, _NOTHING)


_NOTHING = np.zeros(0)


@kernel
def scaled_and_weighed(start, column, value, q, own, units):  # type: ignore[no-untyped-def]
    """D and theta of an LCP (solvers.pivots.scaling) and g; own, units: see own_measures."""
    D, theta = diagonal_scaling(start, column, value, q)
    return D, theta, _weight(start, column, value, q, D, theta, own, units)


@kernel
def _weight(start, column, value, q, D, theta, own, units):  # type: ignore[no-untyped-def]
    n, nc = len(q), len(own)
    weight, m, size, fastest = np.zeros(n), 0.0, 0.0, 0.0
    for i in range(nc):
        fastest = max(fastest, units[i])
    for i in range(n):
        for k in range(start[i], start[i + 1]):
            if column[k] == i:
                weight[i] = abs(value[k])
        if weight[i] == 0:
            weight[i] = 1.0
            for k in range(start[i], start[i + 1]):
                m = max(m, abs(D[i] * value[k] * D[column[k]]))
        if i < n - nc and nc:
            weight[i] = max(weight[i], own[contact_of(i, n, nc)])
        size = max(size, abs(q[i]))
    if fastest > 0:
        size = min(size, fastest)
    for i in range(n):
        share = units[contact_of(i, n, nc)] / fastest if fastest > 0 else 1.0
        weight[i] = (1 + m) * theta * D[i] * weight[i] / (share * size if size > 0 else 1.0)
    return weight


def exact_residual(problem: FrictionProblem | LCP, lcp: LCP, z: Array, impulse: Array) -> float:
    """The residual that `tol` refers to: the friction problem's own in the plane, its polygon's in space, a bare LCP's own."""
    if isinstance(problem, LCP):
        return lcp.residual(z)
    return residual(problem, impulse) if problem.dimension == 2 else polygon_residual(problem, lcp, z)


@part
def natural_residual(weight, y, w):  # type: ignore[no-untyped-def]
    """max_i g_i |min(y_i, w_i)|, infinity if an entry is NaN; weight, y, w: (n,)."""
    worst = 0.0
    for i in range(len(y)):
        defect = weight[i] * abs(min(y[i], w[i]))
        if not defect <= worst:
            worst = defect
            if np.isnan(defect):
                return np.inf
    return worst
