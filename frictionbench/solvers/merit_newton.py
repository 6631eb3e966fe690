"""Newton's methods for a dense LCP written as equations Phi = 0, globalised by a line search on the merit Psi = |Phi|²/2.

z solves the LCP w = M z + q exactly when Phi(z) = 0, where, for each component,

    Phi = sqrt(z² + w²) - z - w,     Fischer and Burmeister's function (fischer_newton), or
    Phi = min(z, w),                 the min-map (minmap_newton).

For both functions an element of the generalised Jacobian is H = A + B M with diagonal A and B, and H'Phi is the gradient of
Psi. An iteration halves the step length t along the direction d from 1 until

    Psi(z + t d) <= the largest of recent Psi - sigma t drop        (nonmonotone: Grippo, Lampariello and Lucidi 1986).

Fischer-Burmeister: A = z/s - 1 and B = w/s - 1 with s = |(z, w)|; Psi is continuously differentiable. d solves H d = -Phi, or
is -H'Phi if H is singular or d is not a descent direction; drop = -d'H'Phi (De Luca, Facchinei and Kanzow 1996). Every limit is
a stationary point of Psi, H'Phi = 0, and a solution if M is P0. The friction LCP of one contact with W = [[a, b], [b, g]] is P0
only for a >= mu |b|. Otherwise, and often with several contacts, the iteration may end in a minimum of Psi that is no solution.

Min-map, or primal-dual active set method: with the active set A = {i: w_i < z_i} and its complement I, d solves w_A + M_A d =
0, z_I + d_I = 0, so that a full step leads to z_I = 0, M_AA z_A = -q_A. This is one linear system of the size of A, and a
finite method if it converges (Aganagic 1984; Bergounioux, Ito and Kunisch 1999). Full steps alone can cycle even for P-matrices
(Ben Gharbia and Gilbert 2012). drop = 2 Psi (Pang 1990); if the system is singular or the search fails, -H'Phi is tried. Psi is
not differentiable where z_i = w_i, and the search may end in such a kink: there is no stronger guarantee.

Redundant supports make M, and with it H, singular at the solution. Newton's systems therefore use M + eps I. Phi, Psi and the
gradient stay exact, so that only the rate changes, from quadratic to linear with a factor of about eps |H^-1|.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.residual import TOL_SHARE
from frictionbench.solvers.clock import SPEED, deadline, late
from frictionbench.solvers.interface import Answer, Status, solver
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp
from frictionbench.solvers.pivots.scaled_lcp import measured

STATUS = (Status.SOLVED, Status.STALLED, Status.WORK_LIMIT, Status.BREAKDOWN, Status.TIME_LIMIT)
SOLVED, STALLED, LIMIT, BREAKDOWN, TIME = range(5)  # how an iteration ends
GOING = -1  # the iteration has not ended
UNITS = ("newton", "gradient", "evaluations", "factorisations")
NEWTON, GRADIENT, EVALUATIONS, FACTORISATIONS = range(4)  # work: Newton and gradient steps, merits, dense factorisations
ARMIJO = 1e-4  # sigma, the required share of the predicted decrease: the usual Armijo constant
DESCENT = 1e-8  # a descent direction needs -d'H'Phi of at least this times |d|^2.1 (De Luca, Facchinei and Kanzow 1996)
STATIONARY = 1e-12  # |H'Phi| relative to |Phi| below which the gradient is rounding


class Descent(NamedTuple):
    """A Newton iteration with a line search: its criteria, and the record of its iterates.

    unit (2, n), tol: of the residual (ScaledLCP). limit: of the iterations. shortest: step length at which a search gives up.
    best (n,), least (1,): the iterate with the least residual, and this residual. history: the residual of every iterate.
    recent: the last merits, for the nonmonotone search. work: the counts named in UNITS. until: the deadline. slowness: seconds
    for each operation of a factorisation.
    """

    unit: Array
    tol: float
    limit: int
    shortest: float
    best: Array
    least: Array
    history: Array
    recent: Array
    work: NDArray[np.int64]
    until: float
    slowness: float


def new_descent(unit: Array, tol: float, limit: int, memory: int, shortest: float) -> Descent:
    best, least, history, recent = np.zeros(unit.shape[1]), np.full(1, np.inf), np.empty(limit + 1), np.zeros(memory)
    work = np.zeros(len(UNITS), np.int64)
    return Descent(unit, tol, limit, shortest, best, least, history, recent, work, deadline(), 1 / SPEED)


@dataclass(frozen=True)
class MeritNewton:
    """A Newton method on a merit function, from z = 0; subclasses set the default of `regularisation`.

    regularisation: eps, added to the diagonal of the scaled M in the Newton system, as redundant supports make M singular.
    facets: of the polygon that approximates the circular section of the cone in space.
    """

    regularisation: float
    facets: int = 8

    dense_matrices = 3  # M, the Jacobian and its factors
    smooth = True  # Fischer and Burmeister's function, otherwise the min-map
    memory = 8  # merits that the nonmonotone search compares with: 5 to 10 is usual (Grippo et al. 1986)
    shortest = 1e-10  # step length at which a search gives up: rounding of the merit hides smaller decreases
    end = "no descent: a stationary point of the merit that is not a solution"

    def __post_init__(self) -> None:
        require(self.regularisation >= 0, "regularisation", f"must not be negative, got {self.regularisation!r}")
        tangent_basis(3, self.facets)  # refuses a wrong number

    def form(self, problem: FrictionProblem | LCP) -> DenseLCP:
        return dense_lcp(problem, self.facets)

    def solve(self, dense: DenseLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the iterations, 200 by default.

        The status is SOLVED if and only if the exact residual of the best iterate is within tol.
        """
        problem = dense.scaled.problem
        descent = new_descent(dense.scaled.unit, TOL_SHARE * tol, 200 if limit is None else limit, self.memory, self.shortest)
        end, iterations = iterate(dense.M, dense.q, np.zeros(len(dense.q)), descent, float(self.regularisation), self.smooth)
        y = np.maximum(descent.best, 0.0)
        if isinstance(problem, FrictionProblem):  # normal impulses that act on nothing, as those of dry friction in joints
            y[: problem.contacts][(dense.M.diagonal()[: problem.contacts] == 0) & (problem.friction == 0)] = 0.0
        if dense.scaled.residual(y) <= tol:
            end = SOLVED
        elif end == SOLVED:
            end = STALLED
        work = dict(zip(UNITS, descent.work.tolist(), strict=True))
        answer = dense.scaled.answer(y, STATUS[end], self.end if end == STALLED else "", **work)
        return replace(answer, history=tuple(descent.history[: iterations + 1].tolist()))


