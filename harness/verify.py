"""What an answer is worth, found from the problem alone. Nothing that a solver says is believed; nothing else decides.

    solved        the residual of the exact problem is within the tolerance, whatever the solver says of itself
    relaxed       it is not, but the model that the solver was given is solved within the tolerance
    missed        neither, the solver claims to have solved it, and the nearer of the two is off by less than a factor of ten
    unjudgeable   it claims so, and its residual may be nothing but rounding, which alone is above the tolerance
    wrong         it claims so, and is off by more; or what came back is no answer at all
    unsolved      none of the first two, and the solver says so

The exact problem's residual and the model's are measured apart: the first is model error and solver error together, the
second the solver's alone. Verdicts are no finer than arithmetic: see residual_floor in problems.residual.

What tol means, and the margins that solvers keep. tol is a bound of the residual of the solver's own model, in the measure of
problems.residual, which is the worst contact's. A solver that computes this very residual stops at tol. One that stops by
another measure is to ask for as much less as that measure can fall short of this one, tol times a margin that stands where
it is used, with its reason; so no solver does more work than its measure needs, and none is paid for claiming early. What a
bound between two norms cannot promise is `near_miss` where it comes close and `wrong` where it does not.

A solver of regularised contacts says how soft it made them, u = W r + q + R r, and is judged as that model's. With R chosen
freely any answer is some soft model's, so R is bound to the tolerance: 0 <= R_i <= max(tol, SOFTEST) s_i, s_i as in
problems.residual. Beyond that the answer is judged without any, and the reason says so; within, the reason tells R.
"""

from dataclasses import dataclass

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.residual import (
    energy_within,
    fclib_error,
    polygon_residual,
    relaxation_residual,
    residual,
    residual_floor,
)
from frictionbench.problems.simulate import ledger_defect
from frictionbench.results.verdicts import Verdict
from frictionbench.solvers import Answer, SolverInfo, Status

NEAR = 10.0  # times the tolerance: an honest difference of norms
SOFTEST = 1e-6  # of s: softness that is allowed at any tolerance, for hard contacts are out of reach of such methods
FAR = 10.0  # times the energy defect that the tolerance allows: a reason to look


@dataclass(frozen=True)
class Finding:
    """The verdict and what it rests on; residuals and their floor as in problems.residual, energy_defect in joules."""

    verdict: Verdict
    reason: str
    residual: float
    model_residual: float
    floor: float
    fclib_error: float
    energy_defect: float

    def __repr__(self) -> str:
        return f"Finding({self.verdict}, residual {self.residual:.2g}{f', {self.reason}' if self.reason else ''})"


def verify(problem: FrictionProblem, answer: Answer, info: SolverInfo, tol: float) -> Finding:
    """The finding on an answer to a friction problem."""
    claimed = answer.status is Status.SOLVED
    impulse = np.asarray(answer.impulse, dtype=float)
    if complaint := _complaint(problem, impulse):
        return Finding(Verdict.WRONG if claimed else Verdict.UNSOLVED, complaint, *(np.inf,) * 5)
    exact, floor = residual(problem, impulse), residual_floor(problem, impulse)
    softness, soft = _softness(problem, answer, info, tol)
    model = _model_residual(problem, answer, info, exact, softness)
    verdict = _verdict(exact, model, floor, claimed, tol)
    defect = ledger_defect(problem, impulse)
    reasons = [
        _reason(verdict, exact, model, floor, tol),
        soft,
        ""
        if info.needs and claimed and verdict in (Verdict.SOLVED, Verdict.RELAXED)
        else answer.detail,  # a library's word for success
        answer.status.value if verdict == Verdict.UNSOLVED and not answer.detail else "",
    ]
    allowed = energy_within(problem, impulse, max(exact, tol))
    if abs(defect) > FAR * allowed:
        reasons.append(f"look: an energy defect of {abs(defect):.2g} J, where such a residual explains {allowed:.2g}")
    return Finding(verdict, "; ".join(filter(None, reasons)), exact, model, floor, fclib_error(problem, impulse), defect)


