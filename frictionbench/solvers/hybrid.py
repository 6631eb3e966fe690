"""A portfolio: the fastest method first, then others until an answer is within the tolerance.

No single method is fast, accurate and reliable on every friction problem. In the plane Lemke's pivots are the fastest up to
some dozens of contacts (solvers.portfolio.few_pivots), an interior point's sparse factorisations beyond. In space a few
sweeps of Gauss-Seidel solve the smallest problems, and give the interior point a start for the largest that saves most of its
iterations. In between they cost more than they save, as they do for hyperstatic contacts such as those of stacks of cubes: W
is singular there, and 30 sweeps leave a residual of a tenth. The interior point is itself a portfolio of the convex relaxation
and central paths, and solves nearly all that is left. Pivoting ends on an exact basis; each method fails on some instances
that another solves. The portfolio stops at the first answer whose residual, computed here from the problem's own velocities,
is within the tolerance; it solves what any member solves, and reports failure if none does. (Algorithm portfolios: Gomes and
Selman 2001.)

A time limit is divided by what each member was measured to bring (solvers.portfolio.shares). With the fraction f_i of the limit
member i solves a problem that takes it the time t_i within the limit t_i/f_i. How long limits are is not known beforehand, so
that the mean logarithm of the least one is to be small: min_i t_i/f_i is reached by one member, and where n_i problems are
member i's, the sum of -n_i log f_i is least for f_i ~ n_i, each member's chance to be the one that brings the answer. Chances
are estimated as n_i + 1 over their sum (Laplace's rule). What a member leaves of its time is for those after it.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.packed import Packed, residuals
from frictionbench.problems.residual import residual_with_floor
from frictionbench.solvers.clock import is_over, left, within
from frictionbench.solvers.interface import Answer, Solved, Solver, SolverInfo, Status, dense_storage, find, solver
from frictionbench.solvers.interior_point import first_phase_of
from frictionbench.solvers.portfolio.few_pivots import few_pivots, few_pivots_each
from frictionbench.solvers.portfolio.shares import BROUGHT

PLANAR = ("lemke", "interior_point", "path_search", "staggered", "anitescu_hart", "fischer_newton")
SPATIAL = ("nsgs", "interior_point", "proximal_newton", "nncg", "apgd_coulomb", "staggered", "admm_coulomb", "anitescu_hart")
# Measured by tests/benchmarks/test_hybrid.py, which times hybrid beside its members at every size.
SWEPT = 6, 60  # contacts up to which nsgs alone is faster, and from which its sweeps save interior_point more than they cost
HYPERSTATIC = 1.25  # contact rows per velocity above which sweeps help in the smallest problems only: W is singular
SWEEPS = 30  # of nsgs: a fraction of the time of interior_point at any size
STORAGE = 2**32  # bytes of dense matrices above which a member is left out: its pivots would take hours
CLOSE = 0.01  # largest residual at which the impulses of one member are a better start for the next than none


Members = tuple[tuple[SolverInfo, Solver, float], ...]  # with the share of what is then left of a time limit
Prepared = tuple[FrictionProblem, Members, Any]  # the problem, the members in order, and the first one's form, later its setup
MEMBERS = tuple(dict.fromkeys((*PLANAR, *SPATIAL)))


@solver("hybrid", family="portfolio", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True, members=MEMBERS)
class Hybrid:
    """A portfolio: the interior point or a simpler method first, then others, until a checked answer is within the tolerance.

    Impulses that a member claims and whose residual rounding alone explains are an answer too.
    The limit bounds each member's unit of work. A time limit is divided by what each member was measured to bring.
    work counts the members tried and, by name, the work of each.
    """

    knows_rounding = True

    def form(self, problem: FrictionProblem) -> Prepared:
        members = _members(problem.dimension, simple_first(problem))
        return problem, members, members[0][1].form(problem)

    def setup(self, formed: Prepared) -> Prepared:
        problem, members, first = formed
        return problem, members, members[0][1].setup(first)

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        problem, members, first = prepared
        impulse, least, found_by, stage = None, np.inf, "", first
        work: dict[str, int] = {}
        tried, rounded, late = 0, False, False
        for info, member, share in members:
            if tried and dense_storage(member, problem) > STORAGE:  # the first is sparse, or the problem small
                continue
            tried += 1
            own_limit = (SWEEPS if limit is None else min(SWEEPS, limit)) if info.name == "nsgs" else limit
            guess = (impulse if least <= CLOSE else start) if info.warm_start else None
            if (seconds := left()) < np.inf:
                with within(share * seconds):
                    answer = member.solve(_ready(member, stage, problem), tol, own_limit, guess)
            else:  # without the cost of a context, a fiftieth of the time of the smallest problems
                answer = member.solve(_ready(member, stage, problem), tol, own_limit, guess)
            stage = None
            work.update(zip(_units_of(info.name, *answer.work), answer.work.values(), strict=True))
            work["members"] = tried
            found, floor = residual_with_floor(problem, answer.impulse)
            if found < least:
                impulse, least, found_by = answer.impulse, found, info.name
                if found <= tol:
                    status = Status.SOLVED if floor <= tol else Status.ROUNDING
                    return Answer(impulse, status, work, (), None, f"answered by {found_by}")
                rounded = rounded or (found <= floor and answer.status is Status.SOLVED)
            late = late or answer.status is Status.TIME_LIMIT
            # Where the floor is above the tolerance, a second member may find smaller impulses; more seldom do.
            if is_over() or (rounded and tried > 1):
                break
        status = Status.ROUNDING if rounded else Status.TIME_LIMIT if late else Status.STALLED
        if impulse is None:
            return Answer(np.zeros((problem.contacts, problem.dimension)), status, work)
        return Answer(impulse, status, work, detail=f"the nearest answer is by {found_by}")

    def solve_many(self, packed: Packed, tol: float, limit: int | None, start: Array | None = None) -> Solved:
        """The loops of the first two members; what they do not solve goes through all members by itself."""
        nc, space = np.diff(packed.contacts), packed.dimension == 3
        simple = "nsgs" if space else "lemke"
        chosen = _sweeps_help(nc, np.diff(packed.velocities), 0) if space else few_pivots_each(packed)
        loop: Any = find(simple)[1]
        own_limit = min(SWEEPS, limit or SWEEPS) if space else limit
        swept = loop.solve_many(_only(packed, chosen), tol, own_limit, start)
        least = np.where(chosen, residuals(packed, swept.impulse)[:, 0], np.inf)
        solved, members = least <= tol, np.ones(len(nc), np.int64)
        tried = ~solved & (swept.status != Status.SOLVED)  # what is claimed but above the tolerance, solve judges
        work = {f"{simple} {unit}": counts for unit, counts in swept.work.items()} | {"members": members}
        if tried.any():
            close = least <= CLOSE
            guess = swept.impulse if start is None else np.where(np.repeat(close, nc)[:, None], swept.impulse, start)
            found = first_phase_of(_only(packed, tried), tol, limit, guess, tried & (close | (start is not None)))
            work |= {f"interior_point {unit}": counts for unit, counts in found.work.items()}
            members[chosen & tried] = 2
            of_contact = np.repeat(tried, nc)
            swept.impulse[of_contact] = found.impulse[of_contact]
            solved |= (found.status == Status.SOLVED) & (residuals(packed, found.impulse)[:, 0] <= tol)
        return Solved(swept.impulse, np.array([None, Status.SOLVED])[solved.astype(int)], work)


def simple_first(problem: FrictionProblem) -> bool:
    """Whether the simpler method of the first two comes before the interior point."""
    if problem.dimension == 2:
        return few_pivots(problem)
    return bool(_sweeps_help(problem.contacts, len(problem.free_velocity), len(problem.joint_bias)))


def _only(packed: Packed, chosen: NDArray[np.bool_]) -> Packed:
    """The same problems, of which loops leave all but the chosen ones."""
    return packed._replace(spread=np.where(chosen, packed.spread, np.inf))


def _sweeps_help(nc: Any, velocities: Any, joints: Any) -> Any:
    """Whether nsgs comes first in space, for numbers or arrays of numbers. With joints it takes W, which they make dense."""
    return (nc <= SWEPT[0]) | ((nc >= SWEPT[1]) & (nc * 3 <= HYPERSTATIC * velocities) & (joints == 0))


def _ready(member: Solver, stage: Any, problem: FrictionProblem) -> Any:
    """What the member solves, prepared unless it has been."""
    return member.prepare(problem) if stage is None else stage


@cache
def _units_of(member: str, *units: str) -> tuple[str, ...]:
    return tuple(f"{member} {unit}" for unit in units)


@cache
def _members(dimension: int, simple_first: bool) -> Members:
    """The members in order, each with its share."""
    order = in_order(SPATIAL if dimension == 3 else PLANAR, simple_first)
    shares = _shares(dimension, order)
    return tuple((*find(name), share) for name, share in zip(order, shares, strict=True))


def in_order(members: tuple[str, ...], simple_first: bool) -> tuple[str, ...]:
    """The simpler method of the first two before the other, or after it."""
    simple, other, *rest = members
    return (simple, other, *rest) if simple_first else (other, simple, *rest)


def _shares(dimension: int, order: tuple[str, ...]) -> list[float]:
    """Of what is left of a time limit, the share of each member; see the top of this file."""
    chance = [BROUGHT[dimension, order[0]][name] + 1 for name in order]
    return [chance[k] / sum(chance[k:]) for k in range(len(chance))]
