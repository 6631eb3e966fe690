"""The driver of the interior point methods: phases, each with its own start, are run in turn until one solves the problem.

For packed problems only the first phase, the predictor-corrector from one start, is run, in a compiled loop. Problems that it
does not solve, and problems known only by W, are then solved one by one.
"""

from collections.abc import Callable, Iterable

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import loop, part
from frictionbench.problems.forms.delassus import pushed_contact_velocity
from frictionbench.problems.forms.islands import EPSILON
from frictionbench.problems.packed import CONTACT, Packed, Q, law_of, mass_of, mechanical, mechanics_of, residuals
from frictionbench.problems.residual import TOL_SHARE, largest_with_floor, residual
from frictionbench.solvers.clock import is_past
from frictionbench.solvers.interface import Answer, Solved, Status
from frictionbench.solvers.interior.central_path import Path
from frictionbench.solvers.interior.newton import last_step, new_work
from frictionbench.solvers.interior.point import Point, centred_point, start_pairs, start_point
from frictionbench.solvers.interior.predictor_corrector import Best, nothing_yet, predictor_corrector
from frictionbench.solvers.interior.system import System, build_system, space_of, system_of, units_of
from frictionbench.solvers.many import ALONE, impulses_of, is_alone, solved, unsolved

POLISHABLE = 1e-5  # residual up to which polishing is tried: from there Newton's method mostly converges
RESIDUAL_ROUNDING = 4 * EPSILON  # of the residual, relative to the largest impulse: four roundings of a contact's terms
SHARPER = 0.01  # factor of what is asked for after a phase that converged, but not for the exact residual
Phase = tuple[Callable[..., int], Point | Path, int]  # a method, where it starts, and its largest number of factorisations
Measure = Callable[[FrictionProblem, Array], float]
Polish = Callable[[Array], Array]
Prepared = tuple[FrictionProblem, System]

SOLVED, NEARLY = range(2)  # how a packed problem ends: solved, or the exact residual must decide
NO_DISTANCE = -1.0  # the distance for a packed problem without given impulses
work_of, nothing_of = part(new_work), part(nothing_yet)


class Phased:
    """The first two steps of an interior point method, for Coulomb's law or, relaxed, for its convex relaxation."""

    relaxed = False

    def form(self, problem: FrictionProblem) -> FrictionProblem:
        _ = problem.units, problem.scale, problem.mechanical or problem.blocks  # computes what build_system reads
        return problem

    def setup(self, problem: FrictionProblem) -> Prepared:
        return problem, build_system(problem, self.relaxed)


def first_point(system: System) -> Point:
    """The first start: impulses sqrt(nc) times those that stop a unit velocity, between the load of one contact and of all."""
    return start_point(system, float(np.sqrt(len(system.friction))), 1.0)


def one_start(problem: FrictionProblem, tol: float, limit: int, patience: int) -> Answer:
    """Mehrotra's predictor-corrector on Coulomb's law, from the first start only."""
    prepared = Phased().setup(problem)
    return run(prepared, [(predictor_corrector, first_point(prepared[1]), limit)], tol, limit, patience, residual)


def run(
    prepared: Prepared,
    phases: Iterable[Phase],
    tol: float,
    limit: int,
    patience: int,
    measure: Measure,
    polish: Polish | None = None,
) -> Answer:
    """The step solve, within limit factorisations; measure: the exact residual.

    phases: generated one by one, each after the previous one has failed.
    patience: iterations of the predictor-corrector without progress.
    polish: refines the best impulses (nc, d) of a phase where their residual is at most POLISHABLE.
    """
    problem, system = prepared
    sharp = tol / problem.spread  # relative to the largest unit, in which the system measures all contacts
    nothing = np.zeros_like(system.offset)
    closing = (problem.q[:: problem.dimension] < -tol * problem.units).any()
    if not closing and measure(problem, nothing) <= tol:  # contacts that do not move converge slowly
        return Answer(nothing, Status.SOLVED, {"iterations": 0, "factorisations": 0})
    space, workspace = space_of(system), new_work(system, last_step(system))
    best = nothing_yet(*nothing.shape)
    history: list[float] = []
    for method, point, share in phases:
        reached = nothing_yet(*nothing.shape)._replace(factorisations=best.factorisations)
        residuals = np.empty(min(share, limit - len(history)))
        used = method(system, space, point, workspace, reached, TOL_SHARE * sharp, patience, residuals)
        history += residuals[:used].tolist()
        converged = reached.residual[0] <= TOL_SHARE * sharp
        reached.residual[0] = measure(problem, reached.impulse * system.impulse)  # joints' defects may be larger at contacts
        solved = bool(reached.residual[0] <= tol)
        if polish and not solved and reached.residual[0] <= POLISHABLE:
            solved = _is_polished(reached, tol, prepared, measure, polish)
        if reached.residual[0] < best.residual[0]:
            best = reached
        if solved:
            status = Status.SOLVED
            break
        sharp *= SHARPER if converged else 1.0
        if len(history) == limit or is_past(workspace.until):
            status = Status.WORK_LIMIT if len(history) == limit else Status.TIME_LIMIT
            break
    else:
        status = Status.STALLED if np.isfinite(history).any() else Status.BREAKDOWN
    work = {"iterations": len(history), "factorisations": int(best.factorisations[0])}
    impulse = best.impulse * system.impulse
    # The first iterates are far inside the cones, where zero impulses may be the better answer.
    if status is Status.TIME_LIMIT and measure(problem, impulse) > measure(problem, nothing):
        impulse = nothing
    return Answer(impulse, status, work, tuple(history))


