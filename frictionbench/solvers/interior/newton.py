"""Newton's method on contacts with Coulomb friction, reduced to the velocities.

With the unknowns x and partners s of solvers.interior.point, a contact's impulse r = H x, and the matrix K by which its own
unknowns act on its s, a step of an interior point method is the linear system

    x ∘ ds + dx ∘ s = target,      ds = H'du + K dx + defect,      M dv = J'H dx + F'dlam,      du = J dv,
    F dv = -joint defect.

Given du, each contact has four equations of its own, B dx = g - H'du, solved by formula (solvers.interior.contact_equations).
There remains A dv = b in the velocities with

    A = M + sum_i J_i' C_i J_i + F'F/delta,      C_i = H B^-1 H',

a sum of small matrices, factorised by solvers.sparse_lu.multifrontal. A is singular if the impulses are not unique. Therefore
delta, a tiny multiple of the contacts' own size, is added to the diagonals of B: Newton's matrix becomes inexact, the defects
do not, and the next step removes the error. If the impulses are far from unique, rounding errors of the velocities can end
progress when delta is tiny, and the predictor-corrector enlarges it. A joint is a row with C = 1/delta for the same reason, so
that redundant joints are allowed.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, lean
from frictionbench.problems.forms.cone import nearest
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import deadline
from frictionbench.solvers.interior.contact_equations import planar_step, planar_stiffness, spatial_step, spatial_stiffness
from frictionbench.solvers.interior.point import Point, Vector
from frictionbench.solvers.interior.system import JOINT_SOFTNESS, SOFTNESS, Elements, Space, System
from frictionbench.solvers.sparse_lu.multifrontal import factorise, operations, solve_factorised

NEWTON_PIVOT = 1e-14  # the least pivot of A: a hundred units of rounding, since the mass matrix has a unit diagonal


class Work(NamedTuple):
    """Workspace of Newton's method on one system, as arrays created inside its loops would be reference-counted in every call.

    softness (1,): delta. storage, swap: the factors of A. inverse, pivot (nc, 4): 1/x and the pivots' inverses, in the plane.
    impulse (nc, d), vector and momentum (nv,). step, defect, target: those of the method. until: when the last factorisation
    may begin (solvers.clock).
    """

    softness: Array
    storage: Array
    swap: Index64
    inverse: Array
    pivot: Array
    impulse: Array
    vector: Array
    momentum: Array
    step: Point
    defect: Point
    target: Array
    until: float


def new_work(system: System, until: float) -> Work:
    nc, nv, pairs = len(system.friction), len(system.free_velocity), np.zeros((7, len(system.friction), 4))
    joints, velocity = np.zeros((2, len(system.joint_bias), 1)), np.zeros((2, nv))
    storage, impulse = np.zeros(system.fronts.start[-1]), np.zeros((nc, system.offset.shape[1]))
    step, defect = Point(pairs[0], pairs[1], joints[0]), Point(pairs[2], pairs[3], joints[1])
    return Work(
        np.full(1, SOFTNESS), storage, np.zeros(nv, np.int64), pairs[4], pairs[5], impulse, velocity[0], velocity[1],
        step, defect, pairs[6], until,
    )  # fmt: skip


def last_step(system: System) -> float:
    """When the last factorisation may begin."""
    return deadline(operations(system.fronts)) if deadline() < np.inf else np.inf


@inlined
def push(contacts: Elements, space: Space, i: int, r: Vector, momentum: Array) -> None:
    """momentum += push' r of contact i."""
    for a in range(contacts.start[i], contacts.start[i + 1]):
        along = contacts.push[a, 0] * r[0] + contacts.push[a, 1] * r[1]
        if space is not None:
            along += contacts.push[a, 2] * r[2]
        momentum[contacts.column[a]] += along


@inlined
def read(contacts: Elements, space: Space, i: int, v: Array) -> Vector:
    """read v of contact i; in the plane the third component is zero."""
    u0 = u1 = u2 = 0.0
    for a in range(contacts.start[i], contacts.start[i + 1]):
        along = v[contacts.column[a]]
        u0 += contacts.read[a, 0] * along
        u1 += contacts.read[a, 1] * along
        if space is not None:
            u2 += contacts.read[a, 2] * along
    return u0, u1, u2


