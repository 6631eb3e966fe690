"""The Delassus matrix W = J M^-1 J' from sparse parts, in one compiled pass over the contacts.

Generic sparse products spend a small problem's time on bookkeeping; these kernels work on the CSR arrays themselves.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import sparse

from problems.check import Array

Index = NDArray[np.int32]


def interleave(normal: sparse.csr_array, tangent: sparse.csr_array, d: int) -> sparse.csr_array:
    """J (nc*d, nv): per contact its normal row, then its d-1 tangent rows."""
    n, t = normal, tangent
    parts = _interleave(n.indptr, n.indices, n.data, t.indptr, t.indices, t.data, d)
    return sparse.csr_array(parts, shape=(n.shape[0] * d, n.shape[1]))


def delassus(J: sparse.csr_array, inverse: sparse.csr_array) -> sparse.csr_array:
    """J M^-1 J' (rows sorted), for J (m, nv) and a symmetric inverse mass (nv, nv), both CSR."""
    columns = J.tocsc()
    m = J.shape[0]
    parts = (J.indptr, J.indices, J.data, columns.indptr, columns.indices, columns.data)
    return sparse.csr_array(_delassus(*parts, inverse.indptr, inverse.indices, inverse.data), shape=(m, m))


def push(J: sparse.csr_array, inverse: sparse.csr_array, velocity: Array, impulse: Array) -> Array:
    """velocity + M^-1 J' impulse (nv,)."""
    return _push(J.indptr, J.indices, J.data, inverse.indptr, inverse.indices, inverse.data, velocity, impulse)


def apply(J: sparse.csr_array, velocity: Array) -> Array:
    """J velocity (m,)."""
    return _apply(J.indptr, J.indices, J.data, velocity)


def velocity_size(J: sparse.csr_array, inverse: sparse.csr_array, velocity: Array, impulse: Array) -> Array:
    """|J| (|velocity| + |M^-1| |J'| |impulse|) (m,): the size of what adds up to J (velocity + M^-1 J' impulse)."""
    rows = J.indptr, J.indices, np.abs(J.data)
    pushed = _push(*rows, inverse.indptr, inverse.indices, np.abs(inverse.data), np.abs(velocity), np.abs(impulse))
    return _apply(*rows, pushed)


def delassus_diagonal(J: sparse.csr_array, inverse: sparse.csr_array) -> Array:
    """The diagonal (m,) of J M^-1 J'."""
    return _diagonal(J.indptr, J.indices, J.data, inverse.indptr, inverse.indices, inverse.data)


@njit(cache=True)
def _interleave(
    n_ptr: Index, n_col: Index, n_val: Array, t_ptr: Index, t_col: Index, t_val: Array, d: int
) -> tuple[Array, Index, Index]:
    nc = len(n_ptr) - 1
    entries = len(n_val) + len(t_val)
    val, col, ptr = np.empty(entries), np.empty(entries, dtype=np.int32), np.zeros(nc * d + 1, dtype=np.int32)
    at = 0
    for row in range(nc * d):
        i, a = row // d, row % d
        if a == 0:
            begin, end = n_ptr[i], n_ptr[i + 1]
            val[at : at + end - begin], col[at : at + end - begin] = n_val[begin:end], n_col[begin:end]
        else:
            j = i * (d - 1) + a - 1
            begin, end = t_ptr[j], t_ptr[j + 1]
            val[at : at + end - begin], col[at : at + end - begin] = t_val[begin:end], t_col[begin:end]
        at += end - begin
        ptr[row + 1] = at
    return val, col, ptr


@njit(cache=True)
def _delassus(
    j_ptr: Index,
    j_col: Index,
    j_val: Array,
    c_ptr: Index,
    c_row: Index,
    c_val: Array,
    m_ptr: Index,
    m_col: Index,
    m_val: Array,
) -> tuple[Array, Index, Index]:
    """Row by row: y = M^-1 J_i', then J y through the columns of J."""
    rows, nv = len(j_ptr) - 1, len(m_ptr) - 1
    response, reached = np.zeros(nv), np.empty(nv, dtype=np.int32)
    row, touched = np.zeros(rows), np.empty(rows, dtype=np.int32)
    seen_v, seen_r = np.full(nv, -1, dtype=np.int32), np.full(rows, -1, dtype=np.int32)
    size = max(16, 8 * rows)
    val, col, ptr = np.empty(size), np.empty(size, dtype=np.int32), np.zeros(rows + 1, dtype=np.int32)
    at = 0
    for i in range(rows):
        velocities = 0
        for k in range(j_ptr[i], j_ptr[i + 1]):
            for m in range(m_ptr[j_col[k]], m_ptr[j_col[k] + 1]):
                v = m_col[m]
                if seen_v[v] != i:
                    seen_v[v], response[v], reached[velocities] = i, 0.0, v
                    velocities += 1
                response[v] += j_val[k] * m_val[m]
        contacts = 0
        for k in range(velocities):
            v = reached[k]
            for m in range(c_ptr[v], c_ptr[v + 1]):
                r = c_row[m]
                if seen_r[r] != i:
                    seen_r[r], row[r], touched[contacts] = i, 0.0, r
                    contacts += 1
                row[r] += response[v] * c_val[m]
        while at + contacts > len(val):
            val, col = np.concatenate((val, np.empty_like(val))), np.concatenate((col, np.empty_like(col)))
        touched[:contacts].sort()
        for k in range(contacts):
            val[at], col[at] = row[touched[k]], touched[k]
            at += 1
        ptr[i + 1] = at
    return val[:at].copy(), col[:at].copy(), ptr


@njit(cache=True)
def _push(
    j_ptr: Index, j_col: Index, j_val: Array, m_ptr: Index, m_col: Index, m_val: Array, velocity: Array, impulse: Array
) -> Array:
    momentum, pushed = np.zeros(len(velocity)), velocity.copy()
    for i in range(len(impulse)):
        for k in range(j_ptr[i], j_ptr[i + 1]):
            momentum[j_col[k]] += j_val[k] * impulse[i]
    for v in range(len(velocity)):
        for m in range(m_ptr[v], m_ptr[v + 1]):
            pushed[v] += m_val[m] * momentum[m_col[m]]
    return pushed


@njit(cache=True)
def _apply(j_ptr: Index, j_col: Index, j_val: Array, velocity: Array) -> Array:
    result = np.zeros(len(j_ptr) - 1)
    for i in range(len(result)):
        for k in range(j_ptr[i], j_ptr[i + 1]):
            result[i] += j_val[k] * velocity[j_col[k]]
    return result


@njit(cache=True)
def _diagonal(j_ptr: Index, j_col: Index, j_val: Array, m_ptr: Index, m_col: Index, m_val: Array) -> Array:
    diagonal, row = np.zeros(len(j_ptr) - 1), np.zeros(len(m_ptr) - 1)
    for i in range(len(diagonal)):
        for k in range(j_ptr[i], j_ptr[i + 1]):
            row[j_col[k]] = j_val[k]
        for k in range(j_ptr[i], j_ptr[i + 1]):
            for m in range(m_ptr[j_col[k]], m_ptr[j_col[k] + 1]):
                diagonal[i] += j_val[k] * m_val[m] * row[m_col[m]]
        for k in range(j_ptr[i], j_ptr[i + 1]):
            row[j_col[k]] = 0.0
    return diagonal
