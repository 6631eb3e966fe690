"""Murty's least-index method for the LCP: principal pivots, one pair at a time.

    w = M z + q,   w, z >= 0,   w'z = 0.

Every complementary basis (of each pair w_i, z_i one is basic, the nonbasic ones are 0) gives a complementary (w, z); the
method looks for a nonnegative one. As long as a basic variable is negative, the pair of the least such index is
exchanged. If M is a P-matrix every such pivot exists and no basis repeats, so that the method finds the solution, for every q,
after at most 2^n pivots (Murty 1974; Murty 1988, section 4.1). There is no guarantee otherwise. The matrix of a friction LCP is
not a P-matrix, and above a certain mu not a P0-matrix: the method may cycle, which ends at the work limit, or meet a pair
whose pivot vanishes, where it stalls.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.clock import deadline, late
from frictionbench.solvers.interface import solver
from frictionbench.solvers.pivots.inverse_basis import Matrix, exchange_pair, refactor, slack_basis, transform
from frictionbench.solvers.pivots.lemke_path import (
    ACCURACY,
    COMPLEMENTARY,
    INACCURATE,
    LIMIT,
    LOSS,
    PIVOT,
    STUCK,
    basic_values,
    enter,
)
from frictionbench.solvers.pivots.principal_pivoting import PrincipalPivoting
from frictionbench.solvers.pivots.scaled_lcp import ScaledLCP, finish

NEGATIVE = 1e-13  # relative to the largest basic variable: entries above minus this are rounding, and count as zero


@kernel
def murty(M: Matrix, q: Array, unit: Array, tol: float, limit: int, until: float) -> tuple[int, Array, int, int]:
    """(how it ended, y, pivots, inversions) for the scaled problem."""
    n = len(q)
    d, rhs, out, y = np.zeros(n), np.empty(n), np.empty(n), np.zeros(n)
    x, a = np.zeros(n + 1), np.empty(n + 1)
    x[:n] = q
    basis = slack_basis(n)
    pivots, inversions, fresh = 0, 0, True
    while True:
        least = -NEGATIVE * np.abs(x).max() if n else 0.0
        r = 0
        while r < n and x[r] >= least:
            r += 1
        if r == n:
            break
        if pivots >= limit or late(until):
            return LIMIT, y, pivots, inversions
        z_enters = basis.row[r] < 0
        enter(M, r, z_enters, rhs)
        defect, size = transform(M, d, basis, rhs, a, out, ACCURACY)
        if not fresh and (defect > LOSS or not abs(a[r]) > PIVOT * size):
            inversions += 1
            if not refactor(M, d, basis):
                return INACCURATE, y, pivots, inversions
            basic_values(M, d, basis, q, x, out, ACCURACY)
            fresh = True
            continue
        if not abs(a[r]) > PIVOT * size:
            return STUCK, y, pivots, inversions
        exchange_pair(M, d, basis, a, r, z_enters, r)
        pivots += 1
        t = x[r] / a[r]
        for i in range(n):
            x[i] -= t * a[i]
        x[r] = t
        if pivots % 64 == 0:
            basic_values(M, d, basis, q, x, out, ACCURACY)
        fresh = False
    if finish(M, d, basis, q, unit, x, y, out) <= tol:
        return COMPLEMENTARY, y, pivots, inversions
    return INACCURATE, y, pivots, inversions


@solver("murty", family="pivoting", model="lcp", dimension=(2, 3))
class Murty(PrincipalPivoting):
    """Murty's least-index principal pivoting; guaranteed for P-matrices only. (Murty 1974)

    facets: of the polygon that approximates the cone's section in space. The limit counts pivots, by default 10 000 + 100 n.
    """

    def pivot(self, lcp: ScaledLCP, tol: float, limit: int) -> tuple[int, Array, int, int]:
        return murty(lcp.M, lcp.q, lcp.unit, tol, limit, deadline())
