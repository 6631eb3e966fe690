"""Proximal points of Coulomb's law in space, each found by Newton's method.

The proximal point of an anchor a solves the contact problem with u + rho s (r - a) in place of u, where s are the contacts'
scales: as if every contact were slightly compliant, and unloaded at a. However redundant the contacts are, its impulses are
isolated, and for large rho it separates into one small problem for each contact, which Newton's method solves in a few steps.
Then a moves to the solution and rho is halved. If Newton's method fails, it restarts from a with rho five times larger:

    a <- r,  rho <- rho / 2      where |s F| fell below a hundredth of the residual,         otherwise    rho <- 5 rho.

For a warm start, rho is at first the residual of the start, as in Levenberg and Marquardt's method near solutions that are not
isolated: a larger rho only slows convergence there.

Newton's method is applied to Alart and Curnier's equations. With w = u + rho s (r - a), x = r - k w and k = 1 / ((1 + rho) s)
for each contact,

    F_n = r_n - (x_n)_+,        F_t = r_t - P_B(x_t),      B the disc of radius mu (x_n)_+ + b_f,

vanish exactly where r obeys Coulomb's law with w in place of u. F is piecewise smooth, with the derivative A dr + B dw. With
G = (A + rho s B)^-1, a Newton step is, contact by contact,

    dr = -G (F + B du),        (M + J'G B J) dv = -J'G F,        du = J dv:

with the matrix of solvers.interior.newton but other blocks for the contacts. A has rank 3 at an open contact and is zero at a
sticking one; rho > 0 makes G exist, for any number of contacts on a body. Impulses of joints are further unknowns, their
defects F v + b_F further equations, with the same block 1/delta for each joint as there. A step is halved until the norm |s F|
of all equations falls.

A stationary anchor is a Coulomb solution, for every rho. For a monotone problem the anchors converge; Coulomb's law is not
monotone, so they need not. The method solves problems that trap interior points: large friction, and contacts in random
directions.

References: Rockafellar 1976; Alart and Curnier 1991; Yamashita and Fukushima 2001; Acary, Brémond and Huber 2018, sections 4.2
and 4.4.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel, lean
from frictionbench.problems.residual import residual
from frictionbench.solvers.clock import is_past, late
from frictionbench.solvers.interface import Answer, Status, impulses, solver
from frictionbench.solvers.interior.newton import (
    NEWTON_PIVOT,
    Work,
    accelerate,
    add_stiffness,
    clear,
    joint_step,
    last_step,
    new_work,
    pull_joints,
    push,
    push_joints,
    read,
    read_joints,
)
from frictionbench.solvers.interior.phases import Phased
from frictionbench.solvers.interior.point import Vector
from frictionbench.solvers.interior.system import System
from frictionbench.solvers.sparse_lu.multifrontal import factorise, solve_factorised

LIMIT = 1500  # factorisations by default: most problems that are solved take less than 500
STEPS = 20  # Newton steps for one proximal point: the method converges within a few, or not at all
ENOUGH = 1e-2  # |s F| that suffices for a proximal point, relative to the least residual so far in the smallest unit
ACCURATE = 1e-11  # |s F| that always suffices, relative to the largest free velocity: near what rounding leaves
FIRST_RHO, RHO_GROWTH, RHO_DECAY = 1.0, 5.0, 0.5  # the first rho, and its factors after a failure and after a success
LEAST_RHO = 1e-8  # the smallest rho: below it, G is singular to working accuracy
HALVINGS = 8  # lengths tried for a step, each half the last: if none decreases |s F| enough, the shortest is taken nevertheless
DECREASE = 1e-4  # share of the predicted decrease of |s F| that a step must reach (the usual Armijo constant)


@solver("proximal_newton", family="newton", model="coulomb", dimension=(3,), warm_start=True)
class ProximalNewton(Phased):
    """Proximal points found by Newton's method on Alart and Curnier's equations, sparse in the velocities.

    Work: factorisations, and anchors tried. History: the residual after each anchor.
    """

    def solve(
        self, prepared: tuple[FrictionProblem, System], tol: float, limit: int | None, start: Array | None = None
    ) -> Answer:
        """limit bounds the factorisations, 1500 by default."""
        problem, system = prepared
        limit = LIMIT if limit is None else limit
        nc, work = problem.contacts, new_work(system, last_step(system))
        anchor = impulses(start, (nc, 3)) / system.impulse
        state = new_state(system)
        state.r[:] = anchor
        impulse = anchor * system.impulse
        least = residual(problem, impulse)
        history, factorisations, rho = [least], 0, FIRST_RHO if start is None else min(FIRST_RHO, least)
        while least > tol and factorisations < limit and not is_past(work.until):
            steps = min(STEPS, limit - factorisations)
            aim = max(ACCURATE / 100, ENOUGH / 10 * min(least, 1.0) / problem.spread)
            used, off = newton(system, state, anchor, rho, work, aim, steps)
            factorisations += used
            if not used:
                break  # |s F| is zero up to rounding, the residual is not
            error = residual(problem, state.r * system.impulse)
            history.append(error)
            if error < least:
                impulse, least = state.r * system.impulse, error
            if off < max(ENOUGH * least / problem.spread, ACCURATE):
                anchor[:] = state.r
                rho = max(RHO_DECAY * rho, LEAST_RHO)
            else:
                state.r[:] = anchor
                rho *= RHO_GROWTH
        spent = {"factorisations": factorisations, "anchors": len(history) - 1}
        if least <= tol:
            return Answer(impulse, Status.SOLVED, spent, tuple(history))
        status = Status.WORK_LIMIT if factorisations == limit else Status.TIME_LIMIT if is_past(work.until) else Status.STALLED
        return Answer(impulse, status, spent, tuple(history))


class State(NamedTuple):
    """Impulses r, velocities u and equations F (nc, 3), impulses of the joints and their defects F v + b_F (nj, 1)."""

    r: Array
    u: Array
    F: Array
    joint: Array
    drift: Array


@kernel
def new_state(system: System) -> State:
    contacts, joints = np.zeros((3, len(system.friction), 3)), np.zeros((2, len(system.joint_bias), 1))
    return State(contacts[0], contacts[1], contacts[2], joints[0], joints[1])


@lean
def _pair(system: System, i: int, state: State, anchor: Array, rho: float) -> Vector:
    """x = r - k w."""
    r, u, s = state.r, state.u, system.weight[i]
    share, k = rho / (1 + rho), 1 / ((1 + rho) * s)
    x0 = r[i, 0] - k * u[i, 0] - share * (r[i, 0] - anchor[i, 0])
    x1 = r[i, 1] - k * u[i, 1] - share * (r[i, 1] - anchor[i, 1])
    x2 = r[i, 2] - k * u[i, 2] - share * (r[i, 2] - anchor[i, 2])
    return x0, x1, x2


@lean
def equations(system: System, state: State, anchor: Array, rho: float, work: Work) -> float:
    """Compute u, F and the joints' drift from the impulses; return |s F|."""
    for k in range(len(work.momentum)):
        work.momentum[k] = 0.0
    for i in range(len(state.r)):
        push(system.contacts, True, i, (state.r[i, 0], state.r[i, 1], state.r[i, 2]), work.momentum)
    push_joints(system.joints, state.joint, work.momentum)
    accelerate(system, work.momentum, work.vector)
    for i in range(len(state.r)):
        state.u[i, 0], state.u[i, 1], state.u[i, 2] = read(system.contacts, True, i, work.vector)
        for k in range(3):
            state.u[i, k] += system.offset[i, k]
    read_joints(system.joints, work.vector, state.drift)
    for j in range(len(state.drift)):
        state.drift[j, 0] += system.joint_bias[j]
    total = 0.0
    for i in range(len(state.r)):
        x0, x1, x2 = _pair(system, i, state, anchor, rho)
        size, normal = np.sqrt(x1 * x1 + x2 * x2), max(x0, 0.0)
        radius = system.friction[i] * normal + system.friction_bias[i]
        ratio = 1.0 if size <= radius else radius / size
        state.F[i, 0] = state.r[i, 0] - normal
        state.F[i, 1] = state.r[i, 1] - ratio * x1
        state.F[i, 2] = state.r[i, 2] - ratio * x2
        for k in range(3):
            total += (system.weight[i] * state.F[i, k]) ** 2
    for j in range(len(state.drift)):
        total += state.drift[j, 0] ** 2
    return float(np.sqrt(total))


