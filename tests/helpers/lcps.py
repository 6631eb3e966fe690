"""An LCP family of the literature, and what a solved friction problem is asked for."""

import numpy as np

from frictionbench.problems.residual import residual
from frictionbench.solvers.interface import Status, solve


def murty_family(n):
    """Murty 1988, chapter 6: a P-matrix on which Lemke's method with d = 1 takes 2^n pivots to z = 2^n e_1."""
    return 2 * np.tril(np.ones((n, n)), -1) + np.eye(n), -np.cumsum(2.0 ** np.arange(n, 0, -1)), 2.0**n * np.eye(n)[0]


def assert_solved(problem, spec, tol=1e-8, **how):
    answer = solve(problem, spec, **how)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)  # of extreme masses and near jams
    assert residual(problem, answer.impulse) <= tol
    return answer
