"""The common part of Newton methods that reduce a merit function of a dense LCP by a line search.

Each method supplies its iteration. Shared are the scaled dense form, the record of the iterates with the criteria that end the
iteration, and the answer, whose status rests on the exact residual.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array, require
from frictionbench.problems.compiled import part
from frictionbench.solvers.clock import SPEED, deadline, is_past, late
from frictionbench.solvers.interface import Answer, Status, dense_storage
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp
from frictionbench.solvers.pivots.scaled_lcp import MARGIN, measured

STATUS = (Status.SOLVED, Status.STALLED, Status.WORK_LIMIT, Status.BREAKDOWN, Status.TIME_LIMIT)
SOLVED, STALLED, LIMIT, BREAKDOWN, TIME = range(5)  # how an iteration ends
GOING = -1  # the iteration has not ended
UNITS = ("newton", "gradient", "evaluations", "factorisations")
NEWTON, GRADIENT, EVALUATIONS, FACTORISATIONS = range(4)  # counted in work: steps, of the merit, of dense matrices


class Formed(NamedTuple):
    """The problem, and its scaled dense LCP, None if there is no time to form it."""

    problem: FrictionProblem | LCP
    dense: DenseLCP | None


class Descent(NamedTuple):
    """A Newton iteration with a line search: its criteria, and the record of its iterates.

    unit (2, n), tol: of the residual (ScaledLCP). limit: of the iterations. best (n,), least (1,): the point of the least
    residual and that. history: the residual of every iterate. recent: the last merits, for a nonmonotone search. work: counted
    by UNITS. until, slowness: the deadline, and the seconds that an operation of a factorisation takes.
    """

    unit: Array
    tol: float
    limit: int
    best: Array
    least: Array
    history: Array
    recent: Array
    work: NDArray[np.int64]
    until: float
    slowness: float


def new_descent(unit: Array, tol: float, limit: int, memory: int) -> Descent:
    n = unit.shape[1]
    history, work = np.empty(limit + 1), np.zeros(len(UNITS), np.int64)
    return Descent(unit, tol, limit, np.zeros(n), np.full(1, np.inf), history, np.zeros(memory), work, deadline(), 1 / SPEED)


@part
def record(descent, k, y, w, merit, size):  # type: ignore[no-untyped-def]
    """Record the k-th iterate y, w = M y + q and its merit; GOING, or how the method ended. size: of the next linear system."""
    descent.history[k] = measured(descent.unit, y, w)
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


@dataclass(frozen=True)
class MeritNewton(ABC):
    """A Newton method on a merit function, from z = 0; a method sets the default of `regularisation`.

    regularisation: eps, added to the diagonal of the scaled M in the Newton system, as redundant supports make M singular.
    facets: of the polygon that approximates the circular section of the cone in space.
    """

    regularisation: float
    facets: int = 8

    dense_matrices = 3  # M, the Jacobian and its factors
    memory = 1  # merits that a nonmonotone search compares with

    def __post_init__(self) -> None:
        require(self.regularisation >= 0, "regularisation", f"must not be negative, got {self.regularisation!r}")

    @abstractmethod
    def iterate(self, dense: DenseLCP, descent: Descent) -> tuple[int, int, int]:
        """(how it ended, iterations, period of the first cycle of active sets or 0)."""

    @abstractmethod
    def describe_end(self, status: Status, period: int) -> str:
        """The detail of the answer."""

    def form(self, problem: FrictionProblem | LCP) -> Formed:
        if is_past(deadline(written=dense_storage(self, problem))):
            return Formed(problem, None)
        return Formed(problem, dense_lcp(problem, self.facets))

    def solve(self, form: Formed, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the iterations, 200 by default.

        The status is SOLVED also where the method gave up and its best point's exact residual is within tol.
        """
        problem, dense = form
        if dense is None:
            return _nothing(problem)
        descent = new_descent(dense.scaled.unit, MARGIN * tol, 200 if limit is None else limit, self.memory)
        end, iterations, period = self.iterate(dense, descent)
        y = np.maximum(descent.best, 0.0)
        if isinstance(problem, FrictionProblem):  # a normal impulse that acts on nothing, as of a joint's dry friction
            y[: problem.contacts][(dense.M.diagonal()[: problem.contacts] == 0) & (problem.friction == 0)] = 0.0
        if end != SOLVED and dense.scaled.residual(y) <= tol:
            end = SOLVED
        work = dict(zip(UNITS, descent.work.tolist(), strict=True))
        answer = dense.scaled.answer(y, STATUS[end], self.describe_end(STATUS[end], period), **work)
        return replace(answer, history=tuple(descent.history[: iterations + 1].tolist()))


def _nothing(problem: FrictionProblem | LCP) -> Answer:
    """No impulses, as the time is over."""
    shape, z = ((0, 0), np.zeros(problem.size)) if isinstance(problem, LCP) else ((problem.contacts, problem.dimension), None)
    return Answer(np.zeros(shape), Status.TIME_LIMIT, dict.fromkeys(UNITS, 0), z=z)


@part
def solve_dense(A, b):  # type: ignore[no-untyped-def]
    """x (n,) with A x = b by LU with partial pivoting; NaN where A is singular."""
    try:
        x = np.linalg.solve(A, b)
    except Exception:  # numba knows no narrower one
        x = np.full(len(b), np.nan)
    return x
