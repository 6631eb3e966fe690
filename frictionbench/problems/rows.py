"""Sparse matrices as plain arrays, which compiled code reads and writes.

By rows (the CSR arrays): row i has the entries value[k] in the columns column[k], start[i] <= k < start[i+1], with ascending
columns and no zeros. By contacts: contact i has d entries value[k] in each column column[k], the normal's first, of which some
may be zero. SciPy's matrices are made from these on demand, for users and outside libraries: making one takes as long as all
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
        """The matrix as SciPy's CSR array; read-only."""
        parts = [piece.view() for piece in (self.value, self.column, self.start)]
        for piece in parts:
            piece.setflags(write=False)
        return sparse.csr_array(tuple(parts), shape=(len(self.start) - 1, columns))

    def dense(self, columns: int) -> Array:
        """The matrix as a new array (rows, columns)."""
        dense = np.zeros((len(self.start) - 1, columns))
        dense[row_of_entry(self.start), self.column] = self.value
        return dense


class ByContact(NamedTuple):
    """A matrix with d rows per contact: start (nc+1,), column (entries,), value (entries, d)."""

    start: Index32
    column: Index32
    value: Array


def row_of_entry(start: Index32) -> Index64:
    """The row of each entry (entries,)."""
    return np.repeat(np.arange(len(start) - 1), np.diff(start))


def from_dense(dense: Array) -> Rows:
    """A dense matrix by rows."""
    row, column = np.nonzero(dense)
    return Rows(_starts(row, len(dense)), column.astype(np.int32), dense[row, column])


def _starts(row: Index64, rows: int) -> Index32:
    """The start of each row (rows+1,) among entries that are sorted by rows."""
    return np.searchsorted(row, np.arange(rows + 1)).astype(np.int32)


def from_matrix(matrix: sparse.csr_array) -> Rows:
    """A copy by rows of a canonical SciPy matrix."""
    return Rows(np.array(matrix.indptr, np.int32), np.array(matrix.indices, np.int32), np.array(matrix.data))


def by_contact(normal: Rows, tangent: Rows, d: int) -> ByContact:
    """Each contact's normal row and its d-1 tangent rows, by contacts over the union of their columns."""
    nc = len(normal.start) - 1
    row = [row_of_entry(rows.start) for rows in (normal, tangent)]
    contact, axis = np.append(row[0], row[1] // (d - 1)), np.append(0 * row[0], 1 + row[1] % (d - 1))
    column = np.append(normal.column, tangent.column)
    width = int(column.max(initial=0)) + 1
    place, entry = np.unique(contact * width + column, return_inverse=True)
    value = np.zeros((len(place), d))
    value[entry, axis] = np.append(normal.value, tangent.value)
    return ByContact(_starts(place // width, nc), (place % width).astype(np.int32), value)


def relative(bodies: Index64, along: Array, spins: Array) -> Rows:
    """Rows (nc*k, nv) of the first body's velocity relative to the second's, at contacts of bodies (nc, 2), -1 for the ground.

    along: (nc, k, d), the directions: the coefficients of a body's velocity. spins: (nc, k, 2, s), those of both bodies' spins.
    """
    moves = np.broadcast_to(along[:, :, None], (*spins.shape[:3], along.shape[2]))
    order = np.argsort(bodies, axis=1)  # columns ascending
    value = np.take_along_axis(np.concatenate([moves, spins], axis=3) * [[1.0], [-1.0]], order[:, None, :, None], axis=2)
    body = np.take_along_axis(bodies, order, axis=1)[:, None, :, None]
    column = np.broadcast_to(value.shape[3] * body + np.arange(value.shape[3]), value.shape)
    kept = (value != 0) & (body >= 0)
    start = np.append(0, kept.sum(axis=(2, 3)).cumsum())
    return Rows(start.astype(np.int32), column[kept].astype(np.int32), value[kept])


def planar_relative(bodies: Index64, arms: Array, along: Array) -> Rows:
    """`relative` (nc, nv) for planar bodies, along one direction (nc, 2) per contact. arms: (nc, 2, 2), from both centres."""
    spins = arms[:, :, 0] * along[:, None, 1] - arms[:, :, 1] * along[:, None, 0]
    return relative(bodies, along[:, None], spins[:, None, :, None])


@kernel
def by_row(start, column, value, first, d):  # type: ignore[no-untyped-def]
    """The rows first, ..., d-1 of every contact of a matrix by contacts, as a matrix by rows."""
    nc, kept = len(start) - 1, d - first
    own_start, at = np.zeros(nc * kept + 1, np.int32), 0
    own_column, own_value = np.empty(len(column) * kept, np.int32), np.empty(len(column) * kept)
    for i in range(nc):
        for a in range(first, d):
            for k in range(start[i], start[i + 1]):
                if value[k, a] != 0:
                    own_column[at], own_value[at] = column[k], value[k, a]
                    at += 1
            own_start[i * kept + a - first + 1] = at
    return own_start, own_column[:at], own_value[:at]


@part
def normal_first(start, column, value):  # type: ignore[no-untyped-def]
    """A matrix by contacts, with a contact's columns in this order: those of the normal, those added by the first tangent, etc.

    Methods that sweep over contacts sum in this order.
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
