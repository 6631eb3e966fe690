"""What an answer is worth, found from the problem alone. Nothing that a solver says is believed; nothing else decides.

    solved      the residual of the exact problem is within the tolerance, whatever the solver says of itself
    relaxed     it is not, but the model that the solver was given is solved within the tolerance
    wrong       neither, and the solver claims to have solved it; or what came back is no answer at all
    unsolved    neither, and the solver says so

The exact problem's residual and the model's are measured apart: the first is model error and solver error together, the
second the solver's alone.
"""

from dataclasses import dataclass

import numpy as np

from problems import LCP, FrictionProblem
from problems.check import Array
from problems.residual import fclib_error, relaxation_residual, residual
from problems.simulate import ledger_defect
from results.schema import RELAXED, SOLVED, UNSOLVED, WRONG
from solvers import Answer, SolverInfo, Status


@dataclass(frozen=True)
class Finding:
    """The verdict and what it rests on; residuals as in problems.residual, energy_defect in joules."""

    verdict: str
    reason: str
    residual: float
    model_residual: float
    fclib_error: float
    energy_defect: float


def verify(problem: FrictionProblem, answer: Answer, info: SolverInfo, tol: float) -> Finding:
    """The finding on an answer to a friction problem."""
    claimed = answer.status is Status.SOLVED
    impulse = np.asarray(answer.impulse, dtype=float)
    if complaint := _complaint(problem, impulse):
        return Finding(WRONG if claimed else UNSOLVED, complaint, *(np.inf,) * 4)
    exact = residual(problem, impulse)
    model = _model_residual(problem, answer, info, exact)
    verdict = _verdict(exact, model, claimed, tol)
    reason = answer.detail or (answer.status.value if verdict == UNSOLVED else "")
    if verdict == WRONG:
        reason = f"claims a residual within {tol:g}, has {exact:.2g}" + (f"; {answer.detail}" if answer.detail else "")
    return Finding(verdict, reason, exact, model, fclib_error(problem, impulse), ledger_defect(problem, impulse))


def _complaint(problem: FrictionProblem, impulse: Array) -> str | None:
    expected = (problem.contacts, problem.dimension)
    if impulse.shape != expected:
        return f"the impulse has shape {impulse.shape}, not {expected}"
    if not np.isfinite(impulse).all():
        return "the impulse is not finite"
    return None


def _model_residual(problem: FrictionProblem, answer: Answer, info: SolverInfo, exact: float) -> float:
    if info.model == "relaxation":
        return relaxation_residual(problem, np.asarray(answer.impulse, dtype=float))
    if info.model == "lcp" and problem.dimension == 3 and answer.z is not None:
        return problem.lcp().residual(answer.z)
    return exact


def verify_lcp(lcp: LCP, answer: Answer, tol: float) -> Finding:
    """The finding on an answer to a bare LCP; FCLIB's error and the energy have no meaning there."""
    claimed = answer.status is Status.SOLVED
    if answer.z is None or np.shape(answer.z) != (lcp.size,):
        return Finding(WRONG if claimed else UNSOLVED, "z is missing or of the wrong shape", *(np.inf,) * 4)
    found = lcp.residual(answer.z)
    return Finding(_verdict(found, found, claimed, tol), answer.detail, found, found, np.nan, np.nan)


def _verdict(exact: float, model: float, claimed: bool, tol: float) -> str:
    if exact <= tol:
        return SOLVED
    if model <= tol:
        return RELAXED
    return WRONG if claimed else UNSOLVED
