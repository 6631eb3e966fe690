"""Sparse LU of a sum of small dense matrices, by the multifrontal method.

    A = sum_e A_e,      A_e nonzero only where rows and columns belong to the few variables of element e,

unsymmetric in value, symmetric in pattern, such as a mass matrix and one matrix a contact. Eliminating a set of variables with
the same neighbours is a dense elimination in a front,

    [ P  R ]        P = LU of the pivots,        S <- S - C P^-1 R,
    [ C  S ]

whose S is added to the front of the first variable left in it. Everything that depends on the pattern alone (an order of
elimination with little fill, the fronts, the place of each entry in them) is computed once, by `analyse`; `factorise` and
`solve_factorised` are compiled and allocate nothing. Rows are interchanged within the pivots of a front only, and a pivot below
`floor` is replaced by it, so that `factorise` always succeeds; callers that need more digits refine (Li and Demmel 1998).

On the matrices of an interior point it is 2 to 28 times as fast as scipy's splu with the best of its orderings, which splu
computes in every call. With a given ordering, splu takes 1 to 6 times as long (tests/benchmarks/test_sparse_lu.py).

The order is that of solvers.sparse_lu.minimum_degree. References: Duff and Reid 1983; Liu 1992.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, lean, lean_kernel, part
from frictionbench.solvers.sparse_lu.dense_front import eliminate, extend_add, pivot
from frictionbench.solvers.sparse_lu.minimum_degree import Index, minimum_degree, same_elements, transpose

Place = NDArray[np.uint32]  # unsigned, so that compiled code need not check for negative indices
NARROW = 12  # fronts up to this width use plain loops: tiles gain nothing (tests/benchmarks/test_sparse_lu.py)


class Fronts(NamedTuple):
    """The symbolic factorisation. Variables are numbered by their place in the order of elimination.

    variable: the variables of front f are variable[first[f]:first[f+1]], ascending, the pivots[f] eliminated ones first.
    above[j]: the position of variable[j] in the parent's front, 0 for a pivot. parent: -1 at a root. start: front f is stored
    by rows from start[f] on; start[-1] is the size of the storage. owner (n,): the front that eliminates each variable.
    """

    first: Index
    variable: Place
    above: Place
    pivots: Index
    parent: Index
    start: Index
    owner: Index


@part
def analyse(start: Index, member: Index, n: int) -> tuple[Fronts, Index, Index]:
    """The fronts, the place (n,) of each variable in the order of elimination, and the front to which each element is added.

    Element e has the distinct variables member[start[e]:start[e+1]]. Every variable has an entry on the diagonal.
    """
    group, groups = same_elements(start, member, n)
    width, seen = np.zeros(groups, np.int64), np.empty(groups, np.int64)
    for g in range(groups):
        seen[g] = -1
    for v in range(n):
        width[group[v]] += 1
    part, begin, end = np.empty(len(member), np.int64), np.zeros(len(start), np.int64), 0
    for e in range(len(start) - 1):
        for k in range(start[e], start[e + 1]):
            if seen[group[member[k]]] != e:
                seen[group[member[k]]] = e
                part[end] = group[member[k]]
                end += 1
        begin[e + 1] = end
    first, listed, pivots, parent, home = minimum_degree(begin, part[:end], width)
    # Number groups, then their variables, in the order of elimination.
    fronts, rank, turn = len(pivots), np.empty(groups, np.int64), 0
    offset = np.zeros(groups + 1, np.int64)
    for f in range(fronts):
        for k in range(first[f], first[f] + pivots[f]):
            rank[listed[k]] = turn
            offset[turn + 1] = offset[turn] + width[listed[k]]
            turn += 1
    free, place = np.empty(groups, np.int64), np.empty(n, np.int64)
    for g in range(groups):
        free[g] = offset[g]
    for v in range(n):
        place[v] = free[rank[group[v]]]
        free[rank[group[v]]] += 1
    for k in range(len(listed)):
        listed[k] = rank[listed[k]]
    begin, front = transpose(first, listed, groups)  # and below back again, which sorts the groups of each front
    free = np.empty(fronts, np.int64)
    for f in range(fronts):
        free[f] = first[f]
    for g in range(groups):
        for k in range(begin[g], begin[g + 1]):
            listed[free[front[k]]] = g
            free[front[k]] += 1
    return _lay_out(first, listed, pivots, parent, offset), place, home


@part
def _lay_out(first: Index, listed: Index, pivots: Index, parent: Index, offset: Index) -> Fronts:
    """Fronts of variables from fronts of groups: group g, in order of elimination, is variables offset[g] to offset[g+1]."""
    fronts, size = len(pivots), np.zeros(len(pivots) + 1, np.int64)
    eliminated, begin = np.zeros(fronts, np.int64), np.zeros(fronts + 1, np.int64)
    owner = np.empty(offset[-1], np.int64)
    for f in range(fronts):
        for k in range(first[f], first[f + 1]):
            g = listed[k]
            size[f] += offset[g + 1] - offset[g]
            if k < first[f] + pivots[f]:
                eliminated[f] += offset[g + 1] - offset[g]
                for v in range(offset[g], offset[g + 1]):
                    owner[v] = f
        begin[f + 1] = begin[f] + size[f]
    variable, above = np.empty(begin[-1], np.uint32), np.zeros(begin[-1], np.uint32)
    start = np.zeros(fronts + 1, np.int64)
    at = 0
    for f in range(fronts):
        start[f + 1] = start[f] + size[f] ** 2
        for k in range(first[f], first[f + 1]):
            for v in range(offset[listed[k]], offset[listed[k] + 1]):
                variable[at] = v
                at += 1
    for f in range(fronts):
        k = begin[parent[f]]
        for m in range(begin[f] + eliminated[f], begin[f + 1]):
            while variable[k] != variable[m]:
                k += 1
            above[m] = k - begin[parent[f]]
    return Fronts(begin, variable, above, eliminated, parent, start, owner)


@lean
def position_in_front(fronts: Fronts, front: int, variable: int) -> int:
    """The position of a variable in a front, which must contain it."""
    low, high = fronts.first[front], fronts.first[front + 1] - 1
    while low < high:
        middle = (low + high) // 2
        if fronts.variable[middle] < variable:
            low = middle + 1
        else:
            high = middle
    return int(low - fronts.first[front])


@lean
def place_of_entry(fronts: Fronts, row: int, column: int) -> int:
    """The index in the storage of `factorise` of an entry of A, by its row and column in the order of elimination."""
    f = fronts.owner[min(row, column)]
    width = fronts.first[f + 1] - fronts.first[f]
    return int(fronts.start[f] + position_in_front(fronts, f, row) * width + position_in_front(fronts, f, column))


@lean_kernel
def factorise(fronts: Fronts, storage: Array, swap: Index, floor: float) -> int:
    """Factorise the matrix assembled in storage (start[-1],) in place; return the number of pivots replaced.

    swap: (n,), filled with the row interchanges.
    """
    replaced = eliminated = 0
    for f in range(len(fronts.pivots)):
        p, w, up = fronts.pivots[f], fronts.first[f + 1] - fronts.first[f], fronts.parent[f]
        F = _front(fronts, storage, f)
        if w > NARROW:
            replaced += eliminate(F, p, swap[eliminated : eliminated + p], floor)
        else:
            for k in range(p):
                swap[eliminated + k], small = pivot(F, k, p, floor)
                replaced += small
                for i in range(k + 1, w):
                    a = F[i, k] * F[k, k]
                    F[i, k] = a
                    for j in range(k + 1, w):
                        F[i, j] -= a * F[k, j]
        eliminated += p
        if p < w:
            extend_add(F, p, fronts.above[fronts.first[f] : fronts.first[f + 1]], _front(fronts, storage, up))
    return replaced


@inlined
def _front(fronts: Fronts, storage: Array, f: int) -> Array:
    """Front f as a matrix."""
    w = fronts.first[f + 1] - fronts.first[f]
    return storage[fronts.start[f] : fronts.start[f + 1]].reshape(w, w)


@lean_kernel
def operations(fronts: Fronts) -> float:
    """The multiplications and additions of `factorise`."""
    count = 0.0
    for f in range(len(fronts.pivots)):
        for left in range(fronts.first[f + 1] - fronts.first[f] - fronts.pivots[f], fronts.first[f + 1] - fronts.first[f]):
            count += 2.0 * left * left
    return count


@lean
def solve_factorised(fronts: Fronts, storage: Array, swap: Index, b: Array) -> None:
    """Overwrite b (n,) with A^-1 b, after factorise; the factors are not changed."""
    eliminated = 0
    for f in range(len(fronts.pivots)):
        p, begin, w = fronts.pivots[f], fronts.first[f], fronts.first[f + 1] - fronts.first[f]
        base = fronts.start[f]
        for k in range(p):
            best = eliminated + swap[eliminated + k]
            value = b[best]
            b[best] = b[eliminated + k]
            b[eliminated + k] = value
        for i in range(1, w):
            row, value = base + i * w, b[fronts.variable[begin + i]]
            for k in range(min(i, p)):
                value -= storage[row + k] * b[eliminated + k]
            b[fronts.variable[begin + i]] = value
        eliminated += p
    for f in range(len(fronts.pivots) - 1, -1, -1):
        p, begin, w = fronts.pivots[f], fronts.first[f], fronts.first[f + 1] - fronts.first[f]
        eliminated -= p
        for k in range(p - 1, -1, -1):
            row, total = fronts.start[f] + k * w, b[eliminated + k]
            for j in range(k + 1, w):
                total -= storage[row + j] * b[fronts.variable[begin + j]]
            b[eliminated + k] = total * storage[row + k]


@lean
def determinant_sign(fronts: Fronts, storage: Array, swap: Index) -> int:
    """The sign of det A, after factorise, from the pivots and the row interchanges."""
    sign, eliminated = 1, 0
    for f in range(len(fronts.pivots)):
        w = fronts.first[f + 1] - fronts.first[f]
        for k in range(fronts.pivots[f]):
            if (storage[fronts.start[f] + k * (w + 1)] < 0) != (swap[eliminated + k] != k):
                sign = -sign
        eliminated += fronts.pivots[f]
    return sign
