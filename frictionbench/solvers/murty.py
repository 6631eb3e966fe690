"""Murty's least-index method for the LCP: principal pivots, one pair at a time.

    w = M z + q,   w, z >= 0,   w'z = 0.

In a complementary basis one variable of each pair w_i, z_i is basic and the other is 0. Its solution is complementary, and the
method looks for a nonnegative one. As long as a basic variable is negative, the pair with the least such index is exchanged.
If M is a P-matrix, every such pivot exists and no basis repeats, so that the method finds the solution for every q after at
most 2^n pivots (Murty 1974; Murty 1988, section 4.1). Otherwise there is no guarantee. The matrix of a friction LCP is not a
P-matrix, and above a certain mu not even a P0-matrix: the method may cycle until the work limit, or meet a zero pivot, where it
stalls.
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.clock import deadline, late
from frictionbench.solvers.interface import solver
from frictionbench.solvers.pivots.inverse_basis import Matrix
from frictionbench.solvers.pivots.lemke_path import (
    ACCURACY,
    COMPLEMENTARY,
    INACCURATE,
    LEAST_PIVOT,
    LIMIT,
    LOSS,
    STUCK,
    basic_values,
    entering_column,
    exchange,
    lemke_state,
    renew,
)
from frictionbench.solvers.pivots.principal_pivoting import PrincipalPivoting
from frictionbench.solvers.pivots.scaled_lcp import ScaledLCP, finish
from frictionbench.solvers.pivots.vectors import put

NEGATIVE = 1e-13  # basic variables above minus this share of the largest are rounding, and count as zero


@kernel
def murty(M: Matrix, q: Array, unit: Array, tol: float, limit: int, until: float) -> tuple[int, Array, int, int]:
    """(how it ended, y, pivots, inversions) for the scaled problem."""
    n, state, fresh = len(q), lemke_state(M, len(q)), True
    basis, x, a, y, work = state.basis, state.x, state.a, state.y, state.work
    put(state.q, q)
    put(x[:n], q)
    while True:
        size = 0.0
        for i in range(n):
            size = max(size, abs(x[i]))
        r = 0
        while r < n and x[r] >= -NEGATIVE * size:
            r += 1
        if r == n:
            break
        if work[0] >= limit or late(until):
            return LIMIT, y, work[0], work[1]
        z_enters = basis.row[r] < 0
        defect, size = entering_column(state, r, z_enters, ACCURACY)
        if not fresh and (defect > LOSS or not abs(a[r]) > LEAST_PIVOT * size):
            if not renew(state, ACCURACY):
                return INACCURATE, y, work[0], work[1]
            fresh = True
            continue
        if not abs(a[r]) > LEAST_PIVOT * size:
            return STUCK, y, work[0], work[1]
        exchange(state, r, z_enters, r, x[r] / a[r])
        if work[0] % 64 == 0:
            basic_values(basis, q, x, ACCURACY)
        fresh = False
    ended = COMPLEMENTARY if finish(state, q, unit) <= tol else INACCURATE
    return ended, y, work[0], work[1]


@solver("murty", family="pivoting", model="lcp", dimension=(2, 3))
class Murty(PrincipalPivoting):
    """Murty's least-index principal pivoting; guaranteed for P-matrices only. (Murty 1974)

    facets: of the polygon that approximates the cone's section in space. limit bounds the pivots, by default 10 000 + 100 n.
    """

    def pivot(self, lcp: ScaledLCP, tol: float, limit: int) -> tuple[int, Array, int, int]:
        return murty(lcp.M, lcp.q, lcp.unit, tol, limit, deadline())
