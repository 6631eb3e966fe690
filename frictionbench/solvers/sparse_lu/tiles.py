"""Dense blocks of a row-major matrix, in vector registers.

A - B C with its sums kept in registers: a tile of A, four rows by two vectors of eight, is read once, takes up a row of C for
each column of B, and is written once, so that nearly every instruction multiplies and adds. The compiler does not find this
form itself: from plain loops it generates code several times slower, most of all for the last columns that do not fill
a vector, which it processes one by one; here they use the same instruction under a mask.

Reference: Goto and van de Geijn 2008 (sums in registers).
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, part
from frictionbench.solvers.sparse_lu.vectors import LANES, load, minus, plus, store, total


@inlined
def dot(F: Array, i: int, j: int, G: Array, k: int, m: int, n: int) -> float:
    """The product of F[i, j : j + n] and G[k, m : m + n], summed by every eighth number."""
    vector = load(F, i, j, 0)
    for at in range(0, n, LANES):
        left = min(LANES, n - at)
        vector = plus(vector, load(F, i, j + at, left), load(G, k, m + at, left))
    return total(vector)


@part
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
