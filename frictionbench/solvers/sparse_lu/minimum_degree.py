"""An order of elimination with little fill: minimum degree, for a sum of elements.

Where A = sum_e A_e, each A_e dense in the few variables of element e, eliminating a variable v merges the elements it
belongs to into a new one: their union without v, the front of v. The graph is therefore always a list of elements, and never
needs more storage than at the start. In each step a variable is eliminated whose front is (about) the smallest:

* variables with the same elements, mostly the coordinates of one body, are merged from the beginning, and a variable that
  belongs to the new element only is eliminated at once, because its front adds nothing;
* an element contained in the new one is merged into it, too;
* the size of a variable's front is bounded by the size of the new element plus those of its other elements outside the new one,
  which takes one pass over the lists of the new element's variables.

References: George and Liu 1989 (minimum degree); Amestoy, Davis and Duff 1996 (the bound).
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.compiled import part

Index = NDArray[np.int64]


@part
def _minus_one(n: int) -> Index:
    """n entries of -1."""
    index = np.empty(n, np.int64)
    for i in range(n):
        index[i] = -1
    return index


@part
def same_elements(start: Index, member: Index, n: int) -> tuple[Index, int]:
    """Number the variables (n,) so that those with the same elements share a number; also the number of different numbers.

    Element e has the variables member[start[e]:start[e+1]]. The set of variables is split by one element after another.
    """
    label = np.zeros(n, np.int64)
    labels = len(member) + n + 1
    split, into = _minus_one(labels), np.zeros(labels, np.int64)
    count = 1
    for e in range(len(start) - 1):
        for k in range(start[e], start[e + 1]):
            old = label[member[k]]
            if split[old] != e:
                split[old], into[old] = e, count
                count += 1
            label[member[k]] = into[old]
    number = _minus_one(labels)
    groups = 0
    for v in range(n):
        if label[v] == 0:  # in no element: a number of its own
            label[v] = count
            count += 1
        if number[label[v]] < 0:
            number[label[v]] = groups
            groups += 1
        label[v] = number[label[v]]
    return label, groups


@part
def transpose(start: Index, member: Index, n: int) -> tuple[Index, Index]:
    """The elements of each variable, ascending."""
    begin = np.zeros(n + 1, np.int64)
    for k in range(len(member)):
        begin[member[k] + 1] += 1
    for v in range(n):
        begin[v + 1] += begin[v]
    free, element = np.empty(n, np.int64), np.empty(len(member), np.int64)
    for v in range(n):
        free[v] = begin[v]
    for e in range(len(start) - 1):
        for k in range(start[e], start[e + 1]):
            element[free[member[k]]] = e
            free[member[k]] += 1
    return begin, element


@part
def minimum_degree(start: Index, member: Index, width: Index) -> tuple[Index, Index, Index, Index, Index]:
    """Eliminate variables of the given widths (n,) front by front: (first, variable, pivots, parent, home).

    Front f has the variables variable[first[f]:first[f+1]]; the first pivots[f] of them are eliminated in it. The rest is added
    to front parent[f] > f, -1 at a root, and element e to front home[e]. The variables of an element must be distinct.
    """
    n, elements = len(width), len(start) - 1
    begin, element = transpose(start, member, n)
    count, total = np.empty(n, np.int64), 0
    for v in range(n):
        count[v] = begin[v + 1] - begin[v]
        total += width[v]
    # The given elements, then those of the fronts: the range of their variables, their size, and the front that absorbed them.
    low, high, size = np.zeros(elements + n, np.int64), np.zeros(elements + n, np.int64), np.zeros(elements + n, np.int64)
    taken, outside = _minus_one(elements + n), np.zeros(elements + n, np.int64)
    for e in range(elements):
        low[e], high[e] = start[e], start[e + 1]
        for k in range(low[e], high[e]):
            size[e] += width[member[k]]
    end = len(member)
    storage = np.empty(2 * end + 2 * n, np.int64)
    for k in range(end):
        storage[k] = member[k]

    # Doubly linked lists of the variables, by the bounds of their degrees; the last one inserted comes first.
    degree = np.zeros(n, np.int64)
    head, after, before, seen = _minus_one(total + 1), _minus_one(n), _minus_one(n), _minus_one(n)
    for v in range(n - 1, -1, -1):
        for k in range(begin[v], begin[v + 1]):
            for m in range(start[element[k]], start[element[k] + 1]):
                if member[m] != v and seen[member[m]] != v:
                    seen[member[m]] = v
                    degree[v] += width[member[m]]
        _insert(v, degree[v], head, after, before)
    seen, measured = _minus_one(n), _minus_one(elements + n)
    first, pivots = np.zeros(n + 1, np.int64), np.zeros(n, np.int64)
    fronts, left, least = 0, n, 0
    while left:
        while head[least] < 0:
            least += 1
        v = head[least]
        _remove(v, degree[v], head, after, before)
        f, new = fronts, elements + fronts
        if end + n > len(storage):
            larger = np.empty(2 * (end + n), np.int64)
            for k in range(end):
                larger[k] = storage[k]
            storage = larger
        first[f] = end
        storage[end] = v
        end += 1
        seen[v] = f
        border = 0
        for k in range(begin[v], begin[v] + count[v]):
            e = element[k]
            taken[e] = f
            for m in range(low[e], high[e]):
                i = storage[m]
                if seen[i] != f:
                    seen[i] = f
                    storage[end] = i
                    end += 1
                    border += width[i]
        for m in range(first[f] + 1, end):  # the size of every other element outside the new one
            i = storage[m]
            _remove(i, degree[i], head, after, before)
            for k in range(begin[i], begin[i] + count[i]):
                e = element[k]
                if taken[e] < 0:
                    if measured[e] != f:
                        measured[e], outside[e] = f, size[e]
                    outside[e] -= width[i]
        pivot = first[f] + 1
        for m in range(first[f] + 1, end):
            i = storage[m]
            remaining, bound = begin[i], 0
            for k in range(begin[i], begin[i] + count[i]):
                e = element[k]
                if taken[e] < 0 and outside[e] == 0:
                    taken[e] = f
                if taken[e] < 0:
                    element[remaining] = e
                    remaining += 1
                    bound += outside[e]
            if remaining == begin[i]:
                border -= width[i]
                storage[m], storage[pivot] = storage[pivot], i
                pivot += 1
            element[remaining] = new
            count[i] = remaining + 1 - begin[i]
            degree[i] = min(bound, degree[i])
        pivots[f] = pivot - first[f]
        left -= pivots[f]
        for m in range(pivot, end):
            i = storage[m]
            degree[i] = min(degree[i] + border - width[i], total - width[i])
            least = min(least, degree[i])
            _insert(i, degree[i], head, after, before)
        low[new], high[new], size[new] = pivot, end, border
        fronts += 1
    first[fronts] = end
    members = len(member)
    for f in range(fronts + 1):
        first[f] -= members
    return (
        first[: fronts + 1],
        storage[members:end],
        pivots[:fronts],
        taken[elements : elements + fronts],
        taken[:elements],
    )


@part
def _insert(v: int, degree: int, head: Index, after: Index, before: Index) -> None:
    after[v], before[v] = head[degree], -1
    if head[degree] >= 0:
        before[head[degree]] = v
    head[degree] = v


@part
def _remove(v: int, degree: int, head: Index, after: Index, before: Index) -> None:
    if before[v] >= 0:
        after[before[v]] = after[v]
    else:
        head[degree] = after[v]
    if after[v] >= 0:
        before[after[v]] = before[v]
