"""Newton's method on Alart and Curnier's equations of a spatial contact problem with a proximal term.

With the velocity w = u + rho s (r - a) that the anchor a makes of a contact's u, and the pair x = r - w / k, k = (1 + rho) s,

    F_n = r_n - (x_n)_+,        F_t = r_t - P_B(x_t),      B the disc of radius mu (x_n)_+ + b_f,

vanish exactly where r obeys Coulomb's law with w in place of u. F is piecewise smooth. Where A dr + B dw is its derivative, a
Newton step is, contact by contact, with G = (A + rho s B)^-1,

    dr = -G (F + B du),        (M + J'G B J) dv = -J'G F,        du = J dv:

the matrix of solvers.interior.newton with another block for every contact. A has rank 3 at an open contact and none at one that
sticks; rho > 0 makes G exist, for any number of contacts on a body. A step is halved until |s F| falls.

References: Alart and Curnier 1991; Acary, Brémond and Huber 2018, sections 4.2 and 4.4.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel, part
from frictionbench.solvers.clock import late
from frictionbench.solvers.interior.elements import add_spatial, push_spatial, read_spatial
from frictionbench.solvers.interior.lorentz import Vector
from frictionbench.solvers.interior.newton import PIVOT
from frictionbench.solvers.interior.system import System, Work
from frictionbench.solvers.sparse_lu.multifrontal import factorise, solve_factorised

HALVINGS = 8  # of a step: if a 256th does not decrease |s F|, the step is taken nevertheless and the anchor restarts
DECREASE = 1e-4  # share of the predicted decrease of |s F| that a step must reach (the usual Armijo constant)


class State(NamedTuple):
    """Impulses r, velocities u and equations F (nc, 3), for r as it is or after a step."""

    r: Array
    u: Array
    F: Array


@kernel
def new_state(contacts: int) -> State:
    return State(np.zeros((contacts, 3)), np.zeros((contacts, 3)), np.zeros((contacts, 3)))


@part
def velocities(system: System, r: Array, u: Array, work: Work) -> None:
    """Overwrite u by the contact velocities after the impulses r."""
    v = work.vector
    for i in range(len(v)):
        work.momentum[i] = 0.0
    for i in range(len(r)):
        push_spatial(system.contacts, i, (r[i, 0], r[i, 1], r[i, 2]), work.momentum)
    for i in range(len(v)):
        v[i] = system.free_velocity[i]
        for k in range(system.indptr[i], system.indptr[i + 1]):
            v[i] += system.inverse[k] * work.momentum[system.indices[k]]
    for i in range(len(u)):
        u[i, 0], u[i, 1], u[i, 2] = read_spatial(system.contacts, i, v)
        for k in range(3):
            u[i, k] += system.offset[i, k]


@part
def _pair(system: System, i: int, state: State, anchor: Array, rho: float) -> Vector:
    """x = r - w / k."""
    r, u, s = state.r, state.u, system.weight[i]
    share, k = rho / (1 + rho), 1 / ((1 + rho) * s)
    x0 = r[i, 0] - k * u[i, 0] - share * (r[i, 0] - anchor[i, 0])
    x1 = r[i, 1] - k * u[i, 1] - share * (r[i, 1] - anchor[i, 1])
    x2 = r[i, 2] - k * u[i, 2] - share * (r[i, 2] - anchor[i, 2])
    return x0, x1, x2


@part
def equations(system: System, state: State, anchor: Array, rho: float, work: Work) -> float:
    """Overwrite u and F for the impulses r; |s F|."""
    velocities(system, state.r, state.u, work)
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
    return float(np.sqrt(total))


@inlined
def _impulse_change(system: System, i: int, state: State, anchor: Array, rho: float, F: Vector, du: Vector) -> Vector:
    """-G (F + B du): the change of r for a change du of u, and the equations' defect F."""
    s, mu = system.weight[i], system.friction[i]
    k = 1 / ((1 + rho) * s)
    share = rho / (1 + rho)  # rho s k: what the proximal term adds where B is k
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


@part
def newton_step(system: System, state: State, anchor: Array, rho: float, step: Array, work: Work) -> None:
    """Overwrite step (nc, 3) by dr; one factorisation."""
    storage, dv = work.storage, work.vector
    for k in range(len(storage)):
        storage[k] = 0.0
    for k in range(len(system.slot)):
        storage[system.slot[k]] += system.constant[k]
    for k in range(len(dv)):
        dv[k] = 0.0
    none = (0.0, 0.0, 0.0)
    for i in range(len(step)):
        F = (state.F[i, 0], state.F[i, 1], state.F[i, 2])
        c0 = _impulse_change(system, i, state, anchor, rho, none, (-1.0, 0.0, 0.0))
        c1 = _impulse_change(system, i, state, anchor, rho, none, (0.0, -1.0, 0.0))
        c2 = _impulse_change(system, i, state, anchor, rho, none, (0.0, 0.0, -1.0))
        rows = ((c0[0], c1[0], c2[0]), (c0[1], c1[1], c2[1]), (c0[2], c1[2], c2[2]))
        add_spatial(system.contacts, i, rows[0], rows[1], rows[2], system.fronts, storage)
        push_spatial(system.contacts, i, _impulse_change(system, i, state, anchor, rho, F, none), dv)
    factorise(system.fronts, storage, work.swap, PIVOT)
    solve_factorised(system.fronts, storage, work.swap, dv)
    for i in range(len(step)):
        F = (state.F[i, 0], state.F[i, 1], state.F[i, 2])
        du = read_spatial(system.contacts, i, dv)
        step[i, 0], step[i, 1], step[i, 2] = _impulse_change(system, i, state, anchor, rho, F, du)


@kernel
def newton(
    system: System,
    state: State,
    trial: State,
    anchor: Array,
    rho: float,
    step: Array,
    work: Work,
    tol: float,
    limit: int,
    until: float,
) -> tuple[int, float]:
    """Newton's method from state.r, which is overwritten, to |s F| <= tol in at most limit steps, the last begun before
    `until`; the steps and |s F|."""
    size = equations(system, state, anchor, rho, work)
    for used in range(limit):
        if not tol < size < np.inf or late(until):
            return used, size
        newton_step(system, state, anchor, rho, step, work)
        length = 1.0
        for _ in range(HALVINGS):
            for i in range(len(step)):
                for k in range(3):
                    trial.r[i, k] = state.r[i, k] + length * step[i, k]
            ahead = equations(system, trial, anchor, rho, work)
            if ahead < (1 - DECREASE * length) * size:
                break
            length /= 2
        size = ahead
        for i in range(len(step)):
            for k in range(3):
                state.r[i, k], state.u[i, k], state.F[i, k] = trial.r[i, k], trial.u[i, k], trial.F[i, k]
    return limit, size
