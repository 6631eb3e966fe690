"""Reverse Cuthill-McKee order: the unknowns level by level from one of few neighbours, so that a matrix becomes a band.

From the unknown with the fewest neighbours its neighbours are numbered, those with fewer neighbours first, then theirs; the
numbers are reversed at the end (George 1971), which leaves less fill. The graph is that of M + M'.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from problems.rows import Rows
from solvers.pivots.inverse_basis import Matrix

Order = NDArray[np.int64]


def reverse_cuthill_mckee(M: Matrix) -> Order:
    """The unknowns (n,) in their order, for a matrix on its symmetrised pattern."""
    degree, start, neighbour = _graph(*M)
    return _by_levels(start, neighbour, degree, np.argsort(degree))


def in_order(M: Rows, D: NDArray[np.float64], order: Order) -> tuple[Order, Order, NDArray[np.float64]]:
    """D M D with rows and columns in this order, by columns: (start, row, value), rows ascending."""
    return _in_order(*M, D, order)


@njit(cache=True, no_cfunc_wrapper=True)
def _graph(begin, rows, column, row):  # type: ignore[no-untyped-def]
    """How many neighbours each unknown has, itself counted twice, and which: neighbour[start[i]:start[i+1]], ascending."""
    n = len(begin) - 1
    degree, start, neighbour, at = np.zeros(n, np.int32), np.zeros(n + 1, np.int64), np.empty(len(rows), np.int64), 0
    for i in range(n):
        for k in range(begin[i], begin[i + 1]):
            if column[k] + row[k] != 0:
                neighbour[at] = rows[k]
                at += 1
                degree[i] += 2 if rows[k] == i else 1
        start[i + 1] = at
    return degree, start, neighbour


@njit(cache=True, no_cfunc_wrapper=True)
def _by_levels(start, neighbour, degree, seeds):  # type: ignore[no-untyped-def]
    n = len(degree)
    order, numbered, end = np.empty(n, np.int64), np.zeros(n, np.bool_), 0
    for seed in seeds:
        if numbered[seed]:
            continue
        order[end], numbered[seed], at = seed, True, end
        end += 1
        while at < end:
            first = end
            for k in range(start[order[at]], start[order[at] + 1]):
                j = neighbour[k]
                if not numbered[j]:
                    numbered[j], here = True, end
                    while here > first and degree[order[here - 1]] > degree[j]:
                        order[here] = order[here - 1]
                        here -= 1
                    order[here] = j
                    end += 1
            at += 1
    return order[::-1].copy()


@njit(cache=True, no_cfunc_wrapper=True)
def _in_order(start, column, value, D, order):  # type: ignore[no-untyped-def]
    n = len(order)
    place, begin = np.empty(n, np.int64), np.zeros(n + 2, np.int64)
    for i in range(n):
        place[order[i]] = i
    for k in range(len(column)):
        begin[place[column[k]] + 2] += 1
    for i in range(n):
        begin[i + 2] += begin[i + 1]
    row, entry = np.empty(len(column), np.int64), np.empty(len(column))
    for i in range(n):
        for k in range(start[order[i]], start[order[i] + 1]):
            j = place[column[k]] + 1
            row[begin[j]], entry[begin[j]] = i, D[order[i]] * value[k] * D[column[k]]
            begin[j] += 1
    return begin[: n + 1], row, entry
