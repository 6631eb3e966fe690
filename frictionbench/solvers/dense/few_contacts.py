"""Problems of few contacts in space, including rows of joints: form, solution and residual in one compiled call.

A step of a robot has some tens of rows, of contacts, limits and dry friction, and a mass matrix that couples all velocities.
Its Delassus matrix is dense and cheap (solvers.dense.rows) if it is not given, and most of the time is overhead. A few
sweeps of Gauss-Seidel find most of the active set: which contacts are open, closed, sticking or sliding. Newton's method
converges quadratically from there (solvers.dense.newton). If contacts are redundant, full Newton steps cycle among active sets.
A step that does not reduce the residual is then shortened to end just past the first change of a contact's state, from where
the next step starts. If this stalls, more sweeps and a larger shift follow. Problems that remain unsolved are left to other
methods.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, loop, part
from frictionbench.problems.forms.delassus import known_measures, write_contact_velocity, write_velocity
from frictionbench.problems.forms.held import hold, hold_rounding, joint_inverse
from frictionbench.problems.packed import Packed, Q, known_blocks, law_of, mechanical, mechanics_of
from frictionbench.problems.residual import TOL_SHARE, known_with_floor, largest_with_floor
from frictionbench.problems.rows import Index64
from frictionbench.solvers.dense.newton import measure, new_work, newton_step, past_first_change, sweep
from frictionbench.solvers.dense.rows import dense_rows, known_rows
from frictionbench.solvers.interface import impulses
from frictionbench.solvers.many import impulses_of

ROWS = 120  # the largest number of contact rows, normal and tangential: a step then takes some tenths of a millisecond
JOINED_ROWS = 360  # of contact rows and joint equations together, where it takes half the time of an interior point
# Bodies without joints: above SMALL_ROWS, Newton's method is used only if the rows do not exceed HYPERSTATIC times the
# velocities. Otherwise W is singular, and other methods are faster. A problem known by W counts as one with 3 nc velocities.
SMALL_ROWS, HYPERSTATIC = 36, 1.25
COUPLED = 6  # entries of M^-1 for each velocity, on average, above which bodies count as coupled, as by joints
SWEEPS, MORE_SWEEPS, MOST_SWEEPS = 5, 50, 100  # before the first step, before the first careful one, and when those stall
# The numbers of full and of careful steps. Of 241 steps of robots that six full Newton steps leave unsolved, careful ones solve
# 240, within 6 in the median.
FULL_STEPS, CAREFUL_STEPS = 6, 54
FREE_BODY_STEPS = 20  # both together, for bodies without joints: with six only, problems of singular W take 1.4 times as long
LARGEST_LEFT = 0.9  # a careful step is shortened if it leaves more than this share of the residual
PATIENCE, BETTER = 16, 0.9  # the number of steps within which the residual must fall to this share
FULL_SHIFT, CAREFUL_SHIFT = 1e-3, 0.05  # the shift of full steps and of careful ones, relative to the residual
SHIFT_GROWTH = 3.0  # the factor of the shift when careful steps stall
LEAST_SHIFT = 1e-12  # the least shift, for redundant rows when the residual is near rounding


def few_steps(problem: FrictionProblem) -> int:
    """The largest number of Newton steps for a problem; 0 if the method does not take it: it has many contacts or is planar."""
    rows, nv = problem.contacts + 2 * np.count_nonzero(problem.friction), len(problem.free_velocity)
    entries, nj = len(problem.inverse_rows.value), len(problem.joint_bias)
    return int(most_steps(rows, nv, entries, nj)) if problem.dimension == 3 else 0


@kernel
def most_steps(rows, nv, entries, nj):  # type: ignore[no-untyped-def]
    """The largest number of Newton steps for a problem; 0 if the method does not take it. entries: of M^-1."""
    if rows == 0 or rows > ROWS or rows + nj > JOINED_ROWS:
        return 0
    if nj > 0 or entries > COUPLED * nv:
        return FULL_STEPS + CAREFUL_STEPS
    return FREE_BODY_STEPS if rows <= SMALL_ROWS or rows <= HYPERSTATIC * nv else 0


def few_contacts(
    problem: FrictionProblem, tol: float, steps: int | None, start: Array | None
) -> tuple[Array, float, float, dict[str, int]]:
    """The impulses (nc, 3), their residual and its floor, and the counts of work. steps: their largest number."""
    r = impulses(start, (problem.contacts, 3))
    law = problem.friction, problem.friction_bias, r, tol, steps or 0
    if problem.mechanical:
        rows = *problem.contact_rows, *problem.inverse_rows, *problem.joint_rows, problem.joint_bias
        error, floor, sweeps, taken = _solve(*rows, problem.free_velocity, problem.bias, *law)
    else:
        error, floor, sweeps, taken = _solve_known(*problem.blocks, problem.q, *law)
    return r, error, floor, {"sweeps": sweeps, "steps": taken}


@loop
def few_each(packed):  # type: ignore[no-untyped-def]
    """few_steps of each of the packed problems, which have no joints (N,)."""
    steps = np.zeros(len(packed.first) - 1, np.int64)
    for k in range(len(steps)):
        if packed.J.shape[1] == 3:
            mu, _, _, _ = law_of(packed, k)
            _, _, _, _, _, m_value, free, _ = mechanics_of(packed, k)
            nv, entries = (len(free), len(m_value)) if mechanical(packed, k) else (3 * len(mu), 3 * len(mu))
            steps[k] = most_steps(len(mu) + 2 * np.count_nonzero(mu), nv, entries, 0)
    return steps


def few_contacts_each(
    packed: Packed, steps: Index64, tol: float, limit: int | None, start: Array | None
) -> tuple[Array, Index64]:
    """The impulses of all contacts of the packed problems with steps (N,) > 0, and the sweeps and steps of each (N, 2)."""
    r = impulses(start, (int(packed.contacts[-1]), 3))
    return r, _each(packed, steps if limit is None else np.minimum(steps, limit), r, tol)


@loop
def _each(packed, most, r, tol):  # type: ignore[no-untyped-def]
    """Overwrite r (contacts, 3) with the impulses; return the sweeps and steps (N, 2)."""
    work = np.zeros((len(most), 2), np.int64)
    none, nothing = np.zeros(1, np.int32), np.zeros(0)
    for k in range(len(most)):
        if not most[k]:
            continue
        (mu, b_f, _, _), impulse = law_of(packed, k), impulses_of(packed, k, r)
        if mechanical(packed, k):
            start, column, J, m_start, m_column, m_value, free, bias = mechanics_of(packed, k)
            _, _, work[k, 0], work[k, 1] = _solve(
                start, column, J, m_start, m_column, m_value, none, none[:0], nothing, nothing, free, bias, mu, b_f, impulse,
                tol, most[k],
            )  # fmt: skip
        else:
            first, neighbours, block = known_blocks(packed, k)
            q = packed.q[packed.first[k, Q] : packed.first[k + 1, Q]]
            _, _, work[k, 0], work[k, 1] = _solve_known(first, neighbours, block, q, mu, b_f, impulse, tol, most[k])
    return work


@kernel
def _solve(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, f_start, f_column, F, b_F, free, bias, mu, b_f, r, tol, turns
):
    """Overwrite r with the impulses; return the residual, its floor, the sweeps and the steps.

    V is J M^-1 J' minus the joints' part and may have lost digits. If the residual computed from velocities exceeds tol, the
    velocities of the rows are corrected, and the remaining steps follow.
    """
    bodies, joints = (start, column, J, m_start, m_column, m_value), (f_start, f_column, F, b_F)
    inverse = joint_inverse(f_start, f_column, F, m_start, m_column, m_value)
    rows = dense_rows(bodies, joints, inverse, free, bias, mu, b_f)
    work, sweeps, steps, worst, floor = new_work(len(rows.V), len(r)), 0, 0, 0.0, 0.0
    for most in (turns - FULL_STEPS if len(b_F) and turns > FULL_STEPS else turns, turns):
        swept, stepped = _iterate(rows, r, work, TOL_SHARE * tol, most - steps)
        sweeps, steps = sweeps + swept, steps + stepped
        worst, floor, u = _residual(bodies, joints, inverse, free, bias, rows, r)
        if worst <= tol or steps == turns:
            break
        measure(rows, r, work)
        for i in range(len(r)):
            for a in range(3):
                if rows.row[i, a] >= 0:
                    rows.rest[rows.row[i, a]] += u[i, a] - work.w[rows.row[i, a]]
    return worst, floor, sweeps, steps


@kernel
def _solve_known(first, neighbours, block, q, mu, b_f, r, tol, turns):  # type: ignore[no-untyped-def]
    """`_solve` for a problem of which only W and q are known."""
    (scale, units, _), by_contact = known_measures(first, neighbours, block, q, b_f, np.zeros(0)), q.reshape(r.shape)
    rows = known_rows(first, neighbours, block, by_contact, mu, b_f, scale, units)
    sweeps, steps = _iterate(rows, r, new_work(len(rows.V), len(r)), TOL_SHARE * tol, turns)
    worst, floor = known_with_floor(first, neighbours, block, r, by_contact, scale, mu, b_f, units)
    return worst, floor, sweeps, steps


@part
def _iterate(rows, r, work, tol, turns):  # type: ignore[no-untyped-def]
    """Overwrite r with the best impulses found; return the sweeps and steps."""
    for i in range(len(r)):
        for a in range(3):
            if rows.row[i, a] < 0:
                r[i, a] = 0.0
    best, old = r.copy(), r.copy()
    error = least = measure(rows, r, work)
    sweeps = steps = stalled = 0
    shift = FULL_SHIFT
    while least > tol:
        if steps in (0, FULL_STEPS) or stalled == PATIENCE:
            times = SWEEPS
            if stalled == PATIENCE:
                times, shift, stalled = MOST_SWEEPS, SHIFT_GROWTH * shift, 0
            elif steps:
                times, shift, stalled = MORE_SWEEPS, CAREFUL_SHIFT, 0
                r[:] = best
                measure(rows, r, work)
            sweep(rows, r, work, times)
            sweeps += times
            error = measure(rows, r, work)
            if error < least:
                least, best[:] = error, r
        old[:], before = r, error
        if least <= tol or steps == turns or not newton_step(rows, r, work, max(LEAST_SHIFT, shift * min(error, 1.0))):
            break
        steps += 1
        error = measure(rows, r, work)
        if steps > FULL_STEPS and error > LARGEST_LEFT * before:
            past_first_change(rows, r, old, work)
            error = measure(rows, r, work)
        stalled = 0 if error < BETTER * least else stalled + 1
        if error < least:
            least, best[:] = error, r
    r[:] = best
    return sweeps, steps


@part
def _residual(bodies, joints, inverse, free, bias, rows, r):  # type: ignore[no-untyped-def]
    """The residual and its floor as in problems.residual, from velocities without W, and the velocities (nc, 3)."""
    start, column, J, m_start, m_column, m_value = bodies
    f_start, f_column, F, b_F = joints
    momentum, v, terms = np.empty(len(free)), np.empty(len(free)), np.empty(len(free))
    write_velocity(start, column, J, m_start, m_column, m_value, free, r, False, momentum, v)
    write_velocity(start, column, J, m_start, m_column, m_value, free, r, True, momentum, terms)
    if len(b_F):
        held = hold(f_start, f_column, F, b_F, inverse[0], inverse[1], v)
        terms += hold_rounding(f_start, f_column, F, b_F, inverse[0], inverse[1], v, held)
        v = held
    u, size = np.empty(r.shape), np.empty(r.shape)
    write_contact_velocity(start, column, J, v, bias, False, u)
    write_contact_velocity(start, column, J, terms, bias, True, size)
    for i in range(len(r)):
        for a in range(3):
            if rows.locked[i, a]:
                u[i, a] = rows.q[i, a]
    worst, floor = largest_with_floor(r, u, size, rows.scale, rows.friction, rows.friction_bias, rows.units)
    return worst, floor, u