@solver("fischer_newton", family="newton", model="lcp", dimension=(2, 3))
class FischerNewton(MeritNewton):
    """Fischer-Burmeister Newton (De Luca, Facchinei and Kanzow): semismooth, line search on the merit, gradient fallback.

    regularisation: eps, on the scaled M in the Newton system. facets: of the polygon that approximates the cone's section.
    limit bounds the iterations, by default 200.
    work: newton and gradient steps, evaluations of the merit, factorisations. history: the residual, per iteration.
    """

    regularisation: float = 1e-5


@solver("minmap_newton", family="newton", model="lcp", dimension=(2, 3))
class MinmapNewton(MeritNewton):
    """Min-map Newton (primal-dual active sets): full steps, line search on the merit, gradient fallback.

    regularisation, facets, limit, work and history: as for fischer_newton.
    """

    regularisation: float = 1e-4
    smooth = False
    memory = 15  # more than usual, as the min-map has kinks to cross
    shortest = 1e-8
    end = "no descent: a kink or stationary point of the merit"


@kernel
def iterate(M, q, y, descent, eps, smooth):  # type: ignore[no-untyped-def]
    """Iterate from y; return how it ended and the number of iterations. smooth: Fischer-Burmeister, otherwise the min-map."""
    work, k = descent.work, 0
    w = M @ y + q
    phi = equations(y, w, smooth)
    work[EVALUATIONS] += smooth
    while True:
        end = _record(descent, k, M, q, y, w, phi @ phi / 2, len(q) if smooth else (w < y).sum())
        if end != GOING:
            return end, k
        A, B = jacobian(y, w, smooth)
        gradient = A * phi + (B * phi) @ M
        if smooth and np.sqrt(gradient @ gradient) <= STATIONARY * np.sqrt(phi @ phi):
            return STALLED, k
        kind, d = NEWTON, _newton_direction(M, y, w, phi, A, B, eps, smooth)
        work[FACTORISATIONS] += 1
        if smooth and not gradient @ d <= -DESCENT * np.sqrt(d @ d) ** 2.1:
            kind, d = GRADIENT, -gradient
        t, ahead, w_ahead, phi = _search(M, q, y, d, gradient @ d, descent, smooth)
        if t == 0 and not smooth:
            kind = GRADIENT
            t, ahead, w_ahead, phi = _search(M, q, y, -gradient, 0.0, descent, smooth)
        if t <= 0:
            return STALLED if t == 0 else TIME, k
        y, w = ahead, w_ahead
        work[kind] += 1
        k += 1


