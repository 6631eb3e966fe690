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
from numpy.typing import NDArray

from problems.check import Array
from solvers.contact_system import JOINT_SOFTNESS, Elements, System
from solvers.minimum_degree import Index
from solvers.multifrontal import Fronts, factorise, solve

SOFTNESS = 1e-13  # delta, relative to a contact's own mean diagonal of W; 1e-16 fails, 1e-12 slows stacks of thousands
PIVOT = 1e-14  # the least pivot of A, whose mass matrix is scaled to the size of 1


class Point(NamedTuple):
    """Unknowns x (nc, 4), their partners s (nc, 4), the joints' impulses (nj, 1); a step and a defect have the same shape."""

    x: Array
    s: Array
    joint: Array


class Work(NamedTuple):
    """Room for one system: the factors of A, the contacts' pivots and stiffness C, and vectors."""

    storage: Array
    swap: Index
    pivot: Array
    stiffness: NDArray[np.float64]
    right: Array
    impulse: Array
    velocity: Array
    joint_velocity: Array
    vector: Array
    momentum: Array


@njit(cache=True)
def new_point(system: System) -> Point:
    nc, nj = len(system.friction), len(system.joint_bias)
    return Point(np.zeros((nc, 4)), np.zeros((nc, 4)), np.zeros((nj, 1)))


@njit(cache=True)
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
        np.zeros((nc, 2, 2)),
        np.zeros((nc, 4)),
        np.zeros((nc, 2)),
        np.zeros((nc, 2)),
        np.zeros((nj, 1)),
        np.zeros(nv),
        np.zeros(nv),
    )


@njit(cache=True)
def push(elements: Elements, impulse: Array, momentum: Array) -> None:
    """momentum += push' impulse."""
    for e in range(len(impulse)):
        for a in range(elements.start[e], elements.start[e + 1]):
            for i in range(impulse.shape[1]):
                momentum[elements.column[a]] += elements.push[a, i] * impulse[e, i]


@njit(cache=True)
def feel(elements: Elements, v: Array, velocity: Array) -> None:
    """velocity = feel v."""
    for e in range(len(velocity)):
        for i in range(velocity.shape[1]):
            velocity[e, i] = 0
        for a in range(elements.start[e], elements.start[e + 1]):
            for i in range(velocity.shape[1]):
                velocity[e, i] += elements.feel[a, i] * v[elements.column[a]]


@njit(cache=True)
def evaluate(system: System, point: Point, defect: Point, work: Work) -> float:
    """The residual of problems.residual at a point's impulses; defect: overwritten with H'u + K x - s and F v + b_F."""
    x, s, r, u = point.x, point.s, work.impulse, work.velocity
    for i in range(len(x)):
        r[i, 0] = x[i, 0]
        r[i, 1] = x[i, 1] - x[i, 2]
    work.momentum[:] = 0
    push(system.contacts, r, work.momentum)
    push(system.joints, point.joint, work.momentum)
    v = work.vector
    for i in range(len(v)):
        v[i] = system.free_velocity[i]
        for k in range(system.indptr[i], system.indptr[i + 1]):
            v[i] += system.inverse[k] * work.momentum[system.indices[k]]
    feel(system.contacts, v, u)
    feel(system.joints, v, defect.joint)
    worst = 0.0
    for j in range(len(defect.joint)):
        defect.joint[j, 0] += system.joint_bias[j]
        worst = max(worst, abs(defect.joint[j, 0]))
    for i in range(len(x)):
        mu, bias = system.friction[i], system.friction_bias[i]
        u[i, 0] += system.offset[i, 0]
        u[i, 1] += system.offset[i, 1]
        defect.x[i, 0] = u[i, 0] - system.shift[i] * x[i, 3] - s[i, 0]
        if system.pairs[i] == 4:
            defect.x[i, 1] = x[i, 3] + u[i, 1] - s[i, 1]
            defect.x[i, 2] = x[i, 3] - u[i, 1] - s[i, 2]
            defect.x[i, 3] = mu * x[i, 0] - x[i, 1] - x[i, 2] + bias - s[i, 3]
        worst = max(worst, _natural(r[i, 0], r[i, 1], u[i, 0], u[i, 1], mu, bias, system.shift[i], system.weight[i]))
    return worst


@njit(cache=True)
def _natural(rn: float, rt: float, un: float, ut: float, mu: float, bias: float, shift: float, weight: float) -> float:
    """weight |r - P_K(r - (u + (mu - shift) |u_t| e_n) / weight)| for one contact."""
    n, t = rn - (un + (mu - shift) * abs(ut)) / weight, rt - ut / weight
    normal = n
    if n < 0 or abs(t) > mu * n + bias:
        normal = max((n + mu * (abs(t) - bias)) / (1 + mu * mu), 0.0) if abs(t) > mu * n + bias else 0.0
    limit = mu * normal + bias
    return weight * np.hypot(rn - normal, rt - min(max(t, -limit), limit))


