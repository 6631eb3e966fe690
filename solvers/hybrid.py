"""A portfolio: the fastest method first, then others until an answer is within the tolerance.

No single method is fast, accurate and reliable on every friction problem. In the plane Lemke's pivots are the fastest up to
some dozens of contacts, an interior point's sparse factorisations beyond. In space a few sweeps of Gauss-Seidel solve the
smallest problems, and give the interior point a start for the largest that saves most of its iterations. In between they cost
more than they save, as they do for hyperstatic contacts such as those of stacks of cubes: W is singular there, and 30 sweeps
leave a residual of a tenth. The interior point is itself a portfolio of the convex relaxation and central paths, and solves
nearly all that is left. Pivoting ends on an exact basis; each method fails on some instances that another solves. The portfolio
stops at the first answer whose residual, computed here from the problem's own velocities, is within the tolerance; it solves
what any member solves, and reports failure if none does. (Algorithm portfolios: Gomes and Selman 2001.)
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual_with_floor
from frictionbench.solvers.interface import Answer, Solver, SolverInfo, Status, find, solver

PLANAR = ("lemke", "interior_point", "path_search", "staggered", "anitescu_hart", "fischer_newton")
SPATIAL = ("nsgs", "interior_point", "proximal_newton", "nncg", "apgd_coulomb", "staggered", "admm_coulomb", "anitescu_hart")
# Measured by tests/benchmarks/test_hybrid.py, which times hybrid beside its members at every size.
PIVOTS = 48  # contacts up to which lemke, form and solve, is faster than interior_point
SWEPT = 6, 60  # contacts up to which nsgs alone is faster, and from which its sweeps save interior_point more than they cost
HYPERSTATIC = 1.25  # contact rows per velocity above which sweeps help in the smallest problems only: W is singular
SWEEPS = 30  # of nsgs: a fraction of the time of interior_point at any size
CLOSE = 0.01  # largest residual at which the impulses of one member are a better start for the next than none


Members = tuple[tuple[SolverInfo, Solver], ...]


class Prepared(NamedTuple):
    """The problem, the members in order, and the form of the first member, later its setup."""

    problem: FrictionProblem
    members: Members
    first: Any


MEMBERS = tuple(dict.fromkeys((*PLANAR, *SPATIAL)))


@solver("hybrid", family="portfolio", model="coulomb", dimension=(2, 3), warm_start=True, sparse=True, members=MEMBERS)
class Hybrid:
    """A portfolio: the interior point or a simpler method first, then others, until a checked answer is within the tolerance.

    The limit bounds each member's unit of work. work counts the members tried and, by name, the work of each.
    """

    def form(self, problem: FrictionProblem) -> Prepared:
        nc, d = problem.contacts, problem.dimension
        members = _members(d, nc <= PIVOTS if d == 2 else _sweeps_help(problem))
        return Prepared(problem, members, members[0][1].form(problem))

    def setup(self, formed: Prepared) -> Prepared:
        return Prepared(formed.problem, formed.members, formed.members[0][1].setup(formed.first))

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        problem = prepared.problem
        impulse, least, found_by = np.zeros((problem.contacts, problem.dimension)), np.inf, ""
        work: dict[str, int] = {}
        for tried, (info, member) in enumerate(prepared.members, start=1):
            stage = prepared.first if tried == 1 else member.prepare(problem)
            own_limit = (SWEEPS if limit is None else min(SWEEPS, limit)) if info.name == "nsgs" else limit
            guess = impulse if least <= CLOSE else start
            answer = member.solve(stage, tol, own_limit, guess if info.warm_start else None)
            work |= {f"{info.name} {unit}": count for unit, count in answer.work.items()} | {"members": tried}
            found, floor = residual_with_floor(problem, answer.impulse)
            if found < least:
                impulse, least, found_by = answer.impulse, found, info.name
            if least <= tol:
                status = Status.SOLVED if floor <= tol else Status.ROUNDING  # other members' impulses would be as large
                return Answer(impulse, status, work, detail=f"answered by {found_by}")
        return Answer(impulse, Status.STALLED, work, detail=f"the nearest answer is by {found_by}" if found_by else "")


def _sweeps_help(problem: FrictionProblem) -> bool:
    """Whether nsgs comes first in space."""
    nc, velocities = problem.contacts, len(problem.free_velocity)
    return nc <= SWEPT[0] or (nc >= SWEPT[1] and nc * problem.dimension <= HYPERSTATIC * velocities)


@cache
def _members(dimension: int, simple_first: bool) -> Members:
    """The members in order: the simpler method of the first two before the other, or after it."""
    simple, other, *rest = SPATIAL if dimension == 3 else PLANAR
    return tuple(find(name) for name in ((simple, other, *rest) if simple_first else (other, simple, *rest)))