@inlined
def add_stiffness(system: System, space: Space, i: int, n: Vector, s: Vector, t: Vector, storage: Array) -> None:
    """Add push' C read of contact i to its front; n, s, t: the rows of C."""
    contacts, fronts = system.contacts, system.fronts
    f, lo, hi = contacts.front[i], contacts.start[i], contacts.start[i + 1]
    begin, width = fronts.start[f], fronts.first[f + 1] - fronts.first[f]
    for a in range(lo, hi):
        row, p0, p1 = begin + contacts.place[a] * width, contacts.push[a, 0], contacts.push[a, 1]
        c0, c1, c2 = p0 * n[0] + p1 * s[0], p0 * n[1] + p1 * s[1], p0 * n[2] + p1 * s[2]
        if space is not None:
            p2 = contacts.push[a, 2]
            c0, c1, c2 = c0 + p2 * t[0], c1 + p2 * t[1], c2 + p2 * t[2]
        for b in range(lo, hi):
            along = c0 * contacts.read[b, 0] + c1 * contacts.read[b, 1]
            if space is not None:
                along += c2 * contacts.read[b, 2]
            storage[row + contacts.place[b]] += along


@inlined
def _impulse(space: Space, x: Array, i: int) -> Vector:
    """H x of contact i."""
    return (x[i, 0], x[i, 1] - x[i, 2], 0.0) if space is None else (x[i, 0], x[i, 1], x[i, 2])


@lean
def larger(a: float, b: float) -> float:
    """max(a, b) for a >= 0, infinity if b is NaN."""
    if b <= a:
        return a
    return b if b > a else np.inf


@lean
def _norm(a: float, b: float) -> float:
    return np.sqrt(a * a + b * b) if b else abs(a)  # in the plane b is 0; a root would take a good part of a contact's time


@lean
def natural(r: Vector, u: Vector, mu: float, bias: float, shift: float, weight: float) -> float:
    """weight |r - P_K(r - (u + shift |u_t| e_n) / weight)| for one contact. With a shift, that is for Coulomb's law, at least
    the defect of Signorini's law (problems.residual)."""
    compliance = 1 / weight
    n = r[0] - (u[0] + shift * _norm(u[1], u[2])) * compliance
    t1, t2 = r[1] - u[1] * compliance, r[2] - u[2] * compliance
    normal, share = nearest(n, _norm(t1, t2), mu, bias)
    off, off1, off2 = r[0] - normal, r[1] - share * t1, r[2] - share * t2
    defect = weight * np.sqrt(off * off + off1 * off1 + off2 * off2)
    return larger(defect, abs(min(weight * r[0], u[0]))) if shift > 0 else defect


@lean
def accelerate(system: System, momentum: Array, v: Array) -> None:
    """v = free velocity + M^-1 momentum."""
    for i in range(len(v)):
        v[i] = system.free_velocity[i]
        for k in range(system.indptr[i], system.indptr[i + 1]):
            v[i] += system.inverse[k] * momentum[system.indices[k]]


@lean
def push_joints(joints: Elements, impulse: Array, momentum: Array) -> None:
    for j in range(len(impulse)):
        for a in range(joints.start[j], joints.start[j + 1]):
            momentum[joints.column[a]] += joints.push[a, 0] * impulse[j, 0]


@lean
def read_joints(joints: Elements, v: Array, velocity: Array) -> None:
    for j in range(len(velocity)):
        velocity[j, 0] = 0.0
        for a in range(joints.start[j], joints.start[j + 1]):
            velocity[j, 0] += joints.read[a, 0] * v[joints.column[a]]


@lean
def pull_joints(system: System, drift: Array, step: Array, momentum: Array) -> None:
    """momentum += F' step, step = -drift/delta: the joints' part of the right-hand side of A dv = b. drift, step: (nj, 1)."""
    for j in range(len(drift)):
        step[j, 0] = -drift[j, 0] / JOINT_SOFTNESS
    push_joints(system.joints, step, momentum)


@lean
def joint_step(system: System, drift: Array, dv: Array, step: Array) -> None:
    """The change of the joints' impulses for a change dv of the velocities."""
    read_joints(system.joints, dv, step)
    for j in range(len(drift)):
        step[j, 0] = -(drift[j, 0] + step[j, 0]) / JOINT_SOFTNESS