@njit(cache=True)
def _add(elements: Elements, stiffness: NDArray[np.float64], fronts: Fronts, storage: Array) -> None:
    """Add push' C feel of every element to its front."""
    d = stiffness.shape[1]
    for e in range(len(stiffness)):
        lo, hi, f = elements.start[e], elements.start[e + 1], elements.front[e]
        base, width = fronts.start[f], fronts.first[f + 1] - fronts.first[f]
        for a in range(lo, hi):
            row = base + elements.place[a] * width
            for j in range(d):
                pushed = 0.0
                for i in range(d):
                    pushed += elements.push[a, i] * stiffness[e, i, j]
                if pushed != 0:
                    for b in range(lo, hi):
                        storage[row + elements.place[b]] += pushed * elements.feel[b, j]


@njit(cache=True)
def linearise(system: System, point: Point, work: Work) -> None:
    """Newton's matrix at a point, factorised."""
    x, s, pivot, C = point.x, point.s, work.pivot, work.stiffness
    for i in range(len(x)):
        soft = SOFTNESS * system.weight[i]
        pivot[i, 0] = x[i, 0] / (s[i, 0] + soft * x[i, 0])
        C[i, 0, 0] = pivot[i, 0]
        if system.pairs[i] == 4:
            pivot[i, 1] = x[i, 1] / (s[i, 1] + soft * x[i, 1])
            pivot[i, 2] = x[i, 2] / (s[i, 2] + soft * x[i, 2])
            total, skew = pivot[i, 1] + pivot[i, 2], pivot[i, 1] - pivot[i, 2]
            mu, shift = system.friction[i], system.shift[i]
            own = s[i, 3] / x[i, 3] + SOFTNESS / system.weight[i]
            pivot[i, 3] = 1 / (own + total + mu * shift * pivot[i, 0])
            C[i, 0, 0] -= mu * shift * pivot[i, 0] * pivot[i, 0] * pivot[i, 3]
            C[i, 0, 1] = shift * skew * pivot[i, 3] * pivot[i, 0]
            C[i, 1, 0] = mu * skew * pivot[i, 3] * pivot[i, 0]
            C[i, 1, 1] = total - skew * skew * pivot[i, 3]
    work.storage[:] = 0
    for k in range(len(system.slot)):
        work.storage[system.slot[k]] += system.constant[k]
    _add(system.contacts, C, system.fronts, work.storage)
    factorise(system.fronts, work.storage, work.swap, PIVOT)


@njit(cache=True)
def _contact(pivot: Array, mu: float, shift: float, g: Array, un: float, ut: float) -> tuple[float, float, float, float]:
    """B^-1 (g - H'u) of one contact."""
    c = pivot[0] * (g[0] - un)
    plus, minus = pivot[1] * (g[1] - ut), pivot[2] * (g[2] + ut)
    slide = pivot[3] * (g[3] + plus + minus - mu * c)
    return c + pivot[0] * shift * slide, plus - pivot[1] * slide, minus - pivot[2] * slide, slide


@njit(cache=True)
def direction(system: System, point: Point, target: Array, defect: Point, step: Point, work: Work) -> None:
    """The step with x ds + s dx = target that removes the defect, after linearise at the same point. Overwrites target."""
    x, s, g, r, u = point.x, point.s, work.right, work.impulse, work.velocity
    for i in range(len(x)):
        for k in range(system.pairs[i]):
            target[i, k] /= x[i, k]
            g[i, k] = target[i, k] - defect.x[i, k]
        c, plus, minus, _ = _contact(work.pivot[i], system.friction[i], system.shift[i], g[i], 0.0, 0.0)
        r[i, 0] = c
        r[i, 1] = plus - minus
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -defect.joint[j, 0] / JOINT_SOFTNESS
    dv = work.vector
    dv[:] = 0
    push(system.contacts, r, dv)
    push(system.joints, step.joint, dv)
    solve(system.fronts, work.storage, work.swap, dv)
    feel(system.contacts, dv, u)
    feel(system.joints, dv, work.joint_velocity)
    for i in range(len(x)):
        dx = step.x[i]
        dx[0], dx[1], dx[2], dx[3] = _contact(work.pivot[i], system.friction[i], system.shift[i], g[i], u[i, 0], u[i, 1])
        for k in range(system.pairs[i]):
            step.s[i, k] = target[i, k] - s[i, k] / x[i, k] * dx[k]
    for j in range(len(defect.joint)):
        step.joint[j, 0] = -(defect.joint[j, 0] + work.joint_velocity[j, 0]) / JOINT_SOFTNESS
