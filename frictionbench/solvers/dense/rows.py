"""A problem of few contacts in space as u = V r + q over the rows that can move, with the units of its residual.

Rows without effect are left out: zero rows of J (a joint's limit has no tangents, its dry friction no normal), directions that
joints lock, and the tangents of contacts without friction. With the inverse X of F M^-1 F' and C = F M^-1 J'
(problems.forms.held), a few joint equations are eliminated by

    W = J M^-1 J' - C' X C.

scale and units are those of the problem (problems.mechanics, problems.forms.islands), found here in the same pass.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import lean, part
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.held import hold, hold_rounding
from frictionbench.problems.forms.islands import mechanical_units
from frictionbench.problems.rows import Index64


class DenseRows(NamedTuple):
    """V (n, n) for n rows: V[g, h] is the velocity of row h for a unit impulse at row g, which may differ from V[h, g] if only
    W is known. row: (nc, 3), the row of each contact's normal and tangents, -1 for none.

    block: (nc, 3, 3), each contact's block of V. q: (nc, 3), u for r = 0. rest: (n,), the same by rows.
    locked: (nc, 3), directions that joints lock. scale, units, friction, friction_bias: (nc,).
    """

    V: Array
    row: Index64
    block: Array
    q: Array
    rest: Array
    locked: NDArray[np.bool_]
    scale: Array
    units: Array
    friction: Array
    friction_bias: Array


@part
def dense_rows(bodies, joints, inverse, free, bias, mu, b_f):  # type: ignore[no-untyped-def]
    """bodies: J by contacts and M^-1 by rows. joints: F by rows and b_F. inverse: M^-1 F' and X (problems.forms.held)."""
    start, column, J, m_start, m_column, m_value = bodies
    (f_start, f_column, F, b_F), (response, X) = joints, inverse
    nc, nj = len(bias), len(b_F)
    moves, held = np.abs(free), hold(f_start, f_column, F, b_F, response, X, free)
    C = delassus.coupling(start, column, J, response)
    XC = np.zeros(C.shape)
    if nj:
        moves += hold_rounding(f_start, f_column, F, b_F, response, X, free, held)
        for j in range(nj):
            for k in range(nj):
                for i in range(3 * nc):
                    XC[j, i] += X[j, k] * C[k, i]
    V, row, diagonal = _without_joints(start, column, J, m_start, m_column, m_value, mu, b_f)
    q, size = np.empty((nc, 3)), np.empty((nc, 3))
    locked, lost = np.zeros((nc, 3), np.bool_), np.zeros((nc, 3), np.bool_)
    delassus.write_contact_velocity(start, column, J, held, bias, False, q)
    if nj:
        delassus.write_contact_velocity(start, column, J, moves, bias, True, size)
        for i in range(nc):
            _lock(i, bodies, joints, inverse, C, XC, q, size, diagonal, locked, lost)
    scale = delassus.mean_diagonal(diagonal)
    flat = q.copy().reshape(3 * nc)
    units, _ = mechanical_units(start, column, J, m_start, m_column, m_value, f_start, f_column, moves, bias, flat, scale, b_f)
    if nj:
        _hold_rows(V, row, C, XC, locked)
        for i in range(nc):
            for a in range(3):
                if lost[i, a] and not locked[i, a] and row[i, a] >= 0:
                    u = _column(i, a, bodies, joints, inverse)
                    for j in range(nc):
                        for b in range(3):
                            if row[j, b] >= 0 and not locked[j, b]:
                                V[row[i, a], row[j, b]] = V[row[j, b], row[i, a]] = u[j, b]
    block, rest = np.zeros((nc, 3, 3)), np.zeros(len(V))
    for i in range(nc):
        for a in range(3):
            # A tangent in which no impulse can change the velocity still determines the direction of friction if it slides.
            if row[i, a] >= 0 and locked[i, a] and (a == 0 or q[i, a] == 0):
                row[i, a] = -1
        for a in range(3):
            if row[i, a] >= 0:
                rest[row[i, a]] = q[i, a]
                for b in range(3):
                    if row[i, b] >= 0:
                        block[i, a, b] = V[row[i, a], row[i, b]]
    return DenseRows(V, row, block, q, rest, locked, scale, units, mu, b_f)


@part
def known_rows(first, neighbours, block, q, mu, b_f, scale, units):  # type: ignore[no-untyped-def]
    """The rows of W known by blocks (problems.forms.delassus) and q (nc, 3). Rows with a zero on the diagonal are left out."""
    nc, n = len(mu), 0
    row, own, rest = np.full((nc, 3), -1), np.zeros((nc, 3, 3)), np.empty(3 * nc)
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            if neighbours[k] == i:
                own[i] = block[k]
        for a in range(3):
            if own[i, a, a] > 0 and (a == 0 or mu[i] > 0 or b_f[i] > 0):
                row[i, a], rest[n] = n, q[i, a]
                n += 1
    V = np.zeros((n, n))
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            for a in range(3):
                for b in range(3):
                    g, h = row[neighbours[k], b], row[i, a]
                    if g >= 0 and h >= 0:
                        V[g, h] = block[k, a, b]
    locked = np.zeros((nc, 3), np.bool_)
    return DenseRows(V, row, own, q.copy(), rest[:n], locked, scale, units, mu, b_f)  # q may be read-only


