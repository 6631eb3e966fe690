"""Bases of an LCP's columns: one LU factorisation, updated with every pivot.

Methods that pivot on w = M z + q work with n columns chosen from

    z_i:  M e_i + prox_i e_i        w_i:  -e_i        t:  cover

numbered i, n + i and 2n. Where a basis holds w_i it leaves row i to it, so that only the other rows, the core, need an LU.
Its columns are eliminated from the left (Gilbert and Peierls 1988) in dense storage, of which only the span of nonzeros is
touched: with M in reverse Cuthill-McKee order a banded problem costs what its band costs. A pivot is a product-form update
(Dantzig and Orchard-Hays 1954); after UPDATES of them the basis is refactorised, which also removes the accumulated
round-off. Values are in M's units; scale M first.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.pivots.vectors import fill, put

UPDATES = 96  # of a factorisation; each costs n products in every later solve, n numbers, and its rounding


class Columns(NamedTuple):
    """The columns to choose from: M (n, n) compressed by columns, prox (n,) added to its diagonal, cover (n,)."""

    start: Index64
    row: Index64
    value: Array
    prox: Array
    cover: Array


class LUBasis(NamedTuple):
    """head (n,): the variable that stands at position i. The rest is its factorisation, internal to this file."""

    head: Index64
    size: Index64  # of the core, of the updates
    order: Index64  # the row, and so the position, of the k-th core column
    L: Array  # L[k]: the k-th column's multipliers, by row
    U: Array  # U[k]: the k-th column of U above its diagonal, by elimination order
    diagonal: Array
    span: Index64  # first row and row after the last of L[k], first entry of U[k]
    slack: NDArray[np.bool_]  # rows left to their own w
    update: Array
    updated: Index64


def new_basis(n: int) -> LUBasis:
    """Storage for a basis of n columns with at most UPDATES updates; all w, not yet factorised."""
    whole = np.int64
    head, order, updated = np.arange(n, 2 * n), np.zeros(n, whole), np.zeros(UPDATES, whole)
    square, span = np.empty((2, n, n)), np.zeros((n, 3), whole)
    return LUBasis(
        head,
        np.zeros(2, whole),
        order,
        square[0],
        square[1],
        np.zeros(n),
        span,
        np.zeros(n, bool),
        np.empty((UPDATES, n)),
        updated,
    )


@kernel
def set_complementary_basis(basis, A):  # type: ignore[no-untyped-def]
    """Make head the complementary basis of the set A (n, bool): z_i where A_i, w_i elsewhere."""
    for i in range(len(A)):
        basis.head[i] = i if A[i] else i + len(A)


@kernel
def basic_z(basis, A):  # type: ignore[no-untyped-def]
    """Write over A (n, bool) which z the basis holds."""
    fill(A, False)
    for i in range(len(A)):
        if basis.head[i] < len(A):
            A[basis.head[i]] = True


@kernel
def column(columns, j, y):  # type: ignore[no-untyped-def]
    """Write the column of variable j over y (n,); its largest magnitude."""
    n = len(y)
    if j == 2 * n:
        put(y, columns.cover)
    elif j >= n:
        fill(y, 0.0)
        y[j - n] = -1.0
    else:
        fill(y, 0.0)
        for k in range(columns.start[j], columns.start[j + 1]):
            y[columns.row[k]] = columns.value[k]
        y[j] += columns.prox[j]
    return largest_magnitude(y)


@part
def largest_magnitude(y):  # type: ignore[no-untyped-def]
    """max |y_i|; infinity if y holds a NaN."""
    most = 0.0
    for i in range(len(y)):
        if not abs(y[i]) <= most:
            most = abs(y[i])
            if np.isnan(most):
                return np.inf
    return most


@kernel
def factorise_basis(basis, columns, floor):  # type: ignore[no-untyped-def]
    """Factorise head, placing its variables anew; the number of linearly dependent columns.

    A column of which elimination leaves no more than `floor` of its size counts as dependent. The w of a row that is then
    left over takes its place, so that head is a regular basis in any case.
    """
    head, order, L, U, span, slack = basis.head, basis.order, basis.L, basis.U, basis.span, basis.slack
    n = len(head)
    core = np.zeros(2 * n + 1, np.bool_)
    for i in range(n):
        core[head[i]] = True
    for i in range(n):
        slack[i] = core[n + i]
        core[n + i] = False
        head[i] = n + i
    free = np.empty(n, np.bool_)
    for i in range(n):
        free[i] = not slack[i]
    m = dependent = 0
    for j in range(2 * n + 1):
        if not core[j]:
            continue
        y = L[m]
        least = floor * column(columns, j, y)
        span[m, 2] = m
        for k in range(m):
            u = y[order[k]]
            U[m, k] = u
            if u != 0.0:
                span[m, 2] = min(span[m, 2], k)
                for i in range(span[k, 0], span[k, 1]):
                    y[i] -= u * L[k, i]
                y[order[k]] = 0.0
        p = -1
        for i in range(n):
            if free[i] and abs(y[i]) > least:
                p, least = i, abs(y[i])
        if p < 0:
            dependent += 1
            continue
        order[m], head[p], free[p], basis.diagonal[m] = p, j, False, y[p]
        y[p] = 0.0
        span[m, 0] = n
        for i in range(n):
            if y[i] != 0.0:
                y[i] /= basis.diagonal[m]
                span[m, 0], span[m, 1] = min(span[m, 0], i), i + 1
        m += 1
    for i in range(n):
        slack[i] = slack[i] or free[i]
    basis.size[0], basis.size[1] = m, 0
    return dependent


@kernel
def ftran(basis, y):  # type: ignore[no-untyped-def]
    """Solve B x = y, in place, x by position."""
    order, L, U, span = basis.order, basis.L, basis.U, basis.span
    m, updates = basis.size[0], basis.size[1]
    x = np.empty(m)
    for k in range(m):
        x[k] = y[order[k]]
        if x[k] != 0.0:
            for i in range(span[k, 0], span[k, 1]):
                y[i] -= x[k] * L[k, i]
    for k in range(m - 1, -1, -1):
        if x[k] != 0.0:
            x[k] /= basis.diagonal[k]
            for i in range(span[k, 2], k):
                x[i] -= x[k] * U[k, i]
    for i in range(len(y)):
        if basis.slack[i]:
            y[i] = -y[i]
    for k in range(m):
        y[order[k]] = x[k]
    for k in range(updates):
        d, p = basis.update[k], basis.updated[k]
        if y[p] != 0.0:
            step = y[p] / d[p]
            for i in range(len(y)):
                y[i] -= step * d[i]
            y[p] = step


@kernel
def replace_column(basis, p, j, d):  # type: ignore[no-untyped-def]
    """Let variable j take position p, d being its column in terms of the basis; whether a factorisation is due."""
    k = basis.size[1]
    basis.head[p], basis.updated[k] = j, p
    put(basis.update[k], d)
    basis.size[1] = k + 1
    return k + 1 == len(basis.updated)


@part
def basic_point(basis, b, z, w):  # type: ignore[no-untyped-def]
    """Write over z and w (n,) the basis's own solution of M z - w = b, t = 0."""
    n = len(b)
    x = np.empty(n)
    put(x, b)
    ftran(basis, x)
    fill(z, 0.0)
    fill(w, 0.0)
    for i in range(n):
        j = basis.head[i]
        if j < n:
            z[j] = x[i]
        elif j < 2 * n:
            w[j - n] = x[i]


@kernel
def orientation(basis):  # type: ignore[no-untyped-def]
    """The sign of det M_AA, A the z of a complementary basis just factorised; +1 where there are none."""
    sign = 1
    seat = np.empty(len(basis.head), np.int64)
    put(seat, basis.head)
    for k in range(basis.size[0]):
        sign = -sign if basis.diagonal[k] < 0.0 else sign
    for k in range(basis.size[0]):
        i = basis.order[k]
        while seat[i] != i:  # undo the row exchanges, one by one
            j = seat[i]
            seat[i], seat[j] = seat[j], j
            sign = -sign
    return sign


@part
def add_columns_product(columns, z, y):  # type: ignore[no-untyped-def]
    """y += M z."""
    for j in range(len(z)):
        if z[j] != 0.0:
            for k in range(columns.start[j], columns.start[j + 1]):
                y[columns.row[k]] += z[j] * columns.value[k]
