"""Elimination of the first p columns of a dense front, the pivots, eight columns at a time.

    [ P  R ]        P = L U with rows interchanged,        S <- S - C P^-1 R.
    [ C  S ]

The front (w, w) is overwritten with the factors: L, whose unit diagonal is not stored, extends down through C, U to the right
through R, and the diagonal holds the inverse pivots. The remaining S is added to the parent's front.

A - B C is computed by tiles with sums kept in registers: a tile of A, four rows by two vectors of eight, is read once, updated
for every column of B and row of C, and written once, so that nearly every instruction multiplies and adds. Plain loops compile
to code that is several times slower, above all for the last columns, which do not fill a vector and are processed one by one;
here the same instructions process them under a mask. (Goto and van de Geijn 2008, for sums in registers.)
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, lean
from frictionbench.solvers.sparse_lu.minimum_degree import Index
from frictionbench.solvers.sparse_lu.vectors import LANES, load, minus, store


@inlined
def pivot(F: Array, k: int, p: int, floor: float) -> tuple[int, int]:
    """Bring the largest of F[k:p, k] to the diagonal and invert it; return its former row, and whether it was replaced."""
    best, replaced = k, 0
    for i in range(k + 1, p):
        if abs(F[i, k]) > abs(F[best, k]):
            best = i
    if best != k:
        for j in range(F.shape[1]):
            F[k, j], F[best, j] = F[best, j], F[k, j]
    if not abs(F[k, k]) >= floor:
        F[k, k] = -floor if F[k, k] < 0 else floor
        replaced = 1
    F[k, k] = 1 / F[k, k]
    return best, replaced


@lean
def eliminate(F: Array, p: int, swap: Index, floor: float) -> int:
    """Eliminate p columns of a wide front; return the number of pivots replaced.

    In a block of eight columns each pivot updates all rows below. Then the eight rows of U are completed and update the rest.
    """
    w, replaced = len(F), 0
    for begin in range(0, p, LANES):
        end = min(begin + LANES, p)
        for k in range(begin, end):
            swap[k], small = pivot(F, k, p, floor)
            replaced += small
            inverse, n = F[k, k], end - k - 1
            row = load(F, k, k + 1, n)
            for i in range(k + 1, w):
                a = F[i, k] * inverse
                F[i, k] = a
                store(F, i, k + 1, n, minus(load(F, i, k + 1, n), a, row))
        for i in range(begin + 1, end):
            subtract_product(F, i, i + 1, end, w, begin, i)
        subtract_product(F, end, w, end, w, begin, end)
    return replaced


@lean
def extend_add(F: Array, p: int, above: NDArray[np.uint32], G: Array) -> None:
    """Add the remaining S of a front to its parent G, up to eight neighbouring columns at a time."""
    w, j = len(F), p
    while j < w:
        n, column = 1, above[j]
        while n < LANES and j + n < w and above[j + n] == column + n:
            n += 1
        for i in range(p, w):
            store(G, above[i], column, n, minus(load(G, above[i], column, n), -1.0, load(F, i, j, n)))
        j += n


@lean
def subtract_product(F: Array, top: int, bottom: int, left: int, right: int, begin: int, end: int) -> None:
    """F[top:bottom, left:right] -= F[top:bottom, begin:end] F[begin:end, left:right]."""
    for j in range(left, right, 2 * LANES):
        m, n, o = min(LANES, right - j), max(0, min(LANES, right - j - LANES)), j + LANES
        i = top
        while i + 4 <= bottom:
            a, b, c, d = load(F, i, j, m), load(F, i + 1, j, m), load(F, i + 2, j, m), load(F, i + 3, j, m)
            e, f, g, h = load(F, i, o, n), load(F, i + 1, o, n), load(F, i + 2, o, n), load(F, i + 3, o, n)
            for k in range(begin, end):
                x, y = load(F, k, j, m), load(F, k, o, n)
                a, e = minus(a, F[i, k], x), minus(e, F[i, k], y)
                b, f = minus(b, F[i + 1, k], x), minus(f, F[i + 1, k], y)
                c, g = minus(c, F[i + 2, k], x), minus(g, F[i + 2, k], y)
                d, h = minus(d, F[i + 3, k], x), minus(h, F[i + 3, k], y)
            _store_pair(F, i, j, m, a, n, e)
            _store_pair(F, i + 1, j, m, b, n, f)
            _store_pair(F, i + 2, j, m, c, n, g)
            _store_pair(F, i + 3, j, m, d, n, h)
            i += 4
        while i < bottom:
            a, e = load(F, i, j, m), load(F, i, o, n)
            for k in range(begin, end):
                a, e = minus(a, F[i, k], load(F, k, j, m)), minus(e, F[i, k], load(F, k, o, n))
            _store_pair(F, i, j, m, a, n, e)
            i += 1


@inlined
def _store_pair(F: Array, i: int, j: int, m: int, left: Array, n: int, right: Array) -> None:
    store(F, i, j, m, left)
    store(F, i, j + LANES, n, right)
