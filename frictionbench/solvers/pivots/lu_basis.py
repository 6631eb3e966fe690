"""Bases of an LCP's columns: one LU factorisation, updated with every pivot.

Methods that pivot on w = M z + q work with n columns chosen from

    z_i:  M e_i        w_i:  -e_i        t:  cover

numbered i, n + i and 2n. If w_i is basic, row i determines it, so that only the other rows, the core, need an LU factorisation.
It is sparse and left-looking (Gilbert and Peierls 1988), with pivots on the diagonal of M where they are large enough, so that
the unknowns can be ordered for little fill (solvers.pivots.ordering). A pivot is a product-form update (Dantzig and
Orchard-Hays 1954); after UPDATES of them the basis is refactorised, which also removes the accumulated round-off. Values are in
the units of M, which should be scaled first.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import late
from frictionbench.solvers.pivots.vectors import fill, put

DENSE = 512  # unknowns up to which there is storage for full factors
FILL = 24  # for larger M: initial storage of L, and of U, in entries for each entry of M
ON_DIAGONAL = 0.1  # share of the largest entry of a column that an entry on M's diagonal needs to be the pivot
UPDATES = 96  # of a factorisation; each costs n products in every later solve, n numbers of storage, and rounding errors


class Columns(NamedTuple):
    """The columns from which bases are chosen: M (n, n) compressed by columns, cover (n,)."""

    start: Index64
    rows: Index64
    column: Array
    cover: Array


class Factor(NamedTuple):
    """A triangular factor by columns: start (n+1,) of the columns, row number and value of their entries."""

    start: Index64
    number: Index64
    value: Array


class LUBasis(NamedTuple):
    """head (n,): the variable at position i. The rest is the factorisation, which is internal to this file."""

    head: Index64
    size: Index64  # number of core columns; of updates; 1 if the factorisation was not finished, else 0
    core: Index64  # the variable of the k-th core column
    order: Index64  # its pivot row, which is also its position
    L: Factor  # the k-th column's multipliers, by row
    U: Factor  # the k-th column of U above its diagonal, by elimination order
    diagonal: Array
    slack: NDArray[np.bool_]  # whether a row's own w is basic
    place: Index64  # the position of a row in order, -1 if it is not there
    column: Array  # workspace for the current column: zeros between factorisations
    listed: Index64  # rows of its nonzeros
    seen: Index64  # for each row, the variable whose column listed it last
    update: Array
    updated: Index64


@kernel
def new_basis(n, storage):  # type: ignore[no-untyped-def]
    """A basis of n columns, all w and not yet factorised. storage: the entries for which each factor has space."""
    L = Factor(np.zeros(n + 1, np.int64), np.empty(storage, np.int64), np.empty(storage))
    U = Factor(np.zeros(n + 1, np.int64), np.empty(storage, np.int64), np.empty(storage))
    rows, values = np.zeros((5, n), np.int64), np.zeros((2, n))
    return LUBasis(
        np.arange(n, 2 * n), np.zeros(3, np.int64), rows[0], rows[1], L, U, values[0], np.zeros(n, np.bool_), rows[2],
        values[1], rows[3], rows[4], np.empty((UPDATES, n)), np.zeros(UPDATES, np.int64),
    )  # fmt: skip


@kernel
def room(n, entries):  # type: ignore[no-untyped-def]
    """Storage of a factor that suffices for most bases, for n unknowns and so many entries of M."""
    return min(n * n, max(DENSE * DENSE, FILL * entries))


@part
def overflowed(basis):  # type: ignore[no-untyped-def]
    """Whether the last factorisation was not finished, for lack of storage or time."""
    return basis.size[2] > 0


@part
def set_complementary_basis(basis, A):  # type: ignore[no-untyped-def]
    """Make head the complementary basis of the set A (n, bool): z_i where A_i, w_i elsewhere."""
    for i in range(len(A)):
        basis.head[i] = i if A[i] else i + len(A)


@part
def basic_z(basis, A):  # type: ignore[no-untyped-def]
    """Overwrite A (n, bool) with whether each z is basic."""
    fill(A, False)
    for i in range(len(A)):
        if basis.head[i] < len(A):
            A[basis.head[i]] = True


@kernel
def column(columns, j, y):  # type: ignore[no-untyped-def]
    """Overwrite y (n,) with the column of variable j; return its largest magnitude."""
    n = len(y)
    if j == 2 * n:
        put(y, columns.cover)
    elif j >= n:
        fill(y, 0.0)
        y[j - n] = -1.0
    else:
        fill(y, 0.0)
        for k in range(columns.start[j], columns.start[j + 1]):
            y[columns.rows[k]] = columns.column[k]
    return largest_magnitude(y)


@part
def largest_magnitude(y):  # type: ignore[no-untyped-def]
    """max |y_i|; infinity if an entry is NaN."""
    most = 0.0
    for i in range(len(y)):
        if not abs(y[i]) <= most:
            most = abs(y[i])
            if np.isnan(most):
                return np.inf
    return most


@part
def factorise_basis(basis, columns, floor, until):  # type: ignore[no-untyped-def]
    """Factorise the basis head, whose variables are reordered; return the number of linearly dependent columns.

    A column counts as dependent if elimination leaves no more than `floor` of its size. It is replaced by the w of a row
    without a pivot, so that head is always a regular basis. Columns that exceed the storage, or are not reached before the
    deadline `until`, are replaced as well.
    """
    head, order, L, U, slack, place, y = basis.head, basis.order, basis.L, basis.U, basis.slack, basis.place, basis.column
    n, listed, seen = len(head), basis.listed, basis.seen
    core = np.zeros(2 * n + 1, np.bool_)
    for i in range(n):
        core[head[i]] = True
    for i in range(n):
        slack[i] = core[n + i]
        core[n + i] = False
        head[i], place[i], seen[i] = n + i, -1, -1
    m = dependent = 0
    basis.size[2] = 0
    for j in range(2 * n + 1):
        if not core[j]:
            continue
        at, u_at = L.start[m], U.start[m]
        if at + n - m > len(L.value) or u_at + m > len(U.value) or late(until):
            basis.size[2] = 1
            dependent += 1
            continue
        filled, least, first = scatter(columns, j, y, listed, seen, place, slack)
        least *= floor
        for k in range(first, m):  # y is zero in the pivot rows of earlier columns
            u = y[order[k]]
            if u != 0.0:
                U.number[u_at], U.value[u_at] = k, u
                u_at += 1
                for a in range(L.start[k], L.start[k + 1]):
                    i = L.number[a]
                    if seen[i] != j:
                        listed[filled], seen[i] = i, j
                        filled += 1
                    y[i] -= u * L.value[a]
        p = -1
        for a in range(filled):
            i = listed[a]
            if place[i] < 0 and (abs(y[i]) > least or (p > i and abs(y[i]) == least)):
                p, least = i, abs(y[i])
        if p >= 0 and j < n and place[j] < 0 and abs(y[j]) >= ON_DIAGONAL * least:
            p = j
        if p < 0:
            dependent += 1
        else:
            order[m], basis.core[m], head[p], place[p], basis.diagonal[m] = p, j, j, m, y[p]
            for a in range(filled):
                i = listed[a]
                if place[i] < 0 and y[i] != 0.0:
                    L.number[at], L.value[at] = i, y[i] / y[p]
                    at += 1
            m += 1
            L.start[m], U.start[m] = at, u_at
        for a in range(filled):
            y[listed[a]] = 0.0
    for i in range(n):
        slack[i] = slack[i] or place[i] < 0
    basis.size[0], basis.size[1] = m, 0
    return dependent


@part
def scatter(columns, j, y, listed, seen, place, slack):  # type: ignore[no-untyped-def]
    """Write the core rows of the column of z_j or t to y, which must be zero, and list its nonzeros.

    Returns their number, the largest magnitude in all rows of the column, and the least place of the listed rows.
    """
    n, count, most, first = len(y), 0, 0.0, len(y)
    begin, end = (0, n) if j == 2 * n else (columns.start[j], columns.start[j + 1])
    for k in range(begin, end):
        i, entry = (k, columns.cover[k]) if j == 2 * n else (columns.rows[k], columns.column[k])
        most = np.inf if np.isnan(entry) else max(most, abs(entry))
        if entry != 0.0 and not slack[i]:
            y[i], listed[count], seen[i] = entry, i, j
            count += 1
            if place[i] >= 0:
                first = min(first, place[i])
    return count, most, first


@part
def ftran(basis, columns, y):  # type: ignore[no-untyped-def]
    """Overwrite y with the solution x of B x = y, indexed by position."""
    order, L, U, slack, n = basis.order, basis.L, basis.U, basis.slack, len(y)
    m, updates = basis.size[0], basis.size[1]
    x = np.empty(m)
    for k in range(m):
        x[k] = y[order[k]]
        if x[k] != 0.0:
            for a in range(L.start[k], L.start[k + 1]):
                y[L.number[a]] -= x[k] * L.value[a]
    for k in range(m - 1, -1, -1):
        if x[k] != 0.0:
            x[k] /= basis.diagonal[k]
            for a in range(U.start[k], U.start[k + 1]):
                x[U.number[a]] -= x[k] * U.value[a]
    for i in range(n):
        if slack[i]:
            y[i] = -y[i]
    for k in range(m):
        if x[k] != 0.0:
            j = basis.core[k]
            begin, end = (0, n) if j == 2 * n else (columns.start[j], columns.start[j + 1])
            for a in range(begin, end):
                i, entry = (a, columns.cover[a]) if j == 2 * n else (columns.rows[a], columns.column[a])
                if slack[i]:
                    y[i] += x[k] * entry
    for k in range(m):
        y[order[k]] = x[k]
    for k in range(updates):
        d, p = basis.update[k], basis.updated[k]
        if y[p] != 0.0:
            step = y[p] / d[p]
            for i in range(n):
                y[i] -= step * d[i]
            y[p] = step


@part
def replace_column(basis, p, j, d):  # type: ignore[no-untyped-def]
    """Replace the variable at position p by j, whose column is d in terms of the basis; return whether to refactorise."""
    k = basis.size[1]
    basis.head[p], basis.updated[k] = j, p
    put(basis.update[k], d)
    basis.size[1] = k + 1
    return k + 1 == len(basis.updated)


@part
def basic_point(basis, columns, b, z, w):  # type: ignore[no-untyped-def]
    """Overwrite z and w (n,) with the basic solution of M z - w = b, with t = 0."""
    n = len(b)
    x = np.empty(n)
    put(x, b)
    ftran(basis, columns, x)
    fill(z, 0.0)
    fill(w, 0.0)
    for i in range(n):
        j = basis.head[i]
        if j < n:
            z[j] = x[i]
        elif j < 2 * n:
            w[j - n] = x[i]


@part
def orientation(basis):  # type: ignore[no-untyped-def]
    """The sign of det M_AA, where A are the basic z of a complementary basis just factorised; +1 if A is empty."""
    sign = 1
    seat = np.empty(len(basis.head), np.int64)
    put(seat, basis.head)
    for k in range(basis.size[0]):
        sign = -sign if basis.diagonal[k] < 0.0 else sign
    for k in range(basis.size[0]):
        i = basis.order[k]
        while seat[i] != i:  # undo the row exchanges one by one
            j = seat[i]
            seat[i], seat[j] = seat[j], j
            sign = -sign
    return sign
