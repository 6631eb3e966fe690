"""Verification: the verdict on an answer (problems.verdicts), computed from the problem and the answer alone.

The answer's claim decides only between the verdicts on an inaccurate answer. An accurate answer is `solved` or `relaxed`,
whatever its status. An inaccurate one is `unsolved` if it does not claim to be solved, and otherwise `near_miss`,
`unjudgeable` or `wrong`. A malformed answer that claims to be solved is `wrong`.

The residuals of the exact problem and of the model are computed separately: the first contains model error and solver error,
the second only solver error. Verdicts are no finer than floating-point arithmetic allows (contact_floors in problems.residual).

Contacts are judged one by one, each in its own unit and with its own floor (problems.residual), so that neither the speed nor
the rounding errors of one part excuse another. A contact is unjudgeable in two cases: if its floor is above the tolerance and
its residual is within the floor; and if its residual is within the tolerance but above LEAST_GAIN times that of zero impulses
in its island, because such a residual says little. If the other contacts are not solved, theirs is the verdict; otherwise it is
`unjudgeable`. So is a false claim whose residual is below NEAR_MISS times W's asymmetry, if rounding in a file can cause that
asymmetry (FILE_ROUNDING). For a solver of the relaxation, a verdict `relaxed` uses the floor of the relaxation; any other
verdict uses the larger of the floors of both laws.

tol bounds the residual of the solver's own model, the maximum over contacts. A solver with another stopping test must ask for
less (solvers.interface): then none does more work than its measure needs, and none gains time by stopping early.

A solver of regularised contacts states its softness R, u = W r + q + R r, and is verified as a solver of that model. Since
any answer solves some regularised model, R is bounded: 0 <= R_i <= max(tol, SOFTEST) s_i, with s_i as in problems.residual. An
answer with a larger R is verified without R, and the reason says so; otherwise the reason gives R.
"""

from dataclasses import dataclass

import numpy as np

from frictionbench.problems.answer import Answer, Status
from frictionbench.problems.check import Array
from frictionbench.problems.forms.definite import FILE_ROUNDING
from frictionbench.problems.forms.islands import NOISE
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import contact_floors, contact_residuals, fclib_error, largest, polygon_residuals
from frictionbench.problems.verdicts import ACCEPTED, Verdict

NEAR_MISS = 10.0  # times the tolerance: a smaller residual may be due to another norm in the solver's own stopping test
LEAST_GAIN = 0.01  # times the residual of zero impulses: a larger residual hardly differs from that of no answer
SOFTEST = 1e-6  # times s: softness allowed at any tolerance, because regularised methods cannot solve rigid contacts


@dataclass(frozen=True)
class Finding:
    """The verdict on an answer, its reason and the values behind it.

    verdict          a Verdict
    reason           why, if the verdict needs a reason; otherwise empty
    residual         of the exact problem, as a relative contact velocity; infinite if the impulse has a wrong shape
    model_residual   of the solver's own model, in the same measure
    floor            how much rounding alone may change the residual, in the same measure; 0 for an LCP: not computed
    fclib_error      FCLIB's error measure, dimensionless; NaN for an LCP
    energy_defect    J, defect of the energy balance; NaN for an LCP
    """

    verdict: Verdict
    reason: str
    residual: float
    model_residual: float
    floor: float
    fclib_error: float
    energy_defect: float

    def __repr__(self) -> str:
        return f"Finding({self.verdict}, residual {self.residual:.2g}{f', {self.reason}' if self.reason else ''})"


def verify(problem: FrictionProblem | LCP, answer: Answer, model: str, tol: float, *, quiet: bool = False) -> Finding:
    """The finding on an answer.

    model: that of the solver, "coulomb", "lcp", "relaxation" or "regularised" (solvers.interface). quiet: leave the detail of
    an accepted answer out of the reason, because a library's message of success adds nothing to its status.
    """
    if isinstance(problem, LCP):
        return _verify_lcp(problem, answer, tol)
    claimed = answer.status is Status.SOLVED
    impulse = np.asarray(answer.impulse, dtype=float)
    expected = (problem.contacts, problem.dimension)
    if impulse.shape != expected or not np.isfinite(impulse).all():
        wrong = f"has shape {impulse.shape}, not {expected}" if impulse.shape != expected else "is not finite"
        return Finding(Verdict.WRONG if claimed else Verdict.UNSOLVED, f"the impulse {wrong}", *(np.inf,) * 5)
    softness, soft = _softness(problem, answer, model, tol)
    shift = 0.0 if model in ("relaxation", "regularised") else 1.0
    by_contact = contact_residuals(problem, impulse)
    idle = contact_residuals(problem, np.zeros_like(impulse))
    of_own_model = _model_residuals(problem, answer, model, by_contact, softness)
    parts = (by_contact, of_own_model, contact_floors(problem, impulse, shift))
    exact, of_model, floor = (largest(part) for part in parts)
    reported = claimed or answer.status is Status.ROUNDING
    island = problem.bearing_islands
    worst = np.zeros(island.max(initial=-1) + 1)
    np.maximum.at(worst, island, idle)
    of_island = worst[island]
    verdict, why = _verdict([*parts, of_island], claimed, reported, tol)
    if shift == 0 and verdict != Verdict.RELAXED:
        larger = np.maximum(parts[2], contact_floors(problem, impulse))
        verdict, why = _verdict([*parts[:2], larger, of_island], claimed, reported, tol)
        floor = largest(larger)
    of_asymmetry = min(exact, of_model) < NEAR_MISS * problem.asymmetry <= NEAR_MISS * FILE_ROUNDING
    if of_asymmetry and verdict in (Verdict.NEAR_MISS, Verdict.WRONG):
        verdict, why = Verdict.UNJUDGEABLE, f"{why}, but W is unsymmetric by {problem.asymmetry:.1g}"
    accepted = claimed and verdict in ACCEPTED
    with np.errstate(over="ignore", invalid="ignore"):
        defect = ledger_defect(problem, impulse)
    status = answer.status.value if verdict == Verdict.UNSOLVED and not answer.detail else ""
    reasons = [why, soft, "" if accepted and quiet else answer.detail, status]
    return Finding(verdict, "; ".join(filter(None, reasons)), exact, of_model, floor, fclib_error(problem, impulse), defect)


