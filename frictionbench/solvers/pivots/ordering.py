"""The unknowns of an LCP in an order of elimination with little fill: minimum degree on the graph of the contacts."""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.sparse_lu.minimum_degree import minimum_degree


@kernel
def in_order(start, column, value, q, D, theta, weight, nc):  # type: ignore[no-untyped-def]
    """A scaled LCP of nc contacts, or a bare one with nc = 0, with its unknowns in this order, a contact's together.

    M by rows, D and theta: solvers.pivots.scaling. Returns D M D by columns (start, row, value), rows ascending, D q / theta,
    the weight (n,), the order (n,) and, not in it, theta D.
    """
    n = len(q)
    order = _least_fill(start, column, n, nc)
    own_q, own_weight, stretch = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        own_q[i], own_weight[i] = D[order[i]] * q[order[i]] / theta, weight[order[i]]
        stretch[i] = theta * D[i]
    begin, row, entry = _reordered(start, column, value, D, order)
    return begin, row, entry, own_q, own_weight, order, stretch


@part
def _least_fill(start, column, n, nc):  # type: ignore[no-untyped-def]
    groups = nc if nc else n
    group = np.empty(
        n, np.int64
    )  # unknowns are ordered by contact: normal impulses, tangential ones, lambda (problems.forms.lcp)
    facets = n // nc - 2 if nc else 1
    for i in range(n):
        group[i] = i if i < groups else i - (n - nc) if i >= n - nc else (i - nc) // facets
    width, entries = np.zeros(groups, np.int64), start[groups]
    for i in range(n):
        width[group[i]] += 1
    # The elements: each group for itself, and pairs of neighbours. Normal rows hold all neighbours of a contact but rare ones.
    first, member = np.empty(groups + entries + 1, np.int64), np.empty(groups + 2 * entries, np.int64)
    seen, pairs = np.empty(groups, np.int64), 0
    for g in range(groups):
        first[g], member[g], seen[g] = g, g, g
    for g in range(groups):
        for k in range(start[g], start[g + 1]):
            other = group[column[k]]
            if other != g and seen[other] != groups + g:
                seen[other] = groups + g
                first[groups + pairs], member[groups + 2 * pairs], member[groups + 2 * pairs + 1] = groups + 2 * pairs, g, other
                pairs += 1
    first[groups + pairs] = groups + 2 * pairs
    fronts, listed, pivots, _, _ = minimum_degree(first[: groups + pairs + 1], member[: groups + 2 * pairs], width)
    turn, free = 0, np.zeros(groups, np.int64)
    for f in range(len(pivots)):
        for k in range(fronts[f], fronts[f] + pivots[f]):
            free[listed[k]] = turn
            turn += width[listed[k]]
    order = np.empty(n, np.int64)
    for i in range(n):
        order[free[group[i]]] = i
        free[group[i]] += 1
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
