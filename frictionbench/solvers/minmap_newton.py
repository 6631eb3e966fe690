"""Newton on the min-map: primal-dual active sets, globalised by a line search that avoids cycles.

z solves the LCP w = M z + q exactly when min(z, w) = 0. With the active set A = {i: w_i < z_i}, Newton's step solves

    w_A + M_A d = 0,      z_I + d_I = 0,

so that a full step lands on z_I = 0, M_AA z_A = -q_A: one linear system of the size of A, and a finite method if it converges
(Aganagic 1984; Bergounioux, Ito and Kunisch 1999). Full steps alone converge for M-matrices and near a regular solution.
Already for P-matrices they can cycle: for [[1, 0, a], [a, 1, 0], [0, a, 1]] and q = 1 with a > 1 through the active sets
{1}, {2}, {3} (Ben Gharbia and Gilbert 2012). A full step depends on A alone, so a set that recurs after other ones proves
a cycle; the plain method stops there.

Globalised, the step t is halved from 1 until psi(z + t d) <= (1 - 2 sigma t) of the largest of recent psi = |min(z, w)|²/2
(Pang 1990 with a nonmonotone search); where the system is singular or the search fails, along -H'min(z, w) instead, H the
active rows e_i' or M_i. psi is not differentiable where z_i = w_i, and the search may end in such a kink: there is no stronger
guarantee, and the answer's detail says so. On redundant supports M_AA is singular: as in Fischer-Burmeister Newton, the system
is that of M + eps I, psi is exact.

References: Pang, Newton's method for B-differentiable equations, Mathematics of Operations Research 15 (1990); Ben Gharbia
and Gilbert, Nonconvergence of the plain Newton-min algorithm for linear complementarity problems with a P-matrix,
Mathematical Programming 134 (2012).
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.clock import late
from frictionbench.solvers.interface import Status, solver
from frictionbench.solvers.pivots.dense_lcp import DenseLCP
from frictionbench.solvers.pivots.merit_newton import (
    EVALUATIONS,
    FACTORISATIONS,
    GOING,
    GRADIENT,
    NEWTON,
    STALLED,
    TIME,
    Descent,
    MeritNewton,
    record,
    solve_dense,
)

DECREASE = 1e-4  # sigma, the usual Armijo constant
MEMORY = 15  # merits that the nonmonotone search compares with: more than usual, as the min-map has kinks to cross
SHORTEST = 1e-8  # step at which a search gives up and the gradient is tried


@solver("minmap_newton", family="newton", model="lcp", dimension=(2, 3))
class MinmapNewton(MeritNewton):
    """Min-map Newton (primal-dual active sets): full steps, line search on the merit, cycles detected.

    globalised: false for full steps only. regularisation: eps, on the scaled M in the Newton system. facets: of the polygon
    that approximates the cone's section. limit bounds the iterations, by default 200. work: newton and gradient steps,
    evaluations of the merit, factorisations.
    history: the residual, per iteration.
    """

    regularisation: float = 1e-4
    globalised: bool = True
    memory = MEMORY

    def iterate(self, dense: DenseLCP, descent: Descent) -> tuple[int, int, int]:
        settings = float(self.regularisation), self.globalised
        end, iterations, period = iterate_minmap(dense.M, dense.q, np.zeros(len(dense.q)), descent, *settings)
        return end, iterations, period

    def describe_end(self, status: Status, period: int) -> str:
        if status is Status.SOLVED:
            return ""
        kink = ["no descent: a kink or stationary point of the merit"] * (self.globalised and status is Status.STALLED)
        return "; ".join(kink + [f"active sets came back after {period} iterations"] * (period > 0))


@part
def newton_direction(M, y, w, eps):  # type: ignore[no-untyped-def]
    """d (n,) of the active set A = {w < y}, NaN where M_AA + eps is singular."""
    A, rest = np.flatnonzero(w < y), np.flatnonzero(w >= y)
    d = -y
    system, right = np.empty((len(A), len(A))), np.empty(len(A))
    for k, i in enumerate(A):
        right[k] = -w[i]
        for j in rest:
            right[k] += M[i, j] * y[j]
        for m, j in enumerate(A):
            system[k, m] = M[i, j]
        system[k, k] += eps
    d[A] = solve_dense(system, right)
    return d


@part
def signature(A):  # type: ignore[no-untyped-def]
    """A 64-bit hash of a set (n, bool)."""
    h = np.int64(1)
    for member in A:
        h = h * np.int64(6364136223846793005) + np.int64(member)  # wraps around
    return h


@kernel
def iterate_minmap(M, q, y, descent, eps, globalised):  # type: ignore[no-untyped-def]
    """From y: how it ended, the iterations, and the period of the first cycle seen, or 0."""
    work, visited = descent.work, np.empty(len(descent.history), np.int64)
    w = M @ y + q
    k = period = 0
    while True:
        value, A = np.minimum(y, w), w < y
        end = record(descent, k, y, w, value @ value / 2, A.sum())
        if end != GOING:
            return end, k, period
        visited[k] = signature(A)
        for back in range(k - 2, -1, -1):
            if not period and visited[back] == visited[k] != visited[k - 1]:
                period = k - back
        if period and not globalised:
            return STALLED, k, period
        kind, t = NEWTON, 1.0
        d = newton_direction(M, y, w, eps)
        work[FACTORISATIONS] += 1
        if globalised:
            worst = descent.recent.max()
            while kind <= GRADIENT:
                t = 1.0
                while t >= SHORTEST:
                    if late(descent.until):
                        return TIME, k, period
                    trial = np.minimum(y + t * d, M @ (y + t * d) + q)
                    work[EVALUATIONS] += 1
                    if trial @ trial / 2 <= (1.0 - 2.0 * DECREASE * t) * worst:
                        break
                    t /= 2
                if t >= SHORTEST:
                    break
                kind += 1
                d = -np.where(A, 0.0, value) - np.where(A, value, 0.0) @ M
            if t < SHORTEST:
                return STALLED, k, period
        y = y + t * d
        w = M @ y + q
        work[kind] += 1
        k += 1
