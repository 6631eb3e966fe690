"""Sparse LU of a sum of small dense matrices, by the multifrontal method.

    A = sum_e A_e,      A_e nonzero only where rows and columns belong to the few variables of element e,

unsymmetric in value, symmetric in pattern: a mass matrix and one matrix for each contact, say. Eliminating a set of variables
with the same neighbours is dense work on a front,

    [ P  R ]        P = LU of the pivots,        S <- S - C P^-1 R,
    [ C  S ]

whose S is added to the front of the first variable left in it. Everything that depends on the pattern alone (an order of
elimination with little fill, the fronts, the place of each entry in them) is found once, by `analyse`; `factorise` and `solve`
are compiled and allocate nothing. Rows are interchanged within the pivots of a front only, and a pivot below `floor` is
replaced by it, so that `factorise` always ends; whoever asks for many digits refines (Li and Demmel 1998).

The order is SuperLU's minimum degree, on the graph of the sets of variables with the same neighbours.
References: Duff and Reid 1983; Liu 1992.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from problems.check import Array

Index = NDArray[np.int64]


class Fronts(NamedTuple):
    """The symbolic factorisation. Variables are numbered by their place in the order of elimination.

    variable: the variables of front f are variable[first[f]:first[f+1]], ascending, the pivots[f] eliminated ones first.
    above[j]: where variable[j] stands in the parent's front. parent: -1 at a root. start: front f is row-major
    at start[f] of the storage of factorise, start[-1] numbers.
    """

    first: Index
    variable: Index
    above: Index
    pivots: Index
    parent: Index
    start: Index

    @property
    def size(self) -> int:
        """The number of variables."""
        return int(self.pivots.sum())

    def home(self, leader: Index) -> Index:
        """The front that eliminates each variable given."""
        return np.searchsorted(np.cumsum(self.pivots), leader, side="right")

    def place(self, front: Index, variable: Index) -> Index:
        """Where each variable stands in the front given with it; both must belong together."""
        n = self.size
        owner = np.repeat(np.arange(len(self.pivots)), np.diff(self.first))
        return np.searchsorted(owner * n + self.variable, front * n + variable) - self.first[front]


def analyse(incidence: sparse.csr_array) -> tuple[Fronts, Index]:
    """The fronts for elements whose variables are the nonzeros of the rows of incidence (ne, n), and the order (n,).

    Variable k of the fronts is column order[k] of incidence. Every variable is given an entry on the diagonal.
    """
    n = incidence.shape[1]
    if not n:
        none = np.zeros(0, dtype=np.int64)
        return Fronts(np.zeros(1, dtype=np.int64), none, none, none, none, np.zeros(1, dtype=np.int64)), none
    touch = sparse.csr_array((np.ones(incidence.nnz), incidence.indices, incidence.indptr), shape=incidence.shape)
    touch = sparse.vstack([touch, sparse.eye_array(n)], format="csr")
    group, groups = _same_neighbours(touch)
    # A graph's Laplacian, slightly shifted, fills in wherever a matrix of its pattern can, without cancellation.
    member = sparse.csr_array((np.ones(n), (np.arange(n), group)), shape=(n, groups))
    clique = touch @ member
    graph = sparse.csr_array(clique.T @ clique)
    graph.data[:] = -1.0
    graph = graph + sparse.diags_array(1e-3 - np.asarray(graph.sum(axis=1)).ravel())
    lu = splu(
        sparse.csc_array(graph),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        relax=1,
        panel_size=1,
        options={"SymmetricMode": True},
    )
    fill = lu.L.tocsc()
    fill.sort_indices()
    rank = np.argsort(lu.perm_c)
    order = np.argsort(lu.perm_c[group], kind="stable")
    width = np.bincount(group, minlength=groups)[rank]
    return _fronts(fill.indptr.astype(np.int64), fill.indices.astype(np.int64), width), order


def _same_neighbours(touch: sparse.csr_array) -> tuple[Index, int]:
    """Number the variables so that those with the same neighbours share a number: the coordinates of one body, mostly."""
    graph = touch.T @ touch
    graph = sparse.csr_array((np.ones(graph.nnz, dtype=np.int64), graph.indices, graph.indptr), shape=graph.shape)
    label = np.random.default_rng(0).integers(1 << 62, size=graph.shape[0])
    kinds, group = np.unique(graph @ label, return_inverse=True)  # sums modulo 2^64: equal sets, equal sums
    return group, len(kinds)


def _fronts(start: Index, row: Index, width: Index) -> Fronts:
    """Fronts of columns with the same fill, from the filled lower triangle of the groups and the size of each group."""
    groups = len(width)
    count = np.diff(start)
    parent = np.full(groups, -1)
    inner = count > 1
    parent[inner] = row[start[:-1][inner] + 1]
    # A group joins the front of the one before it when that one is its child and adds nothing but itself.
    joins = np.zeros(groups, dtype=bool)
    joins[1:] = (parent[:-1] == np.arange(1, groups)) & (count[:-1] == count[1:] + 1)
    leader = np.flatnonzero(~joins)
    front = np.cumsum(~joins) - 1
    last = np.append(leader[1:], groups) - 1
    offset = np.concatenate([[0], np.cumsum(width)])

    listed = _ranges(start[leader], count[leader])  # groups of each front, one front after another
    owner = np.repeat(np.arange(len(leader)), count[leader])
    member = row[listed]
    variable = _ranges(offset[member], width[member])
    size = np.bincount(np.repeat(owner, width[member]), minlength=len(leader))
    first = np.concatenate([[0], np.cumsum(size)])
    pivots = np.add.reduceat(width, leader)
    up = np.where(parent[last] >= 0, front[parent[last]], -1)
    fronts = Fronts(first, variable, np.full(len(variable), -1), pivots, up, np.concatenate([[0], np.cumsum(size**2)]))
    child = np.repeat(np.arange(len(leader)), size)
    border = np.flatnonzero(np.arange(len(variable)) >= (first[:-1] + pivots)[child])
    fronts.above[border] = fronts.place(up[child[border]], variable[border])
    return fronts


def _ranges(start: Index, count: Index) -> Index:
    """start[0] .. start[0] + count[0] - 1, start[1] .. and so on, in one array."""
    return np.repeat(start - np.concatenate([[0], np.cumsum(count)[:-1]]), count) + np.arange(count.sum())


@njit(cache=True)
def factorise(fronts: Fronts, storage: Array, swap: Index, floor: float) -> int:
    """Factorise in place what was added into storage (start[-1],); the number of pivots replaced.

    swap: (n,), filled with the row interchanges.
    """
    replaced = 0
    eliminated = 0
    for f in range(len(fronts.pivots)):
        p, w = fronts.pivots[f], fronts.first[f + 1] - fronts.first[f]
        F = storage[fronts.start[f] : fronts.start[f + 1]].reshape(w, w)
        for k in range(p):
            best = k
            for i in range(k + 1, p):
                if abs(F[i, k]) > abs(F[best, k]):
                    best = i
            swap[eliminated + k] = best
            if best != k:
                for j in range(w):
                    F[k, j], F[best, j] = F[best, j], F[k, j]
            if not abs(F[k, k]) >= floor:
                F[k, k] = -floor if F[k, k] < 0 else floor
                replaced += 1
            F[k, k] = 1 / F[k, k]
            for i in range(k + 1, w):
                if F[i, k] != 0:
                    F[i, k] *= F[k, k]
                    factor = F[i, k]
                    for j in range(k + 1, w):
                        F[i, j] -= factor * F[k, j]
        eliminated += p
        if p < w:
            up = fronts.parent[f]
            above = fronts.above[fronts.first[f] : fronts.first[f + 1]]
            wide = fronts.first[up + 1] - fronts.first[up]
            G = storage[fronts.start[up] : fronts.start[up + 1]].reshape(wide, wide)
            for i in range(p, w):
                for j in range(p, w):
                    G[above[i], above[j]] += F[i, j]
    return replaced


@njit(cache=True)
def solve(fronts: Fronts, storage: Array, swap: Index, b: Array) -> None:
    """Overwrite b (n,) with A^-1 b, after factorise."""
    eliminated = 0
    for f in range(len(fronts.pivots)):
        p, w = fronts.pivots[f], fronts.first[f + 1] - fronts.first[f]
        F = storage[fronts.start[f] : fronts.start[f + 1]].reshape(w, w)
        variable = fronts.variable[fronts.first[f] : fronts.first[f + 1]]
        for k in range(p):
            best = eliminated + swap[eliminated + k]
            b[eliminated + k], b[best] = b[best], b[eliminated + k]
        for i in range(1, w):
            total = 0.0
            for k in range(min(i, p)):
                total += F[i, k] * b[eliminated + k]
            b[variable[i]] -= total
        eliminated += p
    for f in range(len(fronts.pivots) - 1, -1, -1):
        p, w = fronts.pivots[f], fronts.first[f + 1] - fronts.first[f]
        F = storage[fronts.start[f] : fronts.start[f + 1]].reshape(w, w)
        variable = fronts.variable[fronts.first[f] : fronts.first[f + 1]]
        eliminated -= p
        for k in range(p - 1, -1, -1):
            total = b[eliminated + k]
            for j in range(k + 1, w):
                total -= F[k, j] * b[variable[j]]
            b[eliminated + k] = total * F[k, k]
