"""Kernels for contact velocities and the Delassus matrix W = J M^-1 J'.

J is given by contacts, M^-1 by rows (problems.rows). Each function is one pass over the contacts.
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems.check import set_read_only
from frictionbench.problems.compiled import kernel, lean
from frictionbench.problems.forms.islands import EPSILON, delassus_units, length, lowered, mechanical_units, spread
from frictionbench.problems.rows import Array, Index32, row_of_entry

LOST = 1e-9  # relative to its terms: a smaller diagonal entry of W has cancelled; Mechanics._held_response then computes it
# Relative to the diagonal entry of W without joints: if the entry with joints is smaller, they lock the direction.
LOCKED = 1000 * EPSILON


class Dense(NamedTuple):
    """W (nc*d, nc*d), 1/kg, and q (nc*d,), m/s; float64, C-contiguous and read-only."""

    W: Array
    q: Array


class CSR(NamedTuple):
    """W in compressed rows: row i has data[k] in column indices[k] for k in indptr[i]:indptr[i+1], sorted and without zeros.

    indptr (nc*d + 1,) and indices: int32; data: float64, 1/kg; q (nc*d,), m/s. C-contiguous and read-only.
    """

    indptr: Index32
    indices: Index32
    data: Array
    q: Array


class Blocks(NamedTuple):
    """A matrix by blocks: contact i has a block with each of its neighbours[first[i]:first[i+1]], ascending and including i.

    If there is a block ij, there is a block ji.
    """

    first: Index32
    neighbours: Index32
    block: Array

    def matrix(self) -> sparse.csr_array:
        """The matrix (nc*d, nc*d) as SciPy's CSR array."""
        n = (len(self.first) - 1) * self.block.shape[1]
        if not n:
            return sparse.csr_array((0, 0))
        matrix = sparse.csr_array(sparse.bsr_array((self.block, self.neighbours, self.first), shape=(n, n)))
        matrix.eliminate_zeros()
        return matrix

    def dense(self, q: Array) -> Dense:
        """The matrix as a dense array, with q."""
        W = array_of_blocks(*self)
        set_read_only(W)
        return Dense(W, q)

    def csr(self, q: Array) -> CSR:
        """The matrix in compressed rows, with q."""
        W = self.matrix()
        set_read_only(W)
        return CSR(W.indptr, W.indices, W.data, q)


def blocks(W: sparse.csr_array, d: int) -> Blocks:
    """A SciPy matrix by blocks (d, d): those on the diagonal, and those with entries in block ij or ji."""
    nc = W.shape[0] // d
    if not nc:
        return Blocks(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros((0, d, d)))
    by_blocks = W.tobsr(blocksize=(d, d))
    row, column = row_of_entry(by_blocks.indptr), by_blocks.indices.astype(np.int64)
    at = row * nc + column
    kept = np.unique(np.concatenate([at, column * nc + row, np.arange(nc) * (nc + 1)]))
    first, neighbours = np.searchsorted(kept, nc * np.arange(nc + 1)), kept % nc
    block = np.zeros((len(kept), d, d))
    block[np.searchsorted(kept, at)] = by_blocks.data
    return Blocks(first.astype(np.int32), neighbours.astype(np.int32), block)


@kernel
def array_of_blocks(first, neighbours, block):  # type: ignore[no-untyped-def]
    """The matrix (nc*d, nc*d)."""
    nc, d = len(first) - 1, block.shape[1]
    W = np.zeros((nc * d, nc * d))
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            W[i * d : i * d + d, neighbours[k] * d : neighbours[k] * d + d] = block[k]
    return W


@kernel
def blocks_of_array(W, d):  # type: ignore[no-untyped-def]
    """A matrix (nc*d, nc*d) by blocks (d, d): those on the diagonal, and those with a nonzero block ij or ji."""
    nc, at = len(W) // d, 0
    first, neighbours, block = np.zeros(nc + 1, np.int32), np.empty(nc * nc, np.int32), np.empty((nc * nc, d, d))
    for i in range(nc):
        for j in range(nc):
            part, other = W[i * d : i * d + d, j * d : j * d + d], W[j * d : j * d + d, i * d : i * d + d]
            if i == j or part.any() or other.any():
                neighbours[at] = j
                block[at] = part
                at += 1
        first[i + 1] = at
    return first, neighbours[:at], block[:at]


