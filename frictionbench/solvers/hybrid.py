"""A portfolio: the method that is fastest on the problem, then others if its answer is not within the tolerance.

No single method is fast, accurate and reliable on every friction problem. The interior point solves nearly all, and is the
fastest from some dozens of contacts on. For fewer contacts, Lemke's method (solvers.pivots.at_once) is faster in the plane,
and Newton's method on dense rows (solvers.dense) in space. From SWEPT contacts on it begins with sweeps of Gauss-Seidel, which
go on while they converge QUICKLY, except if contacts are hyperstatic: then W is singular, and sweeps are slow. On up to FEW
contacts in which the predictor-corrector is trapped, Lemke's method in the plane, Gauss-Seidel, and some proximal points in
space are mostly faster than its paths, and come before these: the interior point has two turns.

The portfolio stops at the first answer whose residual, computed here from the problem's own velocities, and its rounding floor
are within the tolerance: contacts that nearly jam have solutions with huge impulses and with small ones. If rounding explains
two answers of like floors, the floor is the problem's, and it stops as well. It returns the impulses of which the larger of
residual and floor is the least. In the plane the staggered method solves problems in which a very heavy body rests beside light
ones, whose digits are lost in factorisations. In space proximal points solve walls of boxes in which the interior point stalls,
and projected gradients solve nearly dependent rows of dry friction, for which the shifts of the other methods are too large.
(Algorithm portfolios: Gomes and Selman 2001.)
tests/benchmarks/test_hybrid.py measures up to how many contacts Lemke's method is faster in the plane (docs/tried.md).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.contradiction import contradiction
from frictionbench.problems.check import Array
from frictionbench.problems.packed import Packed, residuals
from frictionbench.problems.residual import residual_with_floor
from frictionbench.solvers.clock import TimeLimit, is_over, left
from frictionbench.solvers.dense.few_contacts import HYPERSTATIC, few_contacts, few_contacts_each, few_each, few_steps
from frictionbench.solvers.interface import Answer, Solved, Status, dense_storage, find, solver
from frictionbench.solvers.interior_point import InteriorPoint, first_phase_of
from frictionbench.solvers.nsgs import NSGS
from frictionbench.solvers.pivots.at_once import lemke_at_once
from frictionbench.solvers.sweeps.gauss_seidel import QUICKLY

INTERIOR = "interior_point"
PLANAR, SPATIAL = ("staggered",), ("proximal_newton", "apgd_coulomb")  # the last members
NEWTON = "newton"  # Newton's method on dense rows (solvers.dense), which is not a registered solver
TIME_SHARE = 0.9  # of the remaining time limit, for each member except the last: nearly all problems are solved by the first
STORAGE = 2**32  # bytes of dense matrices above which a further member is skipped: its pivots would take hours
USABLE_START = 0.01  # the largest residual at which the impulses of one member are a better start for the next than zeros
FEW = 100  # contacts up to which simpler methods are mostly faster than the paths of a trapped interior point
ALIKE = 2.0  # the largest ratio of two methods' floors at which rounding is that of the problem, not of an answer
SHORT = 100  # factorisations of proximal_newton before the paths of the interior point
MORE_SWEEPS = 300  # where others fail; more solve few other problems
PIVOTED = 36  # contacts up to which lemke comes first in the plane
SWEPT = 60  # contacts from which on the sweeps of nsgs save more than they cost, unless W is singular

# The problem, its members in order, and the form or setup of the first one. If that solves the problem in one call instead, the
# largest number of its Newton steps, or 0 for lemke.
Prepared = tuple[FrictionProblem, tuple[str, ...], Any]


@solver(
    "hybrid",
    family="portfolio",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    members=("lemke", "nsgs", INTERIOR, *PLANAR, *SPATIAL),
)
class Hybrid:
    """A portfolio: the interior point or a simpler method first, then others, until a checked answer is within the tolerance.

    In space the first is Newton's method on dense rows, for few contacts or none; it counts newton sweeps and steps.
    If the first of the members that runs to its end fails, a linear program looks for contacts that contradict each other.
    Impulses explained by rounding have the status ROUNDING if no member finds better ones, or a second one finds the like.
    limit bounds each member's unit of work. work counts the members tried and, by name, the work of each.
    """

    takes_unlike = True

    def form(self, problem: FrictionProblem) -> Prepared:
        nc, space, joints = problem.contacts, problem.dimension == 3, len(problem.joint_bias)
        steps = few_steps(problem) if space else 0
        by_newton = space and (steps > 0 or not nc)
        by_pivots, swept = not space and nc <= PIVOTED, _sweeps_help(problem.dimension, nc, len(problem.free_velocity), joints)
        first = (NEWTON,) if by_newton else ("lemke",) if by_pivots else ("nsgs",) if swept else ()
        later, last = ("nsgs",) if space or by_pivots else ("lemke", "nsgs"), SPATIAL if space else PLANAR
        before_paths = (*last[:-1], INTERIOR) if nc <= FEW else ()
        members = *first, INTERIOR, *later, *before_paths, *last
        at_once = by_newton or (by_pivots and not joints)
        return problem, members, steps if at_once else find(members[0])[1].form(problem)

    def setup(self, formed: Prepared) -> Prepared:
        problem, members, first = formed
        return formed if isinstance(first, int) else (problem, members, find(members[0])[1].setup(first))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        problem, members, stage = prepared
        impulse, least, found_by = np.zeros((problem.contacts, problem.dimension)), np.inf, ""
        work = {"members": 0}
        hidden, explained, late = 0.0, False, False  # hidden: the floor of the last impulses that rounding explains
        for turn, name in enumerate(members):
            with TimeLimit(left() if turn == len(members) - 1 else TIME_SHARE * left()):
                found, at_once = None, not turn and isinstance(stage, int)
                if at_once:
                    call = few_contacts if problem.dimension == 3 else lemke_at_once
                    found = call(problem, tol, min(stage, limit or stage) if stage else limit, start)
                if found is not None:
                    r, error, floor, counts = found
                else:
                    near = least <= USABLE_START and not hidden and name != "lemke"  # which is faster from zero than nearby
                    guess, short = impulse if near else start, name in members[turn + 1 :]
                    answer = _answer(name, problem, None if turn or at_once else stage, tol, limit, guess, short)
                    if answer is None:
                        continue
                    r, counts, late = answer.impulse, answer.work, late or answer.status is Status.TIME_LIMIT
                    error, floor = residual_with_floor(problem, r)
            for unit, count in counts.items():
                work[f"{name} {unit}"] = work.get(f"{name} {unit}", 0) + count
            work["members"] += 1
            known = max(error, floor)  # no less than the true residual
            if known <= tol:
                return Answer(r, Status.SOLVED, work, detail=f"answered by {name}")
            by_rounding = error <= floor
            if known < least:
                impulse, least, found_by, explained = r, known, name, by_rounding
            if by_rounding and hidden / ALIKE <= floor <= hidden * ALIKE:
                break
            hidden = floor if by_rounding else hidden
            if turn == (members[0] in ("nsgs", NEWTON)) and (proof := contradiction(problem)) and proof.least_residual > tol:
                return Answer(impulse, Status.INFEASIBLE, work, detail=str(proof))
            if is_over():
                break
        status = Status.ROUNDING if explained else Status.TIME_LIMIT if late else Status.STALLED
        return Answer(impulse, status, work, detail=f"the nearest answer is by {found_by}" if found_by else "")

    def solve_many(self, packed: Packed, tol: float, limit: int | None, start: Array | None = None) -> Solved:
        """The loops of the first two members; problems that they do not solve are left to be solved one by one."""
        nc, d, steps = np.diff(packed.contacts), packed.dimension, few_each(packed)
        few, swept = steps > 0, _sweeps_help(d, nc, np.diff(packed.velocities), 0)
        simple, pace, chosen = ("nsgs", (QUICKLY,), swept & ~few) if d == 3 else ("lemke", (), nc <= PIVOTED)
        first = find(simple)[1].solve_many(_only(packed, chosen), tol, limit, start, *pace)  # type: ignore[attr-defined]
        impulse, work = first.impulse, {f"{simple} {unit}": counts for unit, counts in first.work.items()}
        if few.any():
            newton_impulse, counts = few_contacts_each(packed, steps, tol, limit, start)
            impulse = np.where(np.repeat(few, nc)[:, None], newton_impulse, impulse)
            work |= {"newton sweeps": counts[:, 0], "newton steps": counts[:, 1]}
        least = np.where(few | chosen, residuals(packed, impulse).max(axis=1), np.inf)  # the larger of residual and floor
        solved, members = least <= tol, np.ones(len(nc), np.int64)
        tried = ~solved & (few | (first.status != Status.SOLVED))  # claims that are not confirmed are left to solve
        tried &= (d == 3) | ~swept  # in the plane these are solved one by one
        if tried.any():
            close = least <= USABLE_START
            guess = impulse if start is None else np.where(np.repeat(close, nc)[:, None], impulse, start)
            after = first_phase_of(_only(packed, tried), tol, limit, guess, tried & (close | (start is not None)))
            work |= {f"interior_point {unit}": counts for unit, counts in after.work.items()}
            members[(few | chosen) & tried] = 2
            impulse = np.where(np.repeat(tried, nc)[:, None], after.impulse, impulse)
            solved |= (after.status == Status.SOLVED) & (residuals(packed, after.impulse).max(axis=1) <= tol)
        work["members"] = members
        return Solved(impulse, np.array([None, Status.SOLVED])[solved.astype(int)], work)


def _answer(
    name: str, problem: FrictionProblem, stage: Any, tol: float, limit: int | None, guess: Array | None, short: bool
) -> Answer | None:
    """A member's answer; None if it stores too much. stage: that of the first member, else None. short: it has a later turn."""
    info, member = find(name)
    most = {"nsgs": MORE_SWEEPS, "proximal_newton": SHORT if short else None}.get(name)
    if stage is None:  # the first member is either sparse or given a small problem
        if dense_storage(member, problem) > STORAGE:
            return None
        stage = member.prepare(problem)
    method = member.begin if short and isinstance(member, InteriorPoint | NSGS) else member.solve
    return method(stage, tol, min(most, limit or most) if most else limit, guess if info.warm_start else None)


def _only(packed: Packed, chosen: NDArray[np.bool_]) -> Packed:
    """The same problems, of which loops skip all but the chosen ones."""
    return packed._replace(spread=np.where(chosen, packed.spread, np.inf))


def _sweeps_help(d: int, nc: Any, velocities: Any, joints: Any) -> Any:
    """Whether nsgs comes before interior_point, for numbers or arrays. With joints it works on W, which joints make dense."""
    return (nc >= SWEPT) & (nc * d <= HYPERSTATIC * velocities) & (joints == 0)
