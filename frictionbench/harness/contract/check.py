"""What the checks of the contract share: the solver under test, test problems and transformations of problems.

    @check("Give impulses of shape (contacts, dimension), normal first.")
    def shape(subject: Subject) -> Iterator[str]:
        yield "..."          # a violation; none if the check passes

The decorator's argument is the advice shown with violations.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import AnswerError, checked_copy
from frictionbench.problems.catalogue import make_instance, scene
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate
from frictionbench.problems.verdicts import Verdict
from frictionbench.problems.verify import Finding, verify
from frictionbench.solvers import Answer, Solver, SolverInfo
from frictionbench.solvers.plugins import describe_error

TOL = 1e-6  # a tolerance that first-order methods and soft contacts reach as well
Violations = Iterator[str]


class Subject(NamedTuple):
    """The solver under test. broken: descriptions of what was wrong with the first calls in its process."""

    info: SolverInfo
    solver: Solver
    broken: Sequence[str] = ()

    def takes(self, *problems: FrictionProblem) -> list[FrictionProblem]:
        """Return the problems that the solver does not refuse."""
        return [problem for problem in problems if not self.info.refuses(problem)]

    def solve(
        self, problem: FrictionProblem, tol: float = TOL, limit: int | None = None, start: Array | None = None
    ) -> tuple[Answer, Finding]:
        """Return its answer to a copy of the problem, and the finding on it. Errors: AnswerError and those of the solver."""
        answer = checked_copy(self.solver.solve(self.solver.prepare(duplicate(problem)), tol, limit, start))
        return answer, verify(problem, answer, self.info.model, tol)

    def fault(self, problem: FrictionProblem) -> str:
        """Return why its answer to a problem cannot be used or is a false claim, or an empty text."""
        try:
            answer, finding = self.solve(problem)
        except AnswerError as error:
            return str(error)
        except BaseException as error:  # a plug-in may also call sys.exit
            writes = isinstance(error, ValueError) and "read-only" in str(error)  # NumPy's wording
            hint = "do not write into the problem, copy its arrays: " if writes else ""
            return hint + describe_error(error)
        if min(answer.work.values(), default=0) < 0:
            return f"counts of work below 0: {answer.work}"
        unusable = np.shape(answer.impulse) != (problem.contacts, problem.dimension)
        return finding.reason if unusable or finding.verdict == Verdict.WRONG else ""


class Check(NamedTuple):
    """The advice shown with violations, and the function that yields them."""

    advice: str
    violations: Callable[[Subject], Violations]


CHECKS: dict[str, Check] = {}


def check(advice: str) -> Callable[[Callable[[Subject], Violations]], Callable[[Subject], Violations]]:
    """Register a check under its function's name."""

    def register(violations: Callable[[Subject], Violations]) -> Callable[[Subject], Violations]:
        CHECKS[violations.__name__] = Check(advice, violations)
        return violations

    return register


def ordinary() -> list[FrictionProblem]:
    """Return small planar and spatial problems that most methods solve."""
    return [
        scene("stack", blocks=1, push=1.0).problem(),
        scene("pyramid", rows=2, friction=0.2).problem(),
        make_instance("random", seed=3, contacts=4, friction=0.2),
        make_instance("cubes", boxes=1, push=1.0, friction=0.2),
        make_instance("random_bodies", seed=3, contacts=4, friction=0.2),
    ]


def contact(dimension: int, friction: float = 0.5, speed: float = 1.0, falling: float = 1.0, spare: int = 0) -> FrictionProblem:
    """Make a point mass of 2 kg on the ground with tangential velocity `speed` and downward velocity `falling`, both in m/s.

    spare: the number of additional velocities, which the contact does not affect.
    """
    rows, free = np.eye(dimension + spare), np.zeros(dimension + spare)
    free[:2] = -falling, speed
    return FrictionProblem(
        mass=2 * rows,
        normal=rows[:1],
        tangent=rows[1:dimension],
        friction=np.array([friction]),
        free_velocity=free,
        bias=np.zeros(1),
        dimension=dimension,
    )


def permuted(problem: FrictionProblem, order: NDArray[np.intp]) -> FrictionProblem:
    """Return the problem with its contacts in another order, which may repeat contacts."""
    rows = (order[:, None] * (problem.dimension - 1) + np.arange(problem.dimension - 1)).ravel()
    by_contact = {name: getattr(problem, name)[order] for name in ("friction", "bias", "friction_bias")}
    return problem.replace(normal=problem.normal[order], tangent=problem.tangent[rows], **by_contact)


def duplicated(problem: FrictionProblem) -> FrictionProblem:
    """Return the problem with every contact twice."""
    return permuted(problem, np.repeat(np.arange(problem.contacts), 2))


def mirrored(problem: FrictionProblem) -> FrictionProblem:
    """Return the problem with the first tangent of every contact reversed."""
    sign = np.where(np.arange(problem.tangent.shape[0]) % (problem.dimension - 1) == 0, -1.0, 1.0)
    return problem.replace(tangent=sparse.diags_array(sign) @ problem.tangent)


def rotated(problem: FrictionProblem, angle: Array) -> FrictionProblem:
    """Return a spatial problem with the tangents of contact i rotated by angle[i]."""
    turns = [[[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]] for a in angle]
    return problem.replace(tangent=sparse.block_diag(turns, format="csr") @ problem.tangent)


def in_units(problem: FrictionProblem, mass: float, velocity: float) -> FrictionProblem:
    """Return the problem in units in which masses have `mass` times and velocities `velocity` times their values."""
    return problem.replace(
        mass=mass * problem.mass,
        free_velocity=velocity * problem.free_velocity,
        bias=velocity * problem.bias,
        friction_bias=mass * velocity * problem.friction_bias,
        joint_bias=velocity * problem.joint_bias,
    )
