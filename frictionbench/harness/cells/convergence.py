"""A solver's convergence history on one problem: the residual of its answer with work limits of 1, 2, 3, 5, ... units.

The unit is the solver's own: sweeps, iterations or pivots. Every answer comes from a new call on a copy of the problem, and its
residual is computed on the original; no call is timed. So the curve shows the answers that a user gets with these limits, and
not the residuals that the method computes internally.
"""

from time import perf_counter

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import checked_copy
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate
from frictionbench.problems.residual import residual
from frictionbench.solvers import Solver, Status

BUDGET = 2.0  # seconds, after which no larger limit is tried: a history shows what is reached soon
LONGEST = 20_000  # units of work: a bound for methods that stall, beyond the iterations of any that converges well


def convergence_history(problem: FrictionProblem, solver: Solver, tol: float) -> tuple[list[int], list[float], Array]:
    """The limits, the verified residuals, and the last answer's impulses (nc, d), up to the first answer with status SOLVED.

    Errors: AnswerError, and whatever the solver raises.
    """
    start_time, units, residuals = perf_counter(), [], []
    impulse = np.zeros((problem.contacts, problem.dimension))
    for limit in _limits():
        answer = checked_copy(solver.solve(solver.prepare(duplicate(problem)), tol, limit))
        if answer.impulse.shape == impulse.shape and np.isfinite(answer.impulse).all():
            impulse = answer.impulse
            units.append(limit)
            residuals.append(residual(problem, impulse))
        if answer.status is Status.SOLVED or perf_counter() - start_time > BUDGET:
            break
    return units, residuals, impulse


def _limits() -> list[int]:
    """1, 2, 3, 4, 6, 9, ...: each 1.5 times the one before."""
    limits = [1]
    while limits[-1] < LONGEST:
        limits.append(max(limits[-1] + 1, round(1.5 * limits[-1])))
    return limits