def _is_polished(best: Best, tol: float, prepared: Prepared, measure: Measure, polish: Polish) -> bool:
    """Polish the best impulses; return whether the result is within tol."""
    problem, system = prepared
    impulse = polish(best.impulse * system.impulse)
    error = measure(problem, impulse)
    if error < best.residual[0]:
        best.impulse[:], best.residual[0] = impulse / system.impulse, error
    return error <= tol


def first_phase(packed: Packed, guess: Array, distance: Array, tol: float, limit: int, patience: int) -> Solved:
    """The first phase of each packed problem, in at most limit factorisations.

    guess (contacts, d): the impulses to start around; distance (N,): of the start from the boundary, or NO_DISTANCE.
    """
    space = True if packed.dimension == 3 else None
    r, ended, work = _first_phases(packed, guess, distance, space, False, tol, limit, patience)
    if (ended == NEARLY).any():
        within = residuals(packed, r)[:, 0] <= tol
        ended[ended == NEARLY] = np.where(within, SOLVED, ALONE)[ended == NEARLY]
    return solved(r, ended, (Status.SOLVED,), work, ("iterations", "factorisations"))


@loop
def _first_phases(packed, guess, distance, space, relaxed, tol, limit, patience):  # type: ignore[no-untyped-def]
    """Solve packed problems in turn; return impulses, how each ended, and iterations and factorisations (N, 2)."""
    r, ended, work = unsolved(packed, 2)
    history, none, no_joints = np.empty(limit), np.zeros(1, np.int32), np.empty(0)
    for k in range(len(ended)):
        if is_alone(packed, k):
            continue
        mu, friction_bias, scale, velocities = law_of(packed, k)
        free_motion = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]].reshape(len(mu), r.shape[1])
        zero = np.zeros(free_motion.shape)
        if largest_with_floor(zero, free_motion, zero, scale, mu, friction_bias, velocities)[0] <= tol:
            ended[k] = SOLVED
            continue
        if not mechanical(packed, k):
            continue
        start, column, J, m_start, m_column, m_value, free, bias = mechanics_of(packed, k)
        offset, units = packed.offset[packed.first[k, CONTACT] : packed.first[k + 1, CONTACT]], units_of(velocities, scale)
        mass_start, mass_column, mass_value = mass_of(packed, k)
        motion = free, mass_start, mass_column, mass_value, m_start, m_column, m_value
        laws = mu, friction_bias, scale, offset
        system = system_of((start, column, J, J), laws, motion, (none, none[:0], no_joints, free[:0]), units, relaxed)
        if distance[k] == NO_DISTANCE:
            x, s = start_pairs(system.weight, system.pairs, space, np.sqrt(len(mu)), 1.0)
            point = Point(x, s, np.zeros((0, 1)))
        else:
            guessed = impulses_of(packed, k, guess)
            u = pushed_contact_velocity(start, column, J, m_start, m_column, m_value, free, guessed, bias)
            point = centred_point(system, space, guessed, u, distance[k])
        best, sharp = nothing_of(len(mu), r.shape[1]), tol / packed.spread[k]
        work[k, 0] = predictor_corrector(
            system, space, point, work_of(system, np.inf), best, TOL_SHARE * sharp, patience, history
        )
        work[k, 1] = best.factorisations[0]
        impulse, heaviest = impulses_of(packed, k, r), 0.0
        for i in range(len(impulse)):
            heaviest = max(heaviest, system.weight[i] * best.impulse[i, 0])
            for a in range(impulse.shape[1]):
                impulse[i, a] = best.impulse[i, a] * units.impulse
        ended[k] = SOLVED if best.residual[0] + RESIDUAL_ROUNDING * heaviest <= sharp else NEARLY
    return r, ended, work
