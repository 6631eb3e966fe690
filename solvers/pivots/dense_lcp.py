"""What Newton methods on a whole LCP share: its scaled dense form going in, an honest answer coming out."""

from typing import NamedTuple

import numpy as np
from numba import njit

from problems import LCP, FrictionProblem
from problems.check import Array
from solvers.interface import Answer, Status
from solvers.pivots.natural import exact_residual, natural_weight
from solvers.pivots.scaling import Scaling, scaling


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


def answer(
    form: DenseLCP, y: Array, tol: float, status: Status, work: dict[str, int], history: Array, detail: str = ""
) -> Answer:
    """The answer at y; a method that gave up has nevertheless solved the problem if its exact residual is within tol."""
    z = form.scale.solution(np.maximum(y, 0.0))
    impulse = form.lcp.impulse(z)
    if status is not Status.SOLVED and exact_residual(form.problem, form.lcp, z, impulse) <= tol:
        status = Status.SOLVED
    return Answer(impulse, status, work, tuple(history.tolist()), z, "" if status is Status.SOLVED else detail)


@njit(cache=True)
def solve_dense(A, b):  # type: ignore[no-untyped-def]
    """x (n,) with A x = b by LU with partial pivoting; NaN where A is singular."""
    try:
        x = np.linalg.solve(A, b)
    except Exception:  # numba knows no narrower one
        x = np.full(len(b), np.nan)
    return x