@kernel
def velocity(start, column, J, m_start, m_column, m_value, free, impulse):  # type: ignore[no-untyped-def]
    """free + M^-1 J' impulse (nv,), for impulse (nc, d)."""
    pushed = np.empty(len(free))
    write_velocity(start, column, J, m_start, m_column, m_value, free, impulse, False, np.empty(len(free)), pushed)
    return pushed


@lean
def write_velocity(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, free, impulse, size, momentum, pushed
):
    """Write `velocity` to pushed (nv,); momentum (nv,) is workspace. size: sum the absolute values of all terms instead."""
    for v in range(len(free)):
        momentum[v] = 0.0
    for i in range(len(impulse)):
        for a in range(impulse.shape[1]):
            for k in range(start[i], start[i + 1]):
                momentum[column[k]] += _term(J[k, a] * impulse[i, a], size)
    for v in range(len(free)):
        pushed[v] = _term(free[v], size)
        for m in range(m_start[v], m_start[v + 1]):
            pushed[v] += _term(m_value[m] * momentum[m_column[m]], size)


@lean
def _term(value, size):  # type: ignore[no-untyped-def]
    return abs(value) if size else value


@kernel
def contact_velocity(start, column, J, v, bias):  # type: ignore[no-untyped-def]
    """J v + bias e_n (nc, d)."""
    u = np.empty((len(start) - 1, J.shape[1]))
    write_contact_velocity(start, column, J, v, bias, False, u)
    return u


@lean
def write_contact_velocity(start, column, J, v, bias, size, u):  # type: ignore[no-untyped-def]
    """Write `contact_velocity` to u (nc, d). size: as in write_velocity."""
    nc, d = u.shape
    for i in range(nc):
        for a in range(d):
            u[i, a] = 0.0
        for k in range(start[i], start[i + 1]):
            for a in range(d):
                u[i, a] += _term(J[k, a] * v[column[k]], size)
        u[i, 0] += _term(bias[i], size)


@kernel
def velocity_size(start, column, J, m_start, m_column, m_value, free, impulse, bias):  # type: ignore[no-untyped-def]
    """|J| (|free| + |M^-1| |J'| |impulse|) + |bias| e_n (nc, d): the sum of the absolute terms of pushed_contact_velocity."""
    u, pushed = np.empty(impulse.shape), np.empty(len(free))
    write_velocity(start, column, J, m_start, m_column, m_value, free, impulse, True, np.empty(len(free)), pushed)
    write_contact_velocity(start, column, J, pushed, bias, True, u)
    return u


@kernel
def diagonal(start, column, J, m_start, m_column, m_value):  # type: ignore[no-untyped-def]
    """The diagonal of W (nc, d)."""
    nc, d = len(start) - 1, J.shape[1]
    result, row = np.zeros((nc, d)), np.zeros((len(m_start) - 1, d))
    for i in range(nc):
        for k in range(start[i], start[i + 1]):
            for a in range(d):
                row[column[k], a] = J[k, a]
        for k in range(start[i], start[i + 1]):
            for m in range(m_start[column[k]], m_start[column[k] + 1]):
                for a in range(d):
                    result[i, a] += J[k, a] * m_value[m] * row[m_column[m], a]
        for k in range(start[i], start[i + 1]):
            for a in range(d):
                row[column[k], a] = 0.0
    return result


@kernel
def product(start, column, value, right):  # type: ignore[no-untyped-def]
    """A matrix by rows times a dense matrix (columns, k)."""
    result = np.zeros((len(start) - 1, right.shape[1]))
    for i in range(len(result)):
        for k in range(start[i], start[i + 1]):
            for j in range(right.shape[1]):
                result[i, j] += value[k] * right[column[k], j]
    return result


@kernel
def joint_response(start, column, F, m_start, m_column, m_value):  # type: ignore[no-untyped-def]
    """M^-1 F' (nv, nj)."""
    right = np.zeros((len(m_start) - 1, len(start) - 1))
    for j in range(len(start) - 1):
        for k in range(start[j], start[j + 1]):
            right[column[k], j] = F[k]
    return product(m_start, m_column, m_value, right)


@kernel
def coupling(start, column, J, response):  # type: ignore[no-untyped-def]
    """F M^-1 J' (nj, nc*d). response: M^-1 F' (nv, nj)."""
    nc, d, nj = len(start) - 1, J.shape[1], response.shape[1]
    coupled = np.zeros((nj, nc * d))
    for i in range(nc):
        for k in range(start[i], start[i + 1]):
            for a in range(d):
                for j in range(nj):
                    coupled[j, i * d + a] += J[k, a] * response[column[k], j]
    return coupled