@inlined
def _impulse_change(system: System, i: int, state: State, anchor: Array, rho: float, F: Vector, du: Vector) -> Vector:
    """-G (F + B du): the change of r for a change du of u and the defect F of the equations."""
    s, mu = system.weight[i], system.friction[i]
    k = 1 / ((1 + rho) * s)
    share = rho / (1 + rho)  # rho s k, which the proximal term adds where B = k
    x0, x1, x2 = _pair(system, i, state, anchor, rho)
    size = np.sqrt(x1 * x1 + x2 * x2)
    radius = mu * max(x0, 0.0) + system.friction_bias[i]
    r0 = -(F[0] + k * du[0]) / share if x0 > 0 else -F[0]
    if radius > 0 and size <= radius:
        return r0, -(F[1] + k * du[1]) / share, -(F[2] + k * du[2]) / share
    d1, d2, ratio = 0.0, 0.0, 0.0
    if size > 0:
        d1, d2, ratio = x1 / size, x2 / size, radius / size
    # across d: (1 - ratio) dr + ratio k (du + rho s dr); along d: dr = mu (dx_0), dx_0 = (1 - share) dr_0 - k du_0
    grow = mu * ((1 - share) * r0 - k * du[0]) if x0 > 0 else 0.0
    across = F[2] * d1 - F[1] * d2 + ratio * k * (du[2] * d1 - du[1] * d2)
    along = grow - F[1] * d1 - F[2] * d2
    turn = -across / (1 - ratio + ratio * share)
    return r0, along * d1 - turn * d2, along * d2 + turn * d1


