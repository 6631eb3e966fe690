"""What Newton methods on a whole LCP share: its scaled dense form, when an iteration ends, and an honest answer."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.natural import MARGIN, exact_residual, natural_residual, natural_weight
from frictionbench.solvers.pivots.scaling import Scaling, scaling

STATUS = (Status.SOLVED, Status.STALLED, Status.WORK_LIMIT, Status.BREAKDOWN)
SOLVED, STALLED, LIMIT, BREAKDOWN = range(4)  # how an iteration ends
GOING = -1
UNITS = ("newton", "gradient", "evaluations", "factorisations")
NEWTON, GRADIENT, EVALUATIONS, FACTORISATIONS = range(4)  # counted in work: steps, of the merit, of dense matrices


class DenseLCP(NamedTuple):
    """M (n, n) and q (n,), scaled to unit diagonal and unit q, and the weight (n,) of the natural residual."""

    problem: FrictionProblem | LCP
    lcp: LCP
    scale: Scaling
    M: Array
    q: Array
    weight: Array


def dense_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> DenseLCP:
    """The scaled dense form of a friction problem's LCP, in space with so many facets, or of a bare one."""
    lcp = problem if isinstance(problem, LCP) else problem.lcp(facets)
    scale = scaling(lcp)
    return DenseLCP(problem, lcp, scale, scale.matrix(lcp.dense), scale.vector(lcp.q), natural_weight(problem, lcp, scale))


class Descent(NamedTuple):
    """A Newton iteration with a line search: what is asked of it, and how it fares.

    weight (n,), tol: of the natural residual. limit: of the iterations. best (n,), least (1,): the point of the least residual
    and that. history: the residual of every iterate. recent: the last merits, for a nonmonotone search. work: counted by UNITS.
    """

    weight: Array
    tol: float
    limit: int
    best: Array
    least: Array
    history: Array
    recent: Array
    work: NDArray[np.int64]


def new_descent(weight: Array, tol: float, limit: int, memory: int) -> Descent:
    n = len(weight)
    history, work = np.empty(limit + 1), np.zeros(len(UNITS), np.int64)
    return Descent(weight, tol, limit, np.zeros(n), np.full(1, np.inf), history, np.zeros(memory), work)


@part
def judge(descent, k, y, w, merit):  # type: ignore[no-untyped-def]
    """Take down the k-th iterate y, w = M y + q and its merit; GOING, or how the method ended."""
    descent.history[k] = natural_residual(descent.weight, y, w)
    if descent.history[k] < descent.least[0]:
        descent.least[0] = descent.history[k]
        descent.best[:] = y
    descent.recent[k % len(descent.recent)] = merit
    if descent.least[0] <= descent.tol:
        return SOLVED
    if k == descent.limit:
        return LIMIT
    return GOING if merit < np.inf else BREAKDOWN


def solve_by(iterate: Any, form: DenseLCP, tol: float, limit: int | None, memory: int, *settings: Any) -> tuple[Answer, Any]:
    """The answer of an iteration from 0 within limit iterations, by default 200, and what it says beside how it ended.

    A method that gave up has nevertheless solved the problem if its exact residual is within tol.
    """
    descent = new_descent(form.weight, MARGIN * tol, 200 if limit is None else limit, memory)
    end, iterations, remark = iterate(form.M, form.q, np.zeros(len(form.q)), descent, *settings)
    z = form.scale.solution(np.maximum(descent.best, 0.0))
    impulse = form.lcp.impulse(z)
    if end != SOLVED and exact_residual(form.problem, form.lcp, z, impulse) <= tol:
        end = SOLVED
    work = dict(zip(UNITS, descent.work.tolist(), strict=True))
    return Answer(impulse, STATUS[end], work, tuple(descent.history[: iterations + 1].tolist()), z), remark


@kernel
def solve_dense(A, b):  # type: ignore[no-untyped-def]
    """x (n,) with A x = b by LU with partial pivoting; NaN where A is singular."""
    try:
        x = np.linalg.solve(A, b)
    except Exception:  # numba knows no narrower one
        x = np.full(len(b), np.nan)
    return x