@kernel
def delassus(start, column, J, m_start, m_column, m_value):  # type: ignore[no-untyped-def]
    """W by blocks."""
    nc, d, nv = len(start) - 1, J.shape[1], len(m_start) - 1
    places, response = np.empty(places_of_delassus(nc, nv, len(column)), np.int32), np.empty((nv, d))
    first, size = np.empty(nc + 1, np.int32), 8 + 4 * nc
    while True:
        neighbours, block = np.empty(size, np.int32), np.empty((size, d, d))
        if write_delassus(start, column, J, m_start, m_column, m_value, places, response, first, neighbours, block):
            return first, neighbours[: first[nc]], block[: first[nc]]
        size *= 2


@lean
def places_of_delassus(nc, nv, entries):  # type: ignore[no-untyped-def]
    """The length of the workspace `places`."""
    return nc + 4 * nv + 1 + 2 * entries


@lean
def write_delassus(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, places, response, first, neighbours, block
):
    """Write `delassus` to first (nc+1,), neighbours and block; False if these are too short. places, response: workspace.

    For each contact i, y = M^-1 J_i' is computed, and then J y for the contacts with an entry of J where y is nonzero.
    """
    nc, d, nv, entries = len(start) - 1, J.shape[1], len(m_start) - 1, len(column)
    # J by columns: the contacts that touch each velocity, and the positions of their entries.
    c_start, end = places[: nv + 1], places[nv + 1 : 2 * nv + 1]
    reached, seen = places[2 * nv + 1 : 3 * nv + 1], places[3 * nv + 1 : 4 * nv + 1]
    contact, entry = places[4 * nv + 1 : 4 * nv + 1 + entries], places[4 * nv + 1 + entries : 4 * nv + 1 + 2 * entries]
    place = places[4 * nv + 1 + 2 * entries :]
    for v in range(nv + 1):
        c_start[v] = 0
    for k in range(entries):
        c_start[column[k] + 1] += 1
    for v in range(nv):
        c_start[v + 1] += c_start[v]
        end[v], seen[v] = c_start[v], -1
    for i in range(nc):
        place[i] = -1
        for k in range(start[i], start[i + 1]):
            contact[end[column[k]]], entry[end[column[k]]] = i, k
            end[column[k]] += 1
    first[0] = at = 0
    for i in range(nc):
        velocities = 0
        for k in range(start[i], start[i + 1]):
            for m in range(m_start[column[k]], m_start[column[k] + 1]):
                v = m_column[m]
                if seen[v] != i:
                    seen[v], reached[velocities] = i, v
                    for a in range(d):
                        response[v, a] = 0.0
                    velocities += 1
                for a in range(d):
                    response[v, a] += J[k, a] * m_value[m]
        for k in range(velocities):
            v = reached[k]
            for m in range(c_start[v], c_start[v + 1]):
                j = contact[m]
                if place[j] >= first[i]:
                    continue
                if at == len(neighbours):
                    return False
                for a in range(d):
                    for b in range(d):
                        block[at, a, b] = 0.0
                _insert(neighbours, place, j, first[i], at)  # moves no blocks: those of this contact are still zero
                at += 1
        for k in range(velocities):
            v = reached[k]
            for m in range(c_start[v], c_start[v + 1]):
                here, k2 = place[contact[m]], entry[m]
                if d == 2:  # as below, unrolled
                    block[here, 0, 0] += response[v, 0] * J[k2, 0]
                    block[here, 0, 1] += response[v, 0] * J[k2, 1]
                    block[here, 1, 0] += response[v, 1] * J[k2, 0]
                    block[here, 1, 1] += response[v, 1] * J[k2, 1]
                    continue
                for a in range(d):
                    for b in range(d):
                        block[here, a, b] += response[v, a] * J[k2, b]
        first[i + 1] = at
    return True


@lean
def write_partners(first, neighbours, partner, following):  # type: ignore[no-untyped-def]
    """Write the position of block ji to partner at the position of block ij. following (nc,) is workspace."""
    nc = len(first) - 1
    for i in range(nc):
        following[i] = first[i]
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            partner[k] = following[neighbours[k]]
            following[neighbours[k]] += 1


