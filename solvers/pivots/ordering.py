"""Reverse Cuthill-McKee order: the unknowns level by level from one with few neighbours, which gives a banded matrix.

From the unknown with the fewest neighbours its neighbours are numbered, those with fewer neighbours first, then theirs; the
numbers are reversed at the end (George 1971), which leaves less fill. The graph is that of M + M'.
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.pivots.inverse_basis import symmetrised


@kernel
def in_order(start, column, value, q, D, theta, weight):  # type: ignore[no-untyped-def]
    """A scaled LCP with its unknowns in this order.

    M by rows, D and theta: solvers.pivots.scaling. Returns D M D by columns (start, row, value), rows ascending, D q / theta,
    the weight (n,), the order (n,) and, not in it, theta D.
    """
    n = len(q)
    degree, first, neighbour = _graph(*symmetrised(start, column, value, D))
    order = _by_levels(first, neighbour, degree)
    own_q, own_weight, stretch = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        own_q[i], own_weight[i] = D[order[i]] * q[order[i]] / theta, weight[order[i]]
        stretch[i] = theta * D[i]
    begin, row, entry = _reordered(start, column, value, D, order)
    return begin, row, entry, own_q, own_weight, order, stretch


@part
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


@part
def _by_levels(start, neighbour, degree):  # type: ignore[no-untyped-def]
    n = len(degree)
    order, numbered, end = np.empty(n, np.int64), np.zeros(n, np.bool_), 0
    for seed in _by_degree(degree):
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
    for i in range(n // 2):
        order[i], order[n - 1 - i] = order[n - 1 - i], order[i]
    return order


@part
def _by_degree(degree):  # type: ignore[no-untyped-def]
    """The unknowns by their degree, those of the same one as they come."""
    n, most = len(degree), 0
    for i in range(n):
        most = max(most, degree[i])
    begin, order = np.zeros(most + 2, np.int64), np.empty(n, np.int64)
    for i in range(n):
        begin[degree[i] + 1] += 1
    for k in range(most + 1):
        begin[k + 1] += begin[k]
    for i in range(n):
        order[begin[degree[i]]] = i
        begin[degree[i]] += 1
    return order


@part
def _reordered(start, column, value, D, order):  # type: ignore[no-untyped-def]
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
