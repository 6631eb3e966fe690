"""The first phase of the interior point for many packed problems: the predictor-corrector from one start, in a compiled loop.

The start is the centred point around given impulses, or where there are none the first one of all problems, as in
solvers.interior_point. What this phase does not solve, and problems of which only W is known, are left to be solved alone.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import loop, part
from frictionbench.problems.forms.delassus import pushed_contact_velocity
from frictionbench.problems.packed import CONTACT, Packed, Q, law_of, mass_of, mechanical, mechanics_of, residuals
from frictionbench.problems.residual import largest_with_floor
from frictionbench.solvers.interface import Solved, Status
from frictionbench.solvers.interior.centred_point import centred_point
from frictionbench.solvers.interior.phases import MARGIN, ROUNDING
from frictionbench.solvers.interior.point import Point, start_pairs
from frictionbench.solvers.interior.predictor_corrector import Best, predictor_corrector, workspace_around
from frictionbench.solvers.interior.system import new_work, system_of, units_of
from frictionbench.solvers.loops import ALONE, impulses_of, is_alone, solved, unsolved

SOLVED, NEARLY = range(2)  # how a problem ends: solved, or to be judged by the exact residual
NO_GUESS = -1.0  # the distance of a problem without given impulses

work_of, workspace_of = part(new_work), part(workspace_around)


def first_phase(packed: Packed, guess: Array, distance: Array, tol: float, limit: int, patience: int) -> Solved:
    """Solve each problem in at most limit factorisations.

    guess (contacts, d): the impulses to start around; distance (N,): how far from the boundary, or NO_GUESS.
    """
    space = True if packed.dimension == 3 else None
    r, ended, work = first_phase_loop(packed, guess, distance, space, False, tol, limit, patience)
    if (ended == NEARLY).any():
        within = residuals(packed, r)[:, 0] <= tol
        ended[ended == NEARLY] = np.where(within, SOLVED, ALONE)[ended == NEARLY]
    return solved(r, ended, (Status.SOLVED,), work, ("iterations", "factorisations"))


@loop
def first_phase_loop(packed, guess, distance, space, relaxed, tol, limit, patience):  # type: ignore[no-untyped-def]
    """Packed problems one after the other: impulses, how each ended, and iterations and factorisations (N, 2)."""
    r, ended, work = unsolved(packed, 2)
    history, none, no_joints = np.empty(limit), np.zeros(1, np.int32), np.empty(0)
    for k in range(len(ended)):
        if is_alone(packed, k):
            continue
        mu, wider, scale, units = law_of(packed, k)
        free_motion = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]].reshape(len(mu), r.shape[1])
        zero = np.zeros(free_motion.shape)
        if largest_with_floor(zero, free_motion, zero, scale, mu, wider, units)[0] <= tol:
            ended[k] = SOLVED
            continue
        if not mechanical(packed, k):
            continue
        start, column, J, m_start, m_column, m_value, free, bias = mechanics_of(packed, k)
        mass_start, mass_column, mass_value = mass_of(packed, k)
        offset = packed.offset[packed.first[k, CONTACT] : packed.first[k + 1, CONTACT]]
        speed, impulse = units_of(units, scale)
        system = system_of(
            start, column, J, J, none, none[:0], no_joints, mass_start, mass_column, mass_value, m_start, m_column, m_value,
            mu, wider, scale, offset, free, free[:0], impulse / speed, speed / impulse, relaxed, speed, impulse,
        )  # fmt: skip
        if distance[k] == NO_GUESS:
            x, s = start_pairs(system.weight, system.pairs, space, np.sqrt(len(mu)), 1.0)
            point = Point(x, s, np.zeros((0, 1)))
        else:
            given = impulses_of(packed, k, guess)
            u = pushed_contact_velocity(start, column, J, m_start, m_column, m_value, free, given, bias)
            point = centred_point(system, space, given, u, distance[k])
        best = Best(np.zeros(offset.shape), np.full(1, np.inf), np.zeros(1, np.int64))
        workspace = workspace_of(work_of(system), len(mu), 0, np.inf)
        sharp = tol / packed.spread[k]
        work[k, 0] = predictor_corrector(system, space, point, workspace, best, MARGIN * sharp, patience, history)
        work[k, 1] = best.factorisations[0]
        own, heaviest = impulses_of(packed, k, r), 0.0
        for i in range(len(own)):
            heaviest = max(heaviest, system.weight[i] * best.impulse[i, 0])
            for a in range(own.shape[1]):
                own[i, a] = best.impulse[i, a] * impulse
        ended[k] = SOLVED if best.residual[0] + ROUNDING * heaviest <= sharp else NEARLY
    return r, ended, work