@part
def _without_joints(start, column, J, m_start, m_column, m_value, mu, b_f):  # type: ignore[no-untyped-def]
    """J M^-1 J' over the rows with an effect, their numbers, and the diagonal (nc, 3) of all rows.

    Row by row: y = M^-1 J_i', then J y for this row and the previous ones.
    """
    nc, nv = len(start) - 1, len(m_start) - 1
    diagonal, row, n = np.zeros((nc, 3)), np.full((nc, 3), -1), 0
    for i in range(nc):
        for a in range(3):
            for k in range(start[i], start[i + 1]):
                if J[k, a] != 0 and row[i, a] < 0 and (a == 0 or mu[i] > 0 or b_f[i] > 0):
                    row[i, a] = n
                    n += 1
    V, y, moved, turn = np.zeros((n, n)), np.zeros(nv), np.full(nv, -1), 0
    for i in range(nc):
        for a in range(3):
            turn += 1
            for k in range(start[i], start[i + 1]):
                if J[k, a] != 0:
                    _respond(m_start[column[k]], m_start[column[k] + 1], m_column, m_value, J[k, a], y, moved, turn)
            for k in range(start[i], start[i + 1]):
                if J[k, a] != 0:
                    diagonal[i, a] += J[k, a] * y[column[k]]
            g = row[i, a]
            for j in range(i + 1 if g >= 0 else 0):
                for b in range(3):
                    h = row[j, b]
                    if 0 <= h <= g:
                        w = 0.0
                        for k in range(start[j], start[j + 1]):
                            if moved[column[k]] == turn:
                                w += J[k, b] * y[column[k]]
                        V[g, h] = V[h, g] = w
    return V, row, diagonal


@lean
def _respond(first, end, m_column, m_value, lever, y, moved, turn):  # type: ignore[no-untyped-def]
    """Add lever times a row of M^-1 to y; entries that were not yet moved in this turn begin at zero."""
    dense = m_column[end - 1] - m_column[first] == end - first - 1
    if moved[m_column[first]] != turn:
        for m in range(first, end):
            moved[m_column[m]] = turn
            y[m_column[m]] = 0.0
    if dense:  # a loop that compilers unroll
        into, value = y[m_column[first] : m_column[end - 1] + 1], m_value[first:end]
        for m in range(end - first):
            into[m] += lever * value[m]
    else:
        for m in range(first, end):
            y[m_column[m]] += lever * m_value[m]


@lean
def _hold_rows(V, row, C, XC, locked):  # type: ignore[no-untyped-def]
    """Subtract C' X C from V, and set rows and columns of locked directions to zero."""
    for p in range(3 * len(row)):
        for q in range(p + 1):
            g, h = row[p // 3, p % 3], row[q // 3, q % 3]
            if g >= 0 and h >= 0:
                w = V[g, h]
                for j in range(len(C)):
                    w -= C[j, p] * XC[j, q]
                V[g, h] = V[h, g] = 0.0 if locked[p // 3, p % 3] or locked[q // 3, q % 3] else w


@part
def _lock(i, bodies, joints, inverse, C, XC, q, size, diagonal, locked, lost):  # type: ignore[no-untyped-def]
    """Subtract the joints' share from contact i's diagonal, which becomes 0 in directions that they lock; if they lock all
    three, the diagonal is kept. q in a locked direction is set to 0 if it is rounding; size (nc, 3): the sum of its absolute
    terms. lost: directions in which the difference of W's terms has too few digits."""
    X, left = inverse[1], diagonal[i].copy()
    for a in range(3):
        held, terms, at = 0.0, 0.0, 3 * i + a
        for j in range(len(X)):
            held += C[j, at] * XC[j, at]
            for k in range(len(X)):
                terms += abs(C[j, at] * X[j, k] * C[k, at])
        left[a] -= held
        lost[i, a] = left[a] <= delassus.LOST * (diagonal[i, a] + terms) and diagonal[i, a] > 0
        if lost[i, a]:
            left[a] = _column(i, a, bodies, joints, inverse)[i, a]
        locked[i, a] = left[a] <= delassus.LOCKED * diagonal[i, a]
    whole = locked[i, 0] and locked[i, 1] and locked[i, 2]
    for a in range(3):
        if locked[i, a] and abs(q[i, a]) <= delassus.LOCKED * size[i, a]:
            q[i, a] = 0.0
        if not whole:
            diagonal[i, a] = 0.0 if locked[i, a] else left[a]


@part
def _column(i, a, bodies, joints, inverse):  # type: ignore[no-untyped-def]
    """W's column of direction a of contact i (nc, 3): the velocities J P J_i' of all contacts (problems.mechanics)."""
    start, column, J, m_start, m_column, m_value = bodies
    f_start, f_column, F, b_F = joints
    still, unit = np.zeros(len(start) - 1), np.zeros((len(start) - 1, 3))
    unit[i, a] = 1.0
    y = delassus.velocity(start, column, J, m_start, m_column, m_value, np.zeros(len(m_start) - 1), unit)
    for _ in range(2):
        y = hold(f_start, f_column, F, 0.0 * b_F, inverse[0], inverse[1], y)
    return delassus.contact_velocity(start, column, J, y, still)
