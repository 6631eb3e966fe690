"""The unknowns of an LCP in an order of elimination with little fill: minimum degree on the graph of the contacts."""

import numpy as np

from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.forms.lcp import contact_of
from frictionbench.solvers.pivots.lu_basis import Columns
from frictionbench.solvers.sparse_lu.minimum_degree import minimum_degree


@kernel
def in_order(M, q, unit, nc):  # type: ignore[no-untyped-def]
    """Reorder a scaled LCP of nc contacts, or a bare LCP (nc = 0); the unknowns of a contact stay together.

    Returns the columns, with ascending rows, q (n,), the unit (2, n) and the order (n,).
    """
    n = len(q)
    order = _least_fill(M.start, M.rows, n, nc)
    own_q, own_unit = np.empty(n), np.empty((2, n))
    for i in range(n):
        own_q[i], own_unit[0, i], own_unit[1, i] = q[order[i]], unit[0, order[i]], unit[1, order[i]]
    start, row, value = _reordered(M, order)
    return Columns(start, row, value, np.zeros(n)), own_q, own_unit, order


@part
def _least_fill(start, rows, n, nc):  # type: ignore[no-untyped-def]
    groups = nc if nc else n
    group, width, entries = np.empty(n, np.int64), np.full(groups, n // max(groups, 1)), start[groups]
    for i in range(n):
        group[i] = contact_of(i, n, nc) if nc else i
    # The elements: each group, and each pair of neighbours. A contact's normal row has entries for nearly all its neighbours.
    first, member = np.empty(groups + entries + 1, np.int64), np.empty(groups + 2 * entries, np.int64)
    seen, pairs = np.empty(groups, np.int64), 0
    for g in range(groups):
        first[g], member[g], seen[g] = g, g, g
    for g in range(groups):
        for k in range(start[g], start[g + 1]):
            other = group[rows[k]]
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
def _reordered(M, order):  # type: ignore[no-untyped-def]
    n = len(order)
    place, begin = np.empty(n, np.int64), np.zeros(n + 2, np.int64)
    for i in range(n):
        place[order[i]] = i
    for k in range(M.start[n]):
        begin[place[M.rows[k]] + 2] += M.row[k] != 0.0
    for i in range(n):
        begin[i + 2] += begin[i + 1]
    row, entry = np.empty(begin[n + 1], np.int64), np.empty(begin[n + 1])
    for i in range(n):
        for k in range(M.start[order[i]], M.start[order[i] + 1]):
            if M.row[k] != 0.0:
                j = place[M.rows[k]] + 1
                row[begin[j]], entry[begin[j]] = i, M.row[k]
                begin[j] += 1
    return begin[: n + 1], row, entry