@part
def _record(descent, k, M, q, y, w, merit, size):  # type: ignore[no-untyped-def]
    """Record the k-th iterate; GOING, or how the method ended. size: number of unknowns of the next linear system."""
    descent.history[k] = measured(descent.unit, y, w)
    if descent.history[k] <= descent.tol:  # without its negative unknowns, whose effect on others may exceed the tolerance
        positive = np.maximum(y, 0.0)
        descent.history[k] = measured(descent.unit, positive, M @ positive + q)
    if descent.history[k] < descent.least[0]:
        descent.least[0] = descent.history[k]
        descent.best[:] = y
    descent.recent[k % len(descent.recent)] = merit
    if descent.least[0] <= descent.tol:
        return SOLVED
    if k == descent.limit:
        return LIMIT
    if late(descent.until - 2 / 3 * float(size) ** 3 * descent.slowness):
        return TIME
    return GOING if merit < np.inf else BREAKDOWN


@part
def _search(M, q, y, d, slope, descent, smooth):  # type: ignore[no-untyped-def]
    """(t, y + t d, w and Phi there) for a sufficient decrease; t = 0 if there is none, -1 after the deadline."""
    worst, t = descent.recent.max(), 1.0
    drop = -slope if smooth else 2 * worst
    while True:
        ahead = y + t * d
        w = M @ ahead + q
        phi = equations(ahead, w, smooth)
        descent.work[EVALUATIONS] += 1
        if phi @ phi / 2 <= worst - ARMIJO * t * drop:
            return t, ahead, w, phi
        t /= 2
        if t < descent.shortest or late(descent.until):
            return 0.0 if t < descent.shortest else -1.0, ahead, w, phi


@kernel
def equations(y, w, smooth):  # type: ignore[no-untyped-def]
    """Phi (n,). Fischer and Burmeister's function is computed without cancellation where a + b > 0."""
    value = np.empty(len(y))
    for i in range(len(y)):
        a, b = y[i], w[i]
        if smooth:
            s = np.hypot(a, b)
            value[i] = -2 * a * b / (s + a + b) if a + b > 0 else s - a - b
        else:
            value[i] = min(a, b)
    return value


@kernel
def jacobian(y, w, smooth):  # type: ignore[no-untyped-def]
    """The diagonals A, B (n,) of an element H = A + B M of the generalised Jacobian.

    At the kink of Fischer and Burmeister's function, y_i = w_i = 0, it is the limit for y_i = w_i -> 0 from above.
    """
    if not smooth:
        return np.where(w < y, 0.0, 1.0), np.where(w < y, 1.0, 0.0)
    n = len(y)
    A, B = np.empty(n), np.empty(n)
    for i in range(n):
        a, b = (y[i], w[i]) if y[i] != 0.0 or w[i] != 0.0 else (1.0, 1.0)
        s = np.hypot(a, b)
        A[i], B[i] = a / s - 1.0, b / s - 1.0
    return A, B


@part
def _newton_direction(M, y, w, phi, A, B, eps, smooth):  # type: ignore[no-untyped-def]
    """d (n,), NaN where the system is singular. For the min-map only the system of the active set is solved."""
    if smooth:
        H = M * B.reshape(len(y), 1)
        for k in range(len(y)):
            H[k, k] += A[k] + eps * B[k]
        return solve_dense(H, -phi)
    active, rest = np.flatnonzero(w < y), np.flatnonzero(w >= y)
    d = -y
    system, right = np.empty((len(active), len(active))), np.empty(len(active))
    for k, i in enumerate(active):
        right[k] = -w[i]
        for j in rest:
            right[k] += M[i, j] * y[j]
        for m, j in enumerate(active):
            system[k, m] = M[i, j]
        system[k, k] += eps
    d[active] = solve_dense(system, right)
    return d


@part
def solve_dense(A, b):  # type: ignore[no-untyped-def]
    """x (n,) with A x = b by LU with partial pivoting; NaN where A is singular."""
    try:
        x = np.linalg.solve(A, b)
    except Exception:  # numba supports no narrower exception
        x = np.full(len(b), np.nan)
    return x