@lean
def evaluate_point(system: System, space: Space, point: Point, defect: Point, work: Work) -> float:
    """The residual of problems.residual at a point's impulses, infinity if it is NaN.

    defect: overwritten with H'u + K x - s and F v + b_F. work.impulse: with the impulses.
    """
    x, s, off, v, worst = point.x, point.s, defect.x, work.vector, 0.0
    for k in range(len(v)):
        work.momentum[k] = 0.0
    for i in range(len(x)):
        r = _impulse(space, x, i)
        for k in range(work.impulse.shape[1]):
            work.impulse[i, k] = r[k] if system.acts[i, k] else 0.0
        push(system.contacts, space, i, r, work.momentum)
    push_joints(system.joints, point.joint, work.momentum)
    accelerate(system, work.momentum, v)
    read_joints(system.joints, v, defect.joint)
    for i in range(len(x)):
        mu, bias, shift = system.friction[i], system.friction_bias[i], system.shift[i]
        u0, u1, u2 = read(system.contacts, space, i, v)
        u0 += system.offset[i, 0]
        u1 += system.offset[i, 1]
        if space is not None:
            u2 += system.offset[i, 2]
        off[i, 0] = u0 - shift * x[i, 3] - s[i, 0]
        if system.pairs[i] > 1:
            if space is None:
                off[i, 1] = x[i, 3] + u1 - s[i, 1]
                off[i, 2] = x[i, 3] - u1 - s[i, 2]
                off[i, 3] = mu * x[i, 0] - x[i, 1] - x[i, 2] + bias - s[i, 3]
            else:
                off[i, 1] = u1 - s[i, 1]
                off[i, 2] = u2 - s[i, 2]
                off[i, 3] = mu * x[i, 0] + bias - s[i, 3]
        worst = larger(worst, natural(_impulse(space, x, i), (u0, u1, u2), mu, bias, mu - shift, system.weight[i]))
    for j in range(len(defect.joint)):
        defect.joint[j, 0] += system.joint_bias[j]
        worst = larger(worst, abs(defect.joint[j, 0]))
    return worst


@lean
def clear(system: System, storage: Array) -> None:
    """Set the fronts to the contributions of the mass matrix and the joints."""
    for k in range(len(storage)):
        storage[k] = 0.0
    for k in range(len(system.slot)):
        storage[system.slot[k]] += system.constant[k]


@lean
def assemble(system: System, space: Space, point: Point, work: Work) -> None:
    """Assemble Newton's matrix at a point in the fronts."""
    clear(system, work.storage)
    for i in range(len(point.x)):
        if space is None:
            n, s, t = planar_stiffness(system, point, i, work.softness[0], work.inverse, work.pivot)
        else:
            n, s, t = spatial_stiffness(system, point, i, work.softness[0])
        add_stiffness(system, space, i, n, s, t, work.storage)


@lean
def linearise(system: System, space: Space, point: Point, work: Work) -> None:
    """Assemble and factorise Newton's matrix at a point."""
    assemble(system, space, point, work)
    factorise(system.fronts, work.storage, work.swap, NEWTON_PIVOT)


@lean
def direction(system: System, space: Space, point: Point, target: Array, defect: Point, step: Point, work: Work) -> None:
    """The step with x ∘ ds + dx ∘ s = target that removes the defect, after linearise at the same point."""
    dv = work.vector
    for k in range(len(dv)):
        dv[k] = 0.0
    _contact_steps(system, space, point, target, defect, step, work)
    for i in range(len(target)):
        push(system.contacts, space, i, _impulse(space, step.x, i), dv)
    pull_joints(system, defect.joint, step.joint, dv)
    solve_factorised(system.fronts, work.storage, work.swap, dv)
    _contact_steps(system, space, point, target, defect, step, work)
    joint_step(system, defect.joint, dv, step.joint)


@lean
def _contact_steps(system: System, space: Space, point: Point, target: Array, defect: Point, step: Point, work: Work) -> None:
    """The contacts' dx and ds, for the change of the velocities in work.vector."""
    for i in range(len(target)):
        u = read(system.contacts, space, i, work.vector)
        if space is None:
            planar_step(system, point, i, target, defect.x, u, work.inverse, work.pivot, step)
        else:
            spatial_step(system, point, i, target, defect.x, u, work.softness[0], step)
