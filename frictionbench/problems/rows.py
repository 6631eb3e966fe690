"""Sparse matrices as plain arrays, which compiled passes read and write.

By rows: row i has the entries value[k] in the columns column[k], start[i] <= k < start[i+1], columns ascending, no zeros (the
CSR arrays). By contacts: contact i touches the columns column[k] with the d entries value[k], its normal's first, of which some
may be zero. scipy's matrices are made from these on demand, for users and outside libraries: making one takes as long as all
the arithmetic on ten contacts.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems.compiled import kernel, part

Array = NDArray[np.float64]
Index32 = NDArray[np.int32]
Index64 = NDArray[np.int64]


class Rows(NamedTuple):
    """A matrix by rows: start (rows+1,), column and value (entries,)."""

    start: Index32
    column: Index32
    value: Array

    def matrix(self, columns: int) -> sparse.csr_array:
        """The matrix as scipy's CSR array; read-only."""
        parts = [piece.view() for piece in (self.value, self.column, self.start)]
        for piece in parts:
            piece.setflags(write=False)
        return sparse.csr_array(tuple(parts), shape=(len(self.start) - 1, columns))

    def dense(self, columns: int) -> Array:
        """The matrix as a new array (rows, columns)."""
        dense = np.zeros((len(self.start) - 1, columns))
        dense[np.repeat(np.arange(len(dense)), np.diff(self.start)), self.column] = self.value
        return dense


class ByContact(NamedTuple):
    """A matrix of d rows a contact: start (nc+1,), column (entries,), value (entries, d)."""

    start: Index32
    column: Index32
    value: Array


def from_dense(dense: Array) -> Rows:
    """A dense matrix by rows."""
    return Rows(*_from_dense(np.ascontiguousarray(dense)))


def from_matrix(matrix: sparse.csr_array) -> Rows:
    """A canonical scipy matrix by rows; a copy."""
    return Rows(np.array(matrix.indptr, np.int32), np.array(matrix.indices, np.int32), np.array(matrix.data))


@kernel
def _from_dense(dense):  # type: ignore[no-untyped-def]
    entries = 0
    for entry in dense.flat:
        entries += entry != 0
    start = np.zeros(len(dense) + 1, np.int32)
    column, value, at = np.empty(entries, np.int32), np.empty(entries), 0
    for i in range(len(dense)):
        for j in range(dense.shape[1]):
            if dense[i, j] != 0:
                column[at], value[at] = j, dense[i, j]
                at += 1
        start[i + 1] = at
    return start, column, value


@part
def nowhere(n):  # type: ignore[no-untyped-def]
    """n entries of -1."""
    index = np.empty(n, np.int32)
    for i in range(n):
        index[i] = -1
    return index


@kernel
def copied(start, column, value, columns):  # type: ignore[no-untyped-def]
    """(valid, copies of the three): valid where they are a canonical matrix with so many columns and finite entries."""
    good = start[0] == 0 and start[-1] <= len(column) and start[-1] <= len(value)
    own_start, own_column, own_value = np.empty(len(start), np.int32), np.empty(len(column), np.int32), np.empty(len(value))
    own_start[0] = 0
    for i in range(len(start) - 1):
        own_start[i + 1] = start[i + 1]
        last = -1
        if not good or start[i + 1] < start[i] or start[i + 1] > start[-1]:
            return False, own_start, own_column, own_value
        for k in range(start[i], start[i + 1]):
            own_column[k], own_value[k] = column[k], value[k]
            good = good and last < column[k] < columns and value[k] != 0 and abs(value[k]) < np.inf
            last = column[k]
    return good and start[-1] == len(column) and start[-1] == len(value), own_start, own_column, own_value


@kernel
def by_contact(n_start, n_column, n_value, t_start, t_column, t_value, d):  # type: ignore[no-untyped-def]
    """A contact's normal row and its d-1 tangent rows over the union of their columns, ascending."""
    nc = len(n_start) - 1
    start, at = np.zeros(nc + 1, np.int32), 0
    column = np.empty(len(n_column) + len(t_column), np.int32)
    value = np.zeros((len(column), d))
    here, end = np.empty(d, np.int64), np.empty(d, np.int64)
    for i in range(nc):
        here[0], end[0] = n_start[i], n_start[i + 1]
        for a in range(1, d):
            here[a], end[a] = t_start[i * (d - 1) + a - 1], t_start[i * (d - 1) + a]
        while True:
            least = -1
            for a in range(d):
                if here[a] < end[a]:
                    j = t_column[here[a]] if a else n_column[here[a]]
                    if least < 0 or j < least:
                        least = j
            if least < 0:
                break
            column[at] = least
            for a in range(d):
                if here[a] < end[a] and (t_column[here[a]] if a else n_column[here[a]]) == least:
                    value[at, a] = t_value[here[a]] if a else n_value[here[a]]
                    here[a] += 1
            at += 1
        start[i + 1] = at
    return start, column[:at], value[:at]


@kernel
def by_row(start, column, value, first, d):  # type: ignore[no-untyped-def]
    """The rows first, ..., d-1 of every contact of a matrix by contacts, as a matrix by rows."""
    nc, own = len(start) - 1, d - first
    own_start, at = np.zeros(nc * own + 1, np.int32), 0
    own_column, own_value = np.empty(len(column) * own, np.int32), np.empty(len(column) * own)
    for i in range(nc):
        for a in range(first, d):
            for k in range(start[i], start[i + 1]):
                if value[k, a] != 0:
                    own_column[at], own_value[at] = column[k], value[k, a]
                    at += 1
            own_start[i * own + a - first + 1] = at
    return own_start, own_column[:at], own_value[:at]


@part
def normal_first(start, column, value):  # type: ignore[no-untyped-def]
    """A matrix by contacts with the columns of a contact's normal first, then those that the first tangent adds, and so on.

    Methods that sweep over the contacts add up in this order.
    """
    d, taken = value.shape[1], np.zeros(len(column), np.bool_)
    own_start, own_column, own_value, at = (
        np.zeros(len(start), np.int32),
        np.empty(len(column), np.int32),
        np.empty(value.shape),
        0,
    )
    for i in range(len(start) - 1):
        for a in range(d):
            for k in range(start[i], start[i + 1]):
                if value[k, a] != 0 and not taken[k]:
                    taken[k], own_column[at] = True, column[k]
                    for b in range(d):
                        own_value[at, b] = value[k, b]
                    at += 1
        own_start[i + 1] = at
    return own_start, own_column[:at], own_value[:at]
