"""Sweeps over contacts and steps of semismooth Newton on dense rows, for problems of few contacts in space.

Alart and Curnier's equations, with s the contact's scale and rho = b_f + mu r_n its radius: a contact that is closed,
s r_n > u_n, has u_n = 0, an open one r = 0. With z = s r_t - u_t it sticks, u_t = 0, where |z| <= s rho, and else slides,

    s r_t - s rho z/|z| = 0.

A step solves the linearised equations of the closed contacts by LU, with the term `shift` s added to the diagonal of W, which
is singular if contacts are redundant. With a small shift Newton's method keeps its rate of convergence; with a large one a step
is a proximal step, which changes impulses as little as possible. Full steps may cycle among active sets. From a point just past
the first kink of the equations along the step (`past_first_change`) the next step uses another linear piece. References: Alart
and Curnier 1991; Acary and Brogliato 2008, chapter 13.

r (nc, 3) are the impulses, zero where a contact has no row. Functions that overwrite r update the velocities in the workspace.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import lean, part
from frictionbench.problems.residual import contact_residual
from frictionbench.problems.rows import Index64
from frictionbench.solvers.sweeps.laws import spatial_contact

CLOSED, SLIDES, STICKS = 1, 2, 4
LEAST_SHARE = 2.0**-15  # the shortest trial length of a step


class Work(NamedTuple):
    """w: (n,), the rows' velocities. B (n, n), right and active (n,): the equations of a step, and their rows.

    place: (nc, 3), the equation of each row, -1 for none. state: (nc,). z: (nc, 2). pair: (2, 3), of one contact.
    """

    w: Array
    B: Array
    right: Array
    active: Index64
    place: Index64
    state: Index64
    z: Array
    pair: Array


@part
def new_work(n, nc):  # type: ignore[no-untyped-def]
    """Workspace for n rows of nc contacts."""
    w, B, right, active = np.empty(n), np.empty((n, n)), np.empty(n), np.empty(n, np.int64)
    return Work(w, B, right, active, np.empty((nc, 3), np.int64), np.empty(nc, np.int64), np.empty((nc, 2)), np.zeros((2, 3)))


@lean
def measure(rows, r, work):  # type: ignore[no-untyped-def]
    """The residual of impulses r; work.w is overwritten with their velocities."""
    w, u = work.w, work.pair[1]
    for g in range(len(w)):
        w[g] = rows.rest[g]
    for i in range(len(r)):
        for a in range(3):
            if rows.row[i, a] >= 0:
                push(rows, w, rows.row[i, a], r[i, a])
    worst = 0.0
    for i in range(len(r)):
        for a in range(3):
            u[a] = w[rows.row[i, a]] if rows.row[i, a] >= 0 else rows.q[i, a]
        law = rows.scale[i], rows.friction[i], rows.friction_bias[i], rows.units[i]
        worst = max(worst, contact_residual(r[i], u, law[0], law[1], law[2], law[3], 1.0))
    return worst


@lean
def push(rows, w, g, change):  # type: ignore[no-untyped-def]
    """Add to w the effect of a change of the impulse of row g."""
    if change != 0:
        active_row = rows.V[g]
        for h in range(len(w)):
            w[h] += active_row[h] * change


@lean
def sweep(rows, r, work, times):  # type: ignore[no-untyped-def]
    """Solve the law of each contact in turn with all other impulses fixed; r and w are updated."""
    w, new, u = work.w, work.pair[0], work.pair[1]
    for _ in range(times):
        for i in range(len(r)):
            normal, first, second = rows.row[i]
            W, b_f = rows.block[i], rows.friction_bias[i]
            for a in range(3):
                new[a] = r[i, a]
                u[a] = w[rows.row[i, a]] if rows.row[i, a] >= 0 else rows.q[i, a]
            if first < 0 and second < 0:  # a limit, or a contact without friction
                if normal < 0:
                    continue
                new[0] = max(new[0] - u[0] / W[0, 0], 0.0)
            elif normal < 0 and second < 0:  # dry friction of a joint
                new[1] = min(max(new[1] - u[1] / W[1, 1], -b_f), b_f)
            else:
                spatial_contact(u, new, W, rows.friction[i], b_f)
            for a in range(3):
                if rows.row[i, a] >= 0:
                    push(rows, w, rows.row[i, a], new[a] - r[i, a])
                    r[i, a] = new[a]


@lean
def newton_step(rows, r, work, shift):  # type: ignore[no-untyped-def]
    """Overwrite r with the impulses after a Newton step from (r, w); False if its equations are singular."""
    w, B, right, active, place, state, z = work.w, work.B, work.right, work.active, work.place, work.state, work.z
    nc, m = len(r), 0
    for i in range(nc):
        state[i] = _state(rows, r, w, i, z[i])
        for a in range(3):
            g, place[i, a] = rows.row[i, a], -1
            if g < 0:
                continue
            dry = a > 0 and state[i] == SLIDES and rows.row[i, 3 - a] < 0  # slides in its only direction: its impulse is known
            if not dry and ((state[i] & CLOSED) if a == 0 else (state[i] & (STICKS | SLIDES))):
                active[m], place[i, a] = g, m
                m += 1
            else:
                known = np.sign(z[i, a - 1]) * rows.friction_bias[i] if dry else 0.0
                push(rows, w, g, known - r[i, a])
                r[i, a] = known
    for i in range(nc):
        for a in range(3):
            e = place[i, a]
            if e >= 0:
                for h in range(m):
                    B[e, h] = rows.V[active[h], active[e]]
                B[e, e] += shift * rows.scale[i]
                right[e] = -w[active[e]]
        if state[i] & SLIDES and (place[i, 1] >= 0 or place[i, 2] >= 0):
            _slide(rows, r, i, z[i], _radius(rows, r, i, state[i]), place[i], active, m, B, right)
    if not _solved(B, right, m):
        return False
    for i in range(nc):
        for a in range(3):
            if place[i, a] >= 0:
                r[i, a] += right[place[i, a]]
    return True


@part
def past_first_change(rows, r, old, work):  # type: ignore[no-untyped-def]
    """Overwrite r with a point between old and r, just past the first change of a contact's state.

    If contacts are redundant, the length of a step is the inconsistency of their equations divided by the shift. It may reach
    far beyond the point where a contact begins to slide or open, which would make the equations consistent.
    """
    w, state = work.w, work.state
    new, moved = r.copy(), w.copy()
    r[:] = old
    measure(rows, r, work)
    begun = w.copy()
    for i in range(len(r)):
        state[i] = _state(rows, r, w, i, work.z[i])
    share, same = LEAST_SHARE, True
    while same and share < 1:
        for i in range(len(r)):
            for a in range(3):
                r[i, a] = old[i, a] + share * (new[i, a] - old[i, a])
        for g in range(len(w)):
            w[g] = begun[g] + share * (moved[g] - begun[g])
        for i in range(len(r)):
            same = same and _state(rows, r, w, i, work.z[i]) == state[i]
        share *= 2


@lean
def _state(rows, r, w, i, z):  # type: ignore[no-untyped-def]
    """Whether contact i is closed, and whether it sticks, slides or, without friction, neither; z (2,) is overwritten."""
    s, state = rows.scale[i], 0
    normal = rows.row[i, 0]
    if normal >= 0 and s * r[i, 0] > w[normal]:
        state = CLOSED
    for a in range(1, 3):
        z[a - 1] = s * r[i, a] - (w[rows.row[i, a]] if rows.row[i, a] >= 0 else 0.0)
    rho = _radius(rows, r, i, state)
    if rho > 0 and (rows.row[i, 1] >= 0 or rows.row[i, 2] >= 0):
        state |= STICKS if np.hypot(z[0], z[1]) <= s * rho else SLIDES
    return state


@lean
def _radius(rows, r, i, state):  # type: ignore[no-untyped-def]
    return rows.friction_bias[i] + (rows.friction[i] * max(r[i, 0], 0.0) if state & CLOSED else 0.0)


@lean
def _slide(rows, r, i, z, rho, place, active, m, B, right):  # type: ignore[no-untyped-def]
    """The equations of a sliding contact's tangents, with d = z/|z|, D = I - d d' and c = s rho/|z|:

    s dr_t - s mu dr_n d - c D (s dr_t - du_t) = -(s r_t - s rho d).
    """
    s, size = rows.scale[i], np.hypot(z[0], z[1])
    c = s * rho / size
    for a in range(1, 3):
        e = place[a]
        if e < 0:
            continue
        d, across = z[a - 1] / size, z[2 - a] / size
        along, other, also = c * across * across, -c * d * across, place[3 - a]
        for h in range(m):
            B[e, h] = along * rows.V[active[h], active[e]]
            if also >= 0:
                B[e, h] += other * rows.V[active[h], active[also]]
        B[e, e] += s * (1 - along)
        if also >= 0:
            B[e, also] -= s * other
        if place[0] >= 0:
            B[e, place[0]] -= s * rows.friction[i] * d
        right[e] = s * (rho * d - r[i, a])


@lean
def _solved(B, x, m):  # type: ignore[no-untyped-def]
    """Overwrite x with B^-1 x (m rows) and B with its LU factors, with row interchanges; False if B is singular."""
    for k in range(m):
        p = k
        for i in range(k + 1, m):
            if abs(B[i, k]) > abs(B[p, k]):
                p = i
        if not abs(B[p, k]) > 0:
            return False
        if p != k:
            for j in range(k, m):
                B[k, j], B[p, j] = B[p, j], B[k, j]
            x[k], x[p] = x[p], x[k]
        row = B[k, k + 1 : m]
        for i in range(k + 1, m):
            factor = B[i, k] / B[k, k]
            if factor != 0:
                other = B[i, k + 1 : m]
                for j in range(len(row)):
                    other[j] -= factor * row[j]
                x[i] -= factor * x[k]
    for k in range(m - 1, -1, -1):
        for j in range(k + 1, m):
            x[k] -= B[k, j] * x[j]
        x[k] /= B[k, k]
    return True