def _complaint(problem: FrictionProblem, impulse: Array) -> str | None:
    expected = (problem.contacts, problem.dimension)
    if impulse.shape != expected:
        return f"the impulse has shape {impulse.shape}, not {expected}"
    if not np.isfinite(impulse).all():
        return "the impulse is not finite"
    return None


def _softness(problem: FrictionProblem, answer: Answer, info: SolverInfo, tol: float) -> tuple[Array | None, str]:
    """The softness R (nc, d) that a regularised answer is judged with, None for none; what is to be said of it."""
    if info.model != "regularised" or answer.softness is None or not problem.contacts:
        return None, ""
    claimed, bound = np.asarray(answer.softness, dtype=float), max(tol, SOFTEST)
    if claimed.shape != (problem.contacts, problem.dimension) or not (claimed >= 0).all():
        return None, f"softness must be {problem.contacts} by {problem.dimension} numbers, none below 0: judged without"
    share = float((claimed / problem.scale[:, None]).max())
    if not share <= bound * (1 + 1e-9):
        return None, f"claims a softness of {share:.1g} of W's diagonal, where {bound:.1g} is allowed: judged without"
    return claimed, f"contacts made soft by {share:.1g} of W's diagonal"


def _model_residual(problem: FrictionProblem, answer: Answer, info: SolverInfo, exact: float, softness: Array | None) -> float:
    if info.model in ("relaxation", "regularised"):
        return relaxation_residual(problem, np.asarray(answer.impulse, dtype=float), softness)
    if info.model == "lcp" and problem.dimension == 3 and answer.z is not None:
        facets = np.size(answer.z) // max(problem.contacts, 1) - 2  # z is (c, beta, lambda), beta of as many parts a contact
        if problem.contacts and np.shape(answer.z) == (problem.contacts * (facets + 2),) and facets >= 4 and facets % 2 == 0:
            return polygon_residual(problem, problem.lcp(facets), answer.z)
    return exact


def verify_lcp(lcp: LCP, answer: Answer, tol: float) -> Finding:
    """The finding on an answer to a bare LCP; its rounding, FCLIB's error and the energy are not measured there."""
    claimed = answer.status is Status.SOLVED
    if answer.z is None or np.shape(answer.z) != (lcp.size,):
        return Finding(Verdict.WRONG if claimed else Verdict.UNSOLVED, "z is missing or of the wrong shape", *(np.inf,) * 5)
    found = lcp.residual(answer.z)
    verdict = _verdict(found, found, 0.0, claimed, tol)
    reason = "; ".join(filter(None, (_reason(verdict, found, found, 0.0, tol), answer.detail)))
    return Finding(verdict, reason, found, found, 0.0, np.nan, np.nan)


def _verdict(exact: float, model: float, floor: float, claimed: bool, tol: float) -> Verdict:
    if floor > tol and min(exact, model) <= floor:
        return Verdict.UNJUDGEABLE if claimed else Verdict.UNSOLVED
    if exact <= tol:
        return Verdict.SOLVED
    if model <= tol:
        return Verdict.RELAXED
    if not claimed:
        return Verdict.UNSOLVED
    return Verdict.NEAR_MISS if min(exact, model) < NEAR * tol else Verdict.WRONG


def _reason(verdict: Verdict, exact: float, model: float, floor: float, tol: float) -> str:
    if verdict == Verdict.UNJUDGEABLE:
        return f"rounding alone may make a residual of {floor:.2g}, and {tol:g} was asked for"
    if verdict in (Verdict.NEAR_MISS, Verdict.WRONG):
        nearest = min(exact, model)
        of = "" if nearest == exact else " of its model"
        return f"claims a residual{of} within {tol:g}, has {nearest:.2g}, {nearest / tol:.2g} times that"
    return ""