def ledger_defect(problem: FrictionProblem, impulse: Array) -> float:
    """The energy, J, that an answer (nc, d) adds compared with the energy balance of an exact answer.

    With v* the free velocity, lambda = |u_t|, and u = J v + b, an exact answer satisfies

        T(v) = T(v*) - |J'r|^2/2 (in M^-1) - b.r_n - sum lambda (mu r_n + b_f),

    and the defect of any answer is sum r_n u_n + r_t.u_t + |u_t| (mu r_n + b_f), positive if the answer has too much energy.
    """
    u = problem.contact_velocity(impulse)
    slip = np.linalg.norm(u[:, 1:], axis=1)
    return float(np.sum(impulse * u) + slip @ (problem.friction * impulse[:, 0] + problem.friction_bias))


def _softness(problem: FrictionProblem, answer: Answer, model: str, tol: float) -> tuple[Array | None, str]:
    """The softness R (nc, d) with which a regularised answer is verified, or None, and a remark about it."""
    if model != "regularised" or answer.softness is None or not problem.contacts:
        return None, ""
    claimed, bound = np.asarray(answer.softness, dtype=float), max(tol, SOFTEST)
    if claimed.shape != (problem.contacts, problem.dimension) or not (claimed >= 0).all():
        return None, f"softness is not {problem.contacts} by {problem.dimension} numbers of at least 0: verified without it"
    share = float((claimed / problem.scale[:, None]).max())
    if not share <= bound * (1 + 1e-9):
        return None, f"softness of {share:.1g} of W's diagonal is above the {bound:.1g} allowed: verified without it"
    return claimed, f"verified with contacts regularised by {share:.1g} of W's diagonal"


def _model_residuals(problem: FrictionProblem, answer: Answer, model: str, exact: Array, softness: Array | None) -> Array:
    """The residual of each contact (nc,) in the solver's own model."""
    if model in ("relaxation", "regularised"):
        return contact_residuals(problem, np.asarray(answer.impulse, dtype=float), 0.0, softness)
    if model == "lcp" and problem.dimension == 3 and answer.z is not None:
        facets = np.size(answer.z) // max(problem.contacts, 1) - 2  # z is (c, beta, lambda); beta has `facets` per contact
        if problem.contacts and np.shape(answer.z) == (problem.contacts * (facets + 2),) and facets >= 4 and facets % 2 == 0:
            return polygon_residuals(problem, problem.lcp(facets), answer.z)
    return exact


def _verify_lcp(lcp: LCP, answer: Answer, tol: float) -> Finding:
    """The finding on an answer to a bare LCP, without rounding floor, FCLIB's error and energy defect."""
    claimed = answer.status is Status.SOLVED
    if answer.z is None or np.shape(answer.z) != (lcp.size,):
        return Finding(Verdict.WRONG if claimed else Verdict.UNSOLVED, "z is missing or of the wrong shape", *(np.inf,) * 5)
    found = lcp.residual(answer.z)
    parts = [np.array([part]) for part in (found, found, 0.0, lcp.residual(np.zeros(lcp.size)))]
    verdict, why = _verdict(parts, claimed, claimed, tol)
    return Finding(verdict, "; ".join(filter(None, (why, answer.detail))), found, found, 0.0, np.nan, np.nan)


def _verdict(parts: list[Array], claimed: bool, reported: bool, tol: float) -> tuple[Verdict, str]:
    """The verdict and its reason, which states the residuals or floors that decide.

    parts: for each contact, the residuals of the exact problem and of the model, the floor, and the residual of zero impulses
    in its island. claimed: the answer claims to be solved.
    reported: the answer claims to be solved, or solved as far as rounding allows.
    """
    exact, model, floor, idle = parts
    best = np.minimum(exact, model)
    coarse = (best <= tol) & (idle > NOISE) & (best > LEAST_GAIN * idle)
    rounded = (floor > tol) & (best <= floor) & np.isfinite(floor)
    unknown = coarse | rounded
    worst, of_model = largest(exact[~unknown]), largest(model[~unknown])
    nearest = min(worst, of_model)
    if nearest <= tol and unknown.any():
        if rounded.any():
            why = f"rounding alone may cause a residual of {largest(floor[rounded]):.2g}, above the tolerance {tol:g}"
        else:
            why = f"no impulses at all have the residual {idle[coarse].min():.2g}, too close to the tolerance {tol:g}"
        return (Verdict.UNJUDGEABLE, why) if reported else (Verdict.UNSOLVED, "")
    if nearest <= tol:
        return Verdict.SOLVED if worst <= tol else Verdict.RELAXED, ""
    if not claimed:
        return Verdict.UNSOLVED, ""
    of = "" if nearest == worst else " of its model"
    times = float(f"{nearest / tol:.2g}")  # 100 times, not 1e+02
    above = f"{nearest:.2g}, {times:g} times that"
    if nearest < 1.05 * tol:  # rounded to two digits, the residual would equal tol
        above = f"above it by {100 * (nearest / tol - 1):.1g} %"
    why = f"claimed solved within {tol:g}; the residual{of} is {above}"
    return Verdict.NEAR_MISS if nearest < NEAR_MISS * tol else Verdict.WRONG, why
