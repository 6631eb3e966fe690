"""Newton's method on planar contacts with Coulomb friction, reduced to the velocities.

A contact has four complementary pairs (x, s), x >= 0, s >= 0, in the unknowns of the friction LCP (problems.lcp):

    c:       u_n                             its normal impulse, and the speed at which it opens,
    beta+:   lambda + u_t                    its impulse along the tangent,
    beta-:   lambda - u_t                    and against it,
    lambda:  mu c - beta+ - beta- + b_f      its sliding speed, and the friction left.

With K for the parts in which a contact's own unknowns act on its s, and r = H x its impulse, a step of an interior point method
is the linear system

    x ds + s dx = target,      ds = H'du + K dx + defect,      M dv = J'H dx + F'dlam,      du = J dv,
    F dv = -joint defect.

Given du, each contact is four equations for itself, B dx = target/x - defect - H'du with B = diag(s/x) + K, solved by
formula: every pivot is a sum of positive numbers. (In the convex relaxation c's partner is u_n - mu lambda, and K is skew.)
What is left is A dv = b in the velocities with

    A = M + sum_i J_i' C_i J_i + F'F/delta,      C_i = H B^-1 H',

a sum of small matrices, factorised by solvers.multifrontal. A is singular where the impulses are not unique, so delta, a tiny
multiple of the contacts' own size, is added to the diagonals of B: Newton's matrix is inexact by it, the defects are not, and
the error is driven out by the next step. A joint is a row of C = 1/delta for the same reason: redundant joints do no harm.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from problems.check import Array
from solvers.contact_system import JOINT_SOFTNESS, Elements, System
from solvers.minimum_degree import Index
from solvers.multifrontal import Fronts, factorise, solve

SOFTNESS = 1e-13  # delta, relative to a contact's own mean diagonal of W; 1e-16 fails, 1e-12 slows stacks of thousands
PIVOT = 1e-14  # the least pivot of A, whose mass matrix is scaled to the size of 1


class Point(NamedTuple):
    """Unknowns x (nc, 4), their partners s (nc, 4), the joints' impulses (nj, 1); a step and a defect have the same shape.

    A contact without friction has its first pair alone; the others are zero, and so is all that is computed from them.
    """

    x: Array
    s: Array
    joint: Array


class Work(NamedTuple):
    """Room for one system: the factors of A, the contacts' 1/x, pivots and right sides, and vectors."""

    storage: Array
    swap: Index
    inverse: Array
    pivot: Array
    right: Array
    impulse: Array
    joint_velocity: Array
    vector: Array
    momentum: Array


@njit(cache=True)
def new_point(system: System) -> Point:
    nc, nj = len(system.friction), len(system.joint_bias)
    return Point(np.zeros((nc, 4)), np.zeros((nc, 4)), np.zeros((nj, 1)))


@njit(cache=True, error_model="numpy")
def start_point(system: System, impulse: float, speed: float) -> Point:
    """Impulses of `impulse` times what stops a unit velocity at their contact, and velocities of `speed`."""
    point = new_point(system)
    for i in range(len(point.x)):
        own = impulse / system.weight[i]
        for k in range(system.pairs[i]):
            point.x[i, k] = own if k < 3 else speed
            point.s[i, k] = speed if k < 3 else own
    return point


@njit(cache=True)
def new_work(system: System) -> Work:
    nc, nv, nj = len(system.friction), len(system.free_velocity), len(system.joint_bias)
    return Work(
        np.zeros(system.fronts.start[-1]),
        np.zeros(nv, dtype=np.int64),
        np.zeros((nc, 4)),
        np.zeros((nc, 4)),
        np.zeros((nc, 4)),
        np.zeros((nc, 2)),
        np.zeros((nj, 1)),
        np.zeros(nv),
        np.zeros(nv),
    )


@njit(cache=True, error_model="numpy")
def _push(contacts: Elements, i: int, normal: float, tangent: float, momentum: Array) -> None:
    """momentum += push' (normal, tangent) of contact i."""
    for a in range(contacts.start[i], contacts.start[i + 1]):
        momentum[contacts.column[a]] += contacts.push[a, 0] * normal + contacts.push[a, 1] * tangent