@lean
def newton_step(system: System, state: State, anchor: Array, rho: float, step: Array, work: Work) -> None:
    """Overwrite step (nc, 3) with dr, and work.step.joint with the change of the joints' impulses; one factorisation."""
    dv = work.vector
    clear(system, work.storage)
    for k in range(len(dv)):
        dv[k] = 0.0
    none = (0.0, 0.0, 0.0)
    for i in range(len(step)):
        F = (state.F[i, 0], state.F[i, 1], state.F[i, 2])
        c0 = _impulse_change(system, i, state, anchor, rho, none, (-1.0, 0.0, 0.0))
        c1 = _impulse_change(system, i, state, anchor, rho, none, (0.0, -1.0, 0.0))
        c2 = _impulse_change(system, i, state, anchor, rho, none, (0.0, 0.0, -1.0))
        n, s, t = (c0[0], c1[0], c2[0]), (c0[1], c1[1], c2[1]), (c0[2], c1[2], c2[2])
        add_stiffness(system, True, i, n, s, t, work.storage)
        push(system.contacts, True, i, _impulse_change(system, i, state, anchor, rho, F, none), dv)
    pull_joints(system, state.drift, work.step.joint, dv)
    factorise(system.fronts, work.storage, work.swap, NEWTON_PIVOT)
    solve_factorised(system.fronts, work.storage, work.swap, dv)
    for i in range(len(step)):
        F = (state.F[i, 0], state.F[i, 1], state.F[i, 2])
        du = read(system.contacts, True, i, dv)
        step[i, 0], step[i, 1], step[i, 2] = _impulse_change(system, i, state, anchor, rho, F, du)
    joint_step(system, state.drift, dv, work.step.joint)


@kernel
def newton(system: System, state: State, anchor: Array, rho: float, work: Work, tol: float, limit: int) -> tuple[int, float]:
    """Newton's method from state.r, which is overwritten, until |s F| <= tol, for at most limit steps, the last begun before
    work.until. Returns the number of steps and |s F|."""
    step, trial = np.zeros(state.r.shape), new_state(system)
    size = equations(system, state, anchor, rho, work)
    for used in range(limit):
        if not tol < size < np.inf or late(work.until):
            return used, size
        newton_step(system, state, anchor, rho, step, work)
        length = 1.0
        for _ in range(HALVINGS):
            for i in range(len(step)):
                for k in range(3):
                    trial.r[i, k] = state.r[i, k] + length * step[i, k]
            for j in range(len(state.joint)):
                trial.joint[j, 0] = state.joint[j, 0] + length * work.step.joint[j, 0]
            ahead = equations(system, trial, anchor, rho, work)
            if ahead < (1 - DECREASE * length) * size:
                break
            length /= 2
        size = ahead
        for i in range(len(step)):
            for k in range(3):
                state.r[i, k], state.u[i, k], state.F[i, k] = trial.r[i, k], trial.u[i, k], trial.F[i, k]
        for j in range(len(state.joint)):
            state.joint[j, 0], state.drift[j, 0] = trial.joint[j, 0], trial.drift[j, 0]
    return limit, size
