"""The driver of the interior point methods: phases, each with its own start, are run in turn until one solves the problem."""

from collections.abc import Callable, Iterable

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.clock import is_past
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.interior.central_path import Path
from frictionbench.solvers.interior.point import Point, start_point
from frictionbench.solvers.interior.predictor_corrector import Best, new_workspace
from frictionbench.solvers.interior.system import System, build_system, in_velocities, space_of

POLISHABLE = 1e-5  # residual up to which polishing is tried: from there Newton's method mostly converges
ROUNDING = 4 * np.finfo(float).eps  # of the residual relative to the largest impulse: four roundings of a contact's terms
MARGIN = 0.5  # of tol: the same residual in other units, added up in another order
Phase = tuple[Callable[..., int], Point | Path, int]  # a method, the point or path on which to go on, and its factorisations
Measure = Callable[[FrictionProblem, Array], float]
Polish = Callable[[Array], Array]
Prepared = tuple[FrictionProblem, System]


class Phased:
    """The first two steps of an interior point method, for Coulomb's law or, relaxed, for its convex relaxation."""

    relaxed = False

    def form(self, problem: FrictionProblem) -> FrictionProblem:
        return in_velocities(problem)

    def setup(self, problem: FrictionProblem) -> Prepared:
        return problem, build_system(problem, self.relaxed)


def first_point(system: System) -> Point:
    """The first start: impulses between zero and the weight of all other contacts."""
    return start_point(system, float(np.sqrt(len(system.friction))), 1.0)


def run(
    prepared: Prepared,
    phases: Iterable[Phase],
    tol: float,
    limit: int,
    patience: int,
    measure: Measure,
    polish: Polish | None = None,
) -> Answer:
    """The third step, within limit factorisations; measure: the exact residual.

    phases: generated one by one, each after the previous one has failed.
    patience: iterations of the predictor-corrector without progress.
    polish: refines the best impulses (nc, d) of a phase where their residual is at most POLISHABLE.
    """
    problem, system = prepared
    sharp = tol / problem.spread  # of the largest unit, in which the system measures all contacts
    nothing = np.zeros_like(system.offset)
    if not _closing(problem, tol) and measure(problem, nothing) <= tol:  # contacts neither closing nor opening converge slowly
        return Answer(nothing, Status.SOLVED, {"iterations": 0, "factorisations": 0})
    space, workspace = space_of(system), new_workspace(system)
    best = Best(nothing, np.array([np.inf]), np.zeros(1, np.int64))
    history: list[float] = []
    status = Status.STALLED
    for method, point, share in phases:
        found = Best(np.zeros_like(nothing), np.array([np.inf]), best.factorisations)
        residuals = np.empty(min(share, limit - len(history)))
        used = method(system, space, point, workspace, found, MARGIN * sharp, patience, residuals)
        history += residuals[:used].tolist()
        solved = _is_solved(found, tol, sharp, system, problem, measure)
        if polish and not solved and found.residual[0] <= POLISHABLE:
            solved = _is_polished(found, tol, prepared, measure, polish)
        if found.residual[0] < best.residual[0]:
            best = found
        if solved:
            status = Status.SOLVED
            break
        if len(history) == limit or is_past(workspace.until):
            status = Status.WORK_LIMIT if len(history) == limit else Status.TIME_LIMIT
            break
    work = {"iterations": len(history), "factorisations": int(best.factorisations[0])}
    impulse = best.impulse * system.impulse
    # The first points are far inside the cones.
    if status is Status.TIME_LIMIT and measure(problem, impulse) > measure(problem, nothing):
        impulse = nothing
    return Answer(impulse, status, work, tuple(history))


def _closing(problem: FrictionProblem, tol: float) -> bool:
    """Whether a contact approaches in the free motion, faster than no impulses may leave it."""
    return bool((problem.q[:: problem.dimension] < -tol * problem.units).any())


def _is_solved(best: Best, tol: float, sharp: float, system: System, problem: FrictionProblem, measure: Measure) -> bool:
    """Whether the best residual is within sharp; within rounding of that, the exact residual within tol decides."""
    rounding = ROUNDING * np.max(system.weight * best.impulse[:, 0], initial=0.0)
    if best.residual[0] + rounding > sharp:
        best.residual[0] = measure(problem, best.impulse * system.impulse)
    return bool(best.residual[0] <= tol)


def _is_polished(best: Best, tol: float, prepared: Prepared, measure: Measure, polish: Polish) -> bool:
    """Whether the best impulses are solved once they are polished."""
    problem, system = prepared
    impulse = polish(best.impulse * system.impulse)
    found = measure(problem, impulse)
    if found < best.residual[0]:
        best.impulse[:], best.residual[0] = impulse / system.impulse, found
    return found <= tol