@njit(cache=True, error_model="numpy")
def _feel(contacts: Elements, i: int, v: Array) -> tuple[float, float]:
    """feel v of contact i."""
    un = ut = 0.0
    for a in range(contacts.start[i], contacts.start[i + 1]):
        un += contacts.feel[a, 0] * v[contacts.column[a]]
        ut += contacts.feel[a, 1] * v[contacts.column[a]]
    return un, ut


@njit(cache=True, error_model="numpy")
def _push_joints(joints: Elements, impulse: Array, momentum: Array) -> None:
    for j in range(len(impulse)):
        for a in range(joints.start[j], joints.start[j + 1]):
            momentum[joints.column[a]] += joints.push[a, 0] * impulse[j, 0]


@njit(cache=True, error_model="numpy")
def _feel_joints(joints: Elements, v: Array, velocity: Array) -> None:
    for j in range(len(velocity)):
        velocity[j, 0] = 0.0
        for a in range(joints.start[j], joints.start[j + 1]):
            velocity[j, 0] += joints.feel[a, 0] * v[joints.column[a]]


@njit(cache=True, error_model="numpy")
def evaluate(system: System, point: Point, defect: Point, work: Work) -> float:
    """The residual of problems.residual at a point's impulses; defect: overwritten with H'u + K x - s and F v + b_F."""
    x, s, r, v = point.x, point.s, work.impulse, work.vector
    work.momentum[:] = 0
    for i in range(len(x)):
        r[i, 0] = x[i, 0]
        r[i, 1] = x[i, 1] - x[i, 2]
        _push(system.contacts, i, r[i, 0], r[i, 1], work.momentum)
    _push_joints(system.joints, point.joint, work.momentum)
    for i in range(len(v)):
        v[i] = system.free_velocity[i]
        for k in range(system.indptr[i], system.indptr[i + 1]):
            v[i] += system.inverse[k] * work.momentum[system.indices[k]]
    _feel_joints(system.joints, v, defect.joint)
    worst = 0.0
    for j in range(len(defect.joint)):
        defect.joint[j, 0] += system.joint_bias[j]
        worst = max(worst, abs(defect.joint[j, 0]))
    for i in range(len(x)):
        mu, bias, shift = system.friction[i], system.friction_bias[i], system.shift[i]
        un, ut = _feel(system.contacts, i, v)
        un += system.offset[i, 0]
        ut += system.offset[i, 1]
        defect.x[i, 0] = un - shift * x[i, 3] - s[i, 0]
        if system.pairs[i] == 4:
            defect.x[i, 1] = x[i, 3] + ut - s[i, 1]
            defect.x[i, 2] = x[i, 3] - ut - s[i, 2]
            defect.x[i, 3] = mu * x[i, 0] - x[i, 1] - x[i, 2] + bias - s[i, 3]
        worst = max(worst, _natural(r[i, 0], r[i, 1], un, ut, mu, bias, shift, system.weight[i]))
    return worst


@njit(cache=True, error_model="numpy")
def _natural(rn: float, rt: float, un: float, ut: float, mu: float, bias: float, shift: float, weight: float) -> float:
    """weight |r - P_K(r - (u + (mu - shift) |u_t| e_n) / weight)| for one contact."""
    compliance = 1 / weight
    n, t = rn - (un + (mu - shift) * abs(ut)) * compliance, rt - ut * compliance
    normal = n
    if abs(t) > mu * n + bias:
        normal = max((n + mu * (abs(t) - bias)) / (1 + mu * mu), 0.0)
    elif n < 0:
        normal = 0.0
    limit = mu * normal + bias
    off, across = rn - normal, rt - min(max(t, -limit), limit)
    return weight * np.sqrt(off * off + across * across)


