"""A solver's history on one problem: the residual of its answer when it is stopped after 1 unit of its work, 2, 3, 5 ...

The work limit is the solver's own: sweeps, iterations or pivots. Every answer comes from a fresh call on a copy, and is
verified on the problem that the solver never held, like any other; no call is timed. So the curve is what a user gets who
stops there, not what a method believes of itself.
"""

from time import perf_counter

import numpy as np

from frictionbench.harness.cells.answers import plain
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate
from frictionbench.problems.residual import residual
from frictionbench.solvers import Solver, Status

BUDGET = 2.0  # seconds, after which no longer limit is begun
LONGEST = 20_000  # units of work


def convergence_history(problem: FrictionProblem, solver: Solver, tol: float) -> tuple[list[int], list[float], Array]:
    """The limits, the verified residuals, and the last answer's impulses (nc, d), until the solver says that it is done.

    Errors: AnswerError, and whatever the solver raises.
    """
    begun, units, residuals = perf_counter(), [], []
    impulse = np.zeros((problem.contacts, problem.dimension))
    for limit in _limits():
        answer = plain(solver.solve(solver.prepare(duplicate(problem)), tol, limit))
        if answer.impulse.shape == impulse.shape and np.isfinite(answer.impulse).all():
            impulse = answer.impulse
            units.append(limit)
            residuals.append(residual(problem, impulse))
        if answer.status is Status.SOLVED or perf_counter() - begun > BUDGET:
            break
    return units, residuals, impulse


def _limits() -> list[int]:
    """1, 2, 3, 5, 8 ...: each half as large again as the last."""
    limits = [1]
    while limits[-1] < LONGEST:
        limits.append(max(limits[-1] + 1, round(1.5 * limits[-1])))
    return limits
