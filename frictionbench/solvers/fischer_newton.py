"""Semismooth Newton on the Fischer-Burmeister equation, globalised by a line search.

z solves the LCP w = M z + q exactly when Phi(z) = 0, where

    Phi_i = phi(z_i, w_i),      phi(a, b) = sqrt(a² + b²) - a - b,

and unlike Phi its merit Psi = |Phi|²/2 is continuously differentiable, with gradient H'Phi for any H in the generalised
Jacobian, rows H_i = (a/s - 1) e_i' + (b/s - 1) M_i, (a, b) = (z_i, w_i), s = |(a, b)|. An iteration (De Luca, Facchinei
and Kanzow 1996)

1. solves H d = -Phi, or takes d = -H'Phi if H is singular or d is not a descent direction;
2. halves the step t from 1 until Psi(z + t d) <= the largest of recent Psi + sigma t d'H'Phi (nonmonotone: Grippo,
   Lampariello and Lucidi 1986).

Redundant supports make M, and with it H, singular at the solution. The H of step 1 is therefore that of M + eps I; Phi, Psi
and the gradient stay exact, so that only the rate changes: linear with a factor of about eps |H^-1| in place of quadratic.

Every limit is a stationary point of Psi, H'Phi = 0, and a solution if M is P0. The friction LCP
of one contact with W = [[a, b], [b, g]] is P0 only for a >= mu |b|. Otherwise, and often with several contacts, the
iteration may end in a minimum of Psi that is not a solution.

Reference: De Luca, Facchinei and Kanzow, A semismooth equation approach to the solution of nonlinear complementarity
problems, Mathematical Programming 75 (1996).
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

ARMIJO = 1e-4  # sigma, the required share of the predicted decrease: the usual Armijo constant
DESCENT = 1e-8  # required -d'H'Phi, relative to |d|^2.1, of a direction of descent (De Luca, Facchinei and Kanzow 1996)
MEMORY = 8  # merits that the nonmonotone search compares with: 5 to 10 is usual (Grippo et al. 1986)
SHORTEST = 1e-10  # step at which the search gives up: rounding of the merit hides smaller decreases
STATIONARY = 1e-12  # |H'Phi| relative to |Phi| below which the gradient is rounding


@solver("fischer_newton", family="newton", model="lcp", dimension=(2, 3))
class FischerNewton(MeritNewton):
    """Fischer-Burmeister Newton (De Luca, Facchinei and Kanzow): semismooth, line search on the merit, gradient fallback.

    regularisation: eps, on the scaled M in the Newton system. facets: of the polygon that approximates the cone's section.
    limit bounds the iterations, by default 200.
    work: newton and gradient steps, evaluations of the merit, factorisations. history: the residual, per iteration.
    """

    regularisation: float = 1e-5
    memory = MEMORY

    def iterate(self, dense: DenseLCP, descent: Descent) -> tuple[int, int, int]:
        end, iterations = iterate_fischer(dense.M, dense.q, np.zeros(len(dense.q)), descent, float(self.regularisation))
        return end, iterations, 0

    def describe_end(self, status: Status, period: int) -> str:
        return "no descent: a stationary point of the merit that is not a solution" if status is Status.STALLED else ""


@part
def fischer(y, w):  # type: ignore[no-untyped-def]
    """Phi (n,), without cancellation where a + b > 0."""
    value = np.empty(len(y))
    for i in range(len(y)):
        a, b = y[i], w[i]
        s = np.hypot(a, b)
        value[i] = -2 * a * b / (s + a + b) if a + b > 0 else s - a - b
    return value


@kernel
def jacobian(M, y, w):  # type: ignore[no-untyped-def]
    """The diagonals A, B (n,) of an element H = A + B M of the generalised Jacobian.

    At a kink, y_i = w_i = 0, it is the limit of H along y + t e, t -> 0, with e_i = 1 at the kinks and 0 elsewhere.
    """
    n = len(y)
    A, B, e = np.empty(n), np.empty(n), np.zeros(n)
    for i in range(n):
        if y[i] == 0.0 and w[i] == 0.0:
            e[i] = 1.0
    slope = M @ e
    for i in range(n):
        a, b = (1.0, slope[i]) if e[i] == 1.0 else (y[i], w[i])
        s = np.hypot(a, b)
        A[i], B[i] = a / s - 1.0, b / s - 1.0
    return A, B


@kernel
def iterate_fischer(M, q, y, descent, eps):  # type: ignore[no-untyped-def]
    """From y: how it ended and the iterations."""
    n, work = len(q), descent.work
    w = M @ y + q
    phi = fischer(y, w)
    work[EVALUATIONS] += 1
    k = 0
    while True:
        end = record(descent, k, y, w, phi @ phi / 2, n)
        if end != GOING:
            return end, k
        A, B = jacobian(M, y, w)
        gradient = A * phi + (B * phi) @ M
        if np.sqrt(gradient @ gradient) <= STATIONARY * np.sqrt(phi @ phi):
            return STALLED, k
        H = M * B.reshape(n, 1)
        for i in range(n):
            H[i, i] += A[i] + eps * B[i]
        kind, d = NEWTON, solve_dense(H, -phi)
        work[FACTORISATIONS] += 1
        if not gradient @ d <= -DESCENT * np.sqrt(d @ d) ** 2.1:
            kind, d = GRADIENT, -gradient
        worst, slope, t = descent.recent.max(), gradient @ d, 1.0
        while True:
            if late(descent.until):
                return TIME, k
            trial = y + t * d
            w = M @ trial + q
            phi = fischer(trial, w)
            work[EVALUATIONS] += 1
            if phi @ phi / 2 <= worst + ARMIJO * t * slope or t < SHORTEST:
                break
            t /= 2
        if t < SHORTEST:
            return STALLED, k
        y = trial
        work[kind] += 1
        k += 1