@njit(cache=True, error_model="numpy")
def linearise(system: System, point: Point, work: Work) -> None:
    """Newton's matrix at a point, factorised."""
    x, s, inverse, pivot = point.x, point.s, work.inverse, work.pivot
    work.storage[:] = 0
    for k in range(len(system.slot)):
        work.storage[system.slot[k]] += system.constant[k]
    for i in range(len(x)):
        soft = SOFTNESS * system.weight[i]
        inverse[i, 0] = 1 / x[i, 0]
        pivot[i, 0] = 1 / (s[i, 0] * inverse[i, 0] + soft)
        nn, nt, tn, tt = pivot[i, 0], 0.0, 0.0, 0.0
        if system.pairs[i] == 4:
            for k in range(1, 4):
                inverse[i, k] = 1 / x[i, k]
            pivot[i, 1] = 1 / (s[i, 1] * inverse[i, 1] + soft)
            pivot[i, 2] = 1 / (s[i, 2] * inverse[i, 2] + soft)
            total, skew = pivot[i, 1] + pivot[i, 2], pivot[i, 1] - pivot[i, 2]
            mu, shift = system.friction[i], system.shift[i]
            own = s[i, 3] * inverse[i, 3] + SOFTNESS / system.weight[i]
            pivot[i, 3] = 1 / (own + total + mu * shift * nn)
            nt = shift * skew * pivot[i, 3] * nn
            tn = mu * skew * pivot[i, 3] * nn
            tt = total - skew * skew * pivot[i, 3]
            nn -= mu * shift * nn * nn * pivot[i, 3]
        _add(system.contacts, i, nn, nt, tn, tt, system.fronts, work.storage)
    factorise(system.fronts, work.storage, work.swap, PIVOT)


@njit(cache=True, error_model="numpy")
def _add(contacts: Elements, i: int, nn: float, nt: float, tn: float, tt: float, fronts: Fronts, storage: Array) -> None:
    """Add push' C feel of contact i, C = [[nn, nt], [tn, tt]], to its front."""
    f, lo, hi = contacts.front[i], contacts.start[i], contacts.start[i + 1]
    begin, width = fronts.start[f], fronts.first[f + 1] - fronts.first[f]
    for a in range(lo, hi):
        row = begin + contacts.place[a] * width
        normal = contacts.push[a, 0] * nn + contacts.push[a, 1] * tn
        tangent = contacts.push[a, 0] * nt + contacts.push[a, 1] * tt
        for b in range(lo, hi):
            storage[row + contacts.place[b]] += normal * contacts.feel[b, 0] + tangent * contacts.feel[b, 1]


@njit(cache=True, error_model="numpy")
def _contact(pivot: Array, mu: float, shift: float, g: Array, un: float, ut: float) -> tuple[float, float, float, float]:
    """B^-1 (g - H'u) of one contact."""
    c = pivot[0] * (g[0] - un)
    plus, minus = pivot[1] * (g[1] - ut), pivot[2] * (g[2] + ut)
    slide = pivot[3] * (g[3] + plus + minus - mu * c)
    return c + pivot[0] * shift * slide, plus - pivot[1] * slide, minus - pivot[2] * slide, slide


@njit(cache=True, error_model="numpy")
def direction(system: System, point: Point, target: Array, defect: Point, step: Point, work: Work) -> None:
    """The step with x ds + s dx = target that removes the defect, after linearise at the same point."""
    s, g, inverse, dv = point.s, work.right, work.inverse, work.vector
    dv[:] = 0
    for i in range(len(s)):
        for k in range(4):
            g[i, k] = target[i, k] * inverse[i, k] - defect.x[i, k]
        c, plus, minus, _ = _contact(work.pivot[i], system.friction[i], system.shift[i], g[i], 0.0, 0.0)
        _push(system.contacts, i, c, plus - minus, dv)
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -defect.joint[j, 0] / JOINT_SOFTNESS
    _push_joints(system.joints, step.joint, dv)
    solve(system.fronts, work.storage, work.swap, dv)
    _feel_joints(system.joints, dv, work.joint_velocity)
    for i in range(len(s)):
        un, ut = _feel(system.contacts, i, dv)
        dx = step.x[i]
        dx[0], dx[1], dx[2], dx[3] = _contact(work.pivot[i], system.friction[i], system.shift[i], g[i], un, ut)
        for k in range(4):
            step.s[i, k] = (target[i, k] - s[i, k] * dx[k]) * inverse[i, k]
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -(defect.joint[j, 0] + work.joint_velocity[j, 0]) / JOINT_SOFTNESS
