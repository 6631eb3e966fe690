"""The basis of Lemke's method, stored as the inverse of its active part.

Lemke's method moves among solutions of

    w = M z + d z0 + q,      one of w_i, z_i basic for every i but one (the missing pair), and z0 basic.

Rows whose w_i is basic only define that w_i. The matrix to be inverted is the kernel K, with the rows whose w_i is nonbasic and
the columns of the basic z_j and of z0. It is square, because as many w are nonbasic as z, including z0, are basic. InverseBasis
stores K^-1. A pivot replaces, adds or drops a row and a column of it by a rank-one update. If M is sparse and few z are basic,
as in friction problems, this is far less work than a tableau of n rows.

Vectors over the basis are indexed by pair: entry i belongs to w_i or z_i, whichever is basic, and entry n to z0.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean, part
from frictionbench.problems.rows import Index64


class Matrix(NamedTuple):
    """A square matrix on its symmetrised pattern.

    For start[j] <= e < start[j+1] and i = rows[e], column[e] is M_ij and row[e] is M_ji. Row numbers are unsigned and short:
    they are read all the time, need no check for a negative index, and take half the memory.
    """

    start: Index64
    rows: NDArray[np.uint32]
    column: Array
    row: Array


class InverseBasis(NamedTuple):
    """A basis of the columns of M (n, n) and d (n,); the arrays after d may be longer, for larger problems.

    inverse[c, r], for r, c < size[0], is (K^-1)_rc: r belongs to z_{z[r]} (z0 if z[r] = n), c to the nonbasic w_{w[c]}.
    row[j] is the r of z_j, column[i] the c of w_i, -1 if there is none. work (4, n+1) is workspace.
    """

    M: Matrix
    d: Array
    inverse: Array
    z: Index64
    w: Index64
    row: Index64
    column: Index64
    size: Index64
    work: Array


@kernel
def symmetrised(indptr, indices, data):  # type: ignore[no-untyped-def]
    """The Matrix of a matrix stored by rows."""
    n, entries = len(indptr) - 1, len(indices)
    below = np.zeros(n + 1, np.int64)  # where the columns of M start, by counting
    for k in range(entries):
        below[indices[k] + 1] += 1
    for j in range(n):
        below[j + 1] += below[j]
    free = np.empty(n, np.int64)
    for j in range(n):
        free[j] = below[j]
    above, value = np.empty(entries, np.int64), np.empty(entries)
    for i in range(n):
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            above[free[j]], value[free[j]] = i, data[k]
            free[j] += 1
    start, at = np.zeros(n + 1, np.int64), 0
    rows, column, row = np.empty(2 * entries, np.uint32), np.zeros(2 * entries), np.zeros(2 * entries)
    for j in range(n):  # merge row j and column j
        k, m = indptr[j], below[j]
        while k < indptr[j + 1] or m < below[j + 1]:
            right = indices[k] if k < indptr[j + 1] else n
            down = above[m] if m < below[j + 1] else n
            i = min(right, down)
            rows[at] = i
            if right == i:
                row[at] = data[k]
                k += 1
            if down == i:
                column[at] = value[m]
                m += 1
            at += 1
        start[j + 1] = at
    return Matrix(start, rows[:at], column[:at], row[:at])


@part
def slack_basis(M: Matrix, n: int) -> InverseBasis:
    """The basis of all w, with d = 0, for up to n unknowns."""
    index, vectors = np.empty((5, n + 1), np.int64), np.zeros((5, n + 1))
    basis = InverseBasis(
        M, vectors[0, :n], np.empty((n + 1, n + 1)), index[0], index[1], index[2], index[3], index[4], vectors[1:]
    )
    make_slack(basis)
    return basis


@lean
def make_slack(basis: InverseBasis) -> None:
    """Make all w basic."""
    for i in range(len(basis.d) + 1):
        basis.z[i] = basis.w[i] = basis.row[i] = basis.column[i] = -1
    basis.size[0] = 0


@lean
def transform(basis: InverseBasis, rhs: Array, a: Array, accuracy: float) -> tuple[float, float]:
    """a (n+1,) = (inverse of the whole basis) rhs, by K^-1 and iterative refinement; returns the relative defect and the size.

    With rhs = M_p or -e_p, a is the rate at which the basic variables fall as z_p or w_p enters; with rhs = -q it is their
    values. The size is the largest entry of the z part and of rhs. Refinement continues while the defect relative to the size
    exceeds `accuracy`.
    """
    M, d, k, G, g, out = basis.M, basis.d, basis.size[0], basis.inverse, basis.work[0], basis.work[2]
    n = len(d)
    for i in range(n):
        out[i] = -rhs[i]
    for i in range(n + 1):
        a[i] = 0.0
    for r in range(k):
        g[r] = 0.0
    relative, size, sweeps = np.inf, 0.0, 0
    while relative > accuracy and sweeps < 4:
        sweeps += 1
        # a_z -= K^-1 out, and then out = M a_z + d a_0 - rhs, which is 0 in the rows of nonbasic w and a_w in the others.
        for c in range(k):
            entry = out[basis.w[c]]
            if entry != 0.0:
                for r in range(k):
                    g[r] -= entry * G[c, r]
        size = 0.0
        for r in range(k):
            a[basis.z[r]] = g[r]
            size = max(size, abs(g[r]))
        for i in range(n):
            out[i] = a[n] * d[i] - rhs[i]
        for r in range(k):
            j, entry = basis.z[r], g[r]
            if entry != 0.0 and j < n:
                for e in range(M.start[j], M.start[j + 1]):
                    out[M.rows[e]] += M.column[e] * entry
        defect = 0.0
        for c in range(k):
            size = max(size, abs(rhs[basis.w[c]]))
            defect = max(defect, abs(out[basis.w[c]]))
        relative = defect / size if size > 0.0 else 0.0
    for i in range(n):
        if basis.column[i] < 0:
            a[i] = out[i]
    return relative, size


@lean
def exchange_pair(basis: InverseBasis, a: Array, p: int, z_enters: bool, s: int) -> None:
    """Let z_p (z0 if p = n) or w_p enter, with its transformed column a, and the basic member of pair s leave."""
    M, d, k, G, g, h = basis.M, basis.d, basis.size[0], basis.inverse, basis.work[0], basis.work[1]
    n = len(d)
    out = basis.row[s]  # -1 where w_s leaves
    pivot = a[s]

    # The rank-one update: the pivot row in the columns of K^-1, divided by the pivot, times the entering column in its rows.
    if out >= 0:
        for c in range(k):
            g[c] = G[c, out] / pivot
    else:
        for c in range(k):
            g[c] = 0.0
        for e in range(M.start[s], M.start[s + 1]):
            r = basis.row[M.rows[e]]
            if r >= 0:
                share = M.row[e] / pivot
                for c in range(k):
                    g[c] += share * G[c, r]
        r = basis.row[n]
        if r >= 0:
            share = d[s] / pivot
            for c in range(k):
                g[c] += share * G[c, r]
    for r in range(k):
        h[r] = a[basis.z[r]]
    if out >= 0:
        h[out] = 0.0
    for c in range(k):
        entry = g[c]
        if entry != 0.0:
            for r in range(k):
                G[c, r] -= entry * h[r]

    column = k if z_enters else basis.column[p]
    if not z_enters:
        basis.column[p] = -1
    if out < 0:  # w_s becomes nonbasic and takes a column, w_p's if that one is free
        for r in range(k):
            G[column, r] = h[r] / pivot
        basis.w[column] = s
        basis.column[s] = column
    elif not z_enters and column < k - 1:  # one column fewer: the last one fills the gap
        for r in range(k):
            G[column, r] = G[k - 1, r]
        basis.w[column] = basis.w[k - 1]
        basis.column[basis.w[column]] = column
    if z_enters:
        row = out if out >= 0 else k
        for c in range(k):
            G[c, row] = g[c]
        if out < 0:
            G[k, k] = -1.0 / pivot
            basis.size[0] = k + 1
        basis.z[row] = p
        basis.row[p] = row
    elif out >= 0:  # one row fewer
        if out < k - 1:
            for c in range(k):
                G[c, out] = G[c, k - 1]
            basis.z[out] = basis.z[k - 1]
            basis.row[basis.z[out]] = out
        basis.size[0] = k - 1
    if out >= 0:
        basis.row[s] = -1


@part
def refactor(basis: InverseBasis) -> bool:
    """Recompute K^-1 by Gauss-Jordan elimination with row exchanges; False if K is singular to working accuracy."""
    M, d, k = basis.M, basis.d, basis.size[0]
    n = len(d)
    K = np.zeros((k, k))
    for c in range(k):
        j = basis.z[c]
        if j == n:
            for r in range(k):
                K[r, c] = d[basis.w[r]]
        else:
            for e in range(M.start[j], M.start[j + 1]):
                r = basis.column[M.rows[e]]
                if r >= 0:
                    K[r, c] = M.column[e]
    order = np.empty(k, np.int64)
    for j in range(k):
        order[j] = j
    for j in range(k):
        best = j
        for r in range(j + 1, k):
            if abs(K[r, j]) > abs(K[best, j]):
                best = r
        pivot = K[best, j]
        if not abs(pivot) > 1e-14:
            return False
        for c in range(k):
            K[j, c], K[best, c] = K[best, c], K[j, c]
        order[j], order[best] = order[best], order[j]
        K[j, j] = 1.0
        for c in range(k):
            K[j, c] /= pivot
        for r in range(k):
            factor = K[r, j]
            if r != j and factor != 0.0:
                K[r, j] = 0.0
                for c in range(k):
                    K[r, c] -= factor * K[j, c]
    for r in range(k):
        for j in range(k):
            basis.inverse[order[j], r] = K[r, j]
    return True


@part
def invert(basis: InverseBasis, active: Index64) -> bool:
    """Make the z of these indices basic in a slack basis, and their w nonbasic; False if the new basis is singular."""
    for c in range(len(active)):
        j = active[c]
        basis.z[c] = basis.w[c] = j
        basis.row[j] = basis.column[j] = c
    basis.size[0] = len(active)
    return refactor(basis)