@lean
def _insert(neighbours, place, j, begin, end):  # type: ignore[no-untyped-def]
    """Insert j into the ascending neighbours[begin:end]; place[j] is the position of j in it."""
    at = end
    while at > begin and neighbours[at - 1] > j:
        neighbours[at] = neighbours[at - 1]
        place[neighbours[at]] = at
        at -= 1
    neighbours[at], place[j] = j, at


@kernel
def act(first, neighbours, block, r, q, size):  # type: ignore[no-untyped-def]
    """W r + q (nc, d), or with size |W| |r| + |q|, the sum of the absolute terms."""
    u = np.empty(r.shape)
    write_act(first, neighbours, block, r, q, size, u)
    return u


@lean
def write_act(first, neighbours, block, r, q, size, u):  # type: ignore[no-untyped-def]
    """Write `act` to u (nc, d)."""
    for i in range(len(u)):
        for a in range(u.shape[1]):
            u[i, a] = 0.0
            for k in range(first[i], first[i + 1]):
                for b in range(u.shape[1]):
                    u[i, a] += _term(block[k, a, b] * r[neighbours[k], b], size)
            u[i, a] += _term(q[i, a], size)


@kernel
def block_scale(first, neighbours, block):  # type: ignore[no-untyped-def]
    """s (nc,): `mean_diagonal` of the blocks of W."""
    diagonals = np.zeros((len(first) - 1, block.shape[1]))
    for i in range(len(diagonals)):
        for k in range(first[i], first[i + 1]):
            if neighbours[k] == i:
                for a in range(block.shape[1]):
                    diagonals[i, a] = block[k, a, a]
    return mean_diagonal(diagonals)


@kernel
def mean_diagonal(diagonal):  # type: ignore[no-untyped-def]
    """The mean (nc,) of the positive entries of each contact's diagonal (nc, d); without any, that of all contacts or 1."""
    nc, d = diagonal.shape
    mean, whole, count = np.zeros(nc), 0.0, 0
    for i in range(nc):
        total, moving = 0.0, 0
        for a in range(d):
            if diagonal[i, a] > 0:
                total += diagonal[i, a]
                moving += 1
        if moving:
            mean[i] = total / moving
            whole += mean[i]
            count += 1
    for i in range(nc):
        if mean[i] == 0:
            mean[i] = whole / count if whole > 0 else 1.0
    return mean


@kernel
def largest(q, d):  # type: ignore[no-untyped-def]
    """max_i |q_i| of q (nc*d,)."""
    most = 0.0
    for i in range(len(q) // d):
        most = max(most, length(q, i * d, d))
    return most


@kernel
def pushed_contact_velocity(start, column, J, m_start, m_column, m_value, free, impulse, bias):  # type: ignore[no-untyped-def]
    """J v + bias e_n (nc, d), where v is the velocity after an impulse (nc, d)."""
    return contact_velocity(start, column, J, velocity(start, column, J, m_start, m_column, m_value, free, impulse), bias)


@kernel
def measures(start, column, J, m_start, m_column, m_value, free, bias, b_f, mu):  # type: ignore[no-untyped-def]
    """For a problem without joints: q (nc*d,), the mean diagonal (nc,) of each contact's own block of W, max_i |q_i|, the units
    (nc,) and their spread. With mu (nc,) the units are those of the convex relaxation, with empty mu those of Coulomb's law."""
    nc, d = len(bias), J.shape[1]
    q = contact_velocity(start, column, J, free, bias).reshape(nc * d)
    diagonals = np.zeros((nc, d))
    if len(m_value) > len(free):
        diagonals = diagonal(start, column, J, m_start, m_column, m_value)
    else:  # M is diagonal
        for i in range(nc):
            for k in range(start[i], start[i + 1]):
                for a in range(d):
                    diagonals[i, a] += J[k, a] * J[k, a] * m_value[column[k]]
    s, none, low = mean_diagonal(diagonals), np.zeros(1, np.int32), lowered(q, mu) if len(mu) else q
    units = mechanical_units(start, column, J, m_start, m_column, m_value, none, none[:0], np.abs(free), bias, low, s, b_f)[0]
    return q, s, largest(q, d), units, spread(units)


@kernel
def known_measures(first, neighbours, block, q, b_f, mu):  # type: ignore[no-untyped-def]
    """The mean diagonal, the units and the spread, as `measures`, for a problem of which only W, by blocks, and q are known."""
    s, low = block_scale(first, neighbours, block), lowered(q, mu) if len(mu) else q
    units, _ = delassus_units(first, neighbours, block, low, s, b_f)
    return s, units, spread(units)
