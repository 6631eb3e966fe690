"""What the checks of the contract share: the solver under examination, the problems it takes, the words of a finding.

    @check("Give impulses of shape (contacts, dimension), normal first.")
    def shape(subject: Subject) -> Iterator[str]:
        yield "..."          # a complaint; none where all is well

The string is what to do about it.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from frictionbench.harness.verify import Finding, verify
from frictionbench.problems import FrictionProblem, scene
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate
from frictionbench.problems.instances import make_instance
from frictionbench.results.verdicts import Verdict
from frictionbench.solvers import Answer, Solver, SolverInfo

TOL = 1e-6
Complaints = Iterator[str]


class Subject(NamedTuple):
    """The solver under examination."""

    info: SolverInfo
    solver: Solver

    def takes(self, *problems: FrictionProblem) -> list[FrictionProblem]:
        """Those of the problems that the solver does not refuse."""
        return [problem for problem in problems if not self.info.refuses(problem)]

    def solve(
        self, problem: FrictionProblem, tol: float = TOL, limit: int | None = None, start: Array | None = None
    ) -> tuple[Answer, Finding]:
        """Its answer to a copy of the problem, and what it is worth."""
        answer = self.solver.solve(self.solver.prepare(duplicate(problem)), tol, limit, start)
        return answer, verify(problem, answer, self.info, tol)


class Check(NamedTuple):
    """A check: its name, what it finds, and what to do about it."""

    name: str
    advice: str
    complaints: Callable[[Subject], Complaints]


CHECKS: dict[str, Check] = {}


def check(advice: str) -> Callable[[Callable[[Subject], Complaints]], Callable[[Subject], Complaints]]:
    """List a check under its function's name."""

    def listed(complaints: Callable[[Subject], Complaints]) -> Callable[[Subject], Complaints]:
        CHECKS[complaints.__name__] = Check(complaints.__name__, advice, complaints)
        return complaints

    return listed


def well(finding: Finding) -> bool:
    """Whether the solver's own model is solved."""
    return finding.verdict in (Verdict.SOLVED, Verdict.RELAXED)


def lie(finding: Finding) -> bool:
    """Whether a claim is off by more than a difference of norms."""
    return finding.verdict == Verdict.WRONG


def ordinary() -> list[FrictionProblem]:
    """Small problems with an answer that most methods reach, in the plane and in space."""
    return [
        scene("stack", blocks=1, push=1.0).problem(),
        scene("pyramid", rows=2, friction=0.2).problem(),
        make_instance("random", seed=3, contacts=4, friction=0.2),
        make_instance("cubes", boxes=1, push=1.0, friction=0.2),
        make_instance("random_bodies", seed=3, contacts=4, friction=0.2),
    ]


def contact(dimension: int, friction: float = 0.5, speed: float = 1.0, falling: float = 1.0) -> FrictionProblem:
    """A point of 2 kg that slides on the ground at `speed` and would fall into it at `falling`, both in m/s."""
    rows, free = np.eye(dimension), np.zeros(dimension)
    free[:2] = -falling, speed
    return FrictionProblem(
        mass=2 * rows,
        normal=rows[:1],
        tangent=rows[1:],
        friction=np.array([friction]),
        free_velocity=free,
        bias=np.zeros(1),
        dimension=dimension,
    )
