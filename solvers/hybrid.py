"""A portfolio: the method that is fastest for the problem's size first, then others until an answer holds.

No single method is fast, accurate and reliable on every friction problem. Pivoting is exact and fastest while the LCP is small,
its cost growing with the square of the size and the number of pivots; an interior point's iteration costs one sparse
factorisation, so it wins on large problems; each fails on some instances that another solves. A portfolio stops at the first
answer whose residual, computed here from the problem's own velocities, is within the tolerance: so it solves what any of its
members does, and says so when none does. (Algorithm portfolios: Gomes and Selman 2001.)

In the plane:  lemke, path_search, interior_point                        up to LARGE unknowns of the LCP,
               interior_point, path_search, lemke                        above;
then staggered projections, Anitescu and Hart's fixed point and Fischer's Newton method. In space the methods with the
circular cone: Gauss-Seidel, accelerated gradients, conjugate gradients, staggered projections, ADMM, the fixed point.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from problems import FrictionProblem
from problems.check import Array
from problems.residual import residual
from solvers.interface import Answer, Solver, SolverInfo, Status, find, solver

LARGE = 100  # unknowns of the LCP, four a contact: from here on an interior point, prepared and solved, is faster
SMALL_PLANAR = ("lemke", "path_search", "interior_point")
LARGE_PLANAR = ("interior_point", "path_search", "lemke")
LAST_PLANAR = ("staggered", "anitescu_hart", "fischer_newton")
SPATIAL = ("nsgs", "apgd_coulomb", "nncg", "staggered", "admm_coulomb", "anitescu_hart")


@dataclass(frozen=True, eq=False)
class Prepared:
    """The problem, the members in order with their facts, and the first of them, prepared."""

    problem: FrictionProblem
    members: tuple[tuple[SolverInfo, Solver], ...]
    first: Any


@solver("hybrid", family="portfolio", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True)
class Hybrid:
    """A portfolio: pivoting while small, interior point when large, then others until a checked answer holds.

    The limit bounds each member's own unit of work. work counts the members tried and, by name, what each of them did.
    """

    def prepare(self, problem: FrictionProblem) -> Prepared:
        members = _members(problem.dimension, 4 * problem.contacts <= LARGE)
        return Prepared(problem, members, members[0][1].prepare(problem))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        problem = prepared.problem
        impulse, least, found_by = np.zeros((problem.contacts, problem.dimension)), np.inf, ""
        work: dict[str, int] = {}
        for tried, (info, member) in enumerate(prepared.members, start=1):
            stage = prepared.first if tried == 1 else member.prepare(problem)
            answer = member.solve(stage, tol, limit, start if info.warm_start else None)
            work |= {f"{info.name} {unit}": count for unit, count in answer.work.items()} | {"members": tried}
            found = residual(problem, answer.impulse)
            if found < least:
                impulse, least, found_by = answer.impulse, found, info.name
            if least <= tol:
                return Answer(impulse, Status.SOLVED, work, detail=found_by)
        return Answer(impulse, Status.STALLED, work, detail=found_by)


@cache
def _members(dimension: int, small: bool) -> tuple[tuple[SolverInfo, Solver], ...]:
    names = SPATIAL if dimension == 3 else (SMALL_PLANAR if small else LARGE_PLANAR) + LAST_PLANAR
    return tuple(find(name) for name in names)
