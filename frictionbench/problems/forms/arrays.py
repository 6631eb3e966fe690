"""u = W r + q as plain arrays, for solvers that hand them to C or to a library: one compiled pass over the blocks of W each."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.compiled import kernel
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.rows import Array, Index32


class Dense(NamedTuple):
    """W (nc*d, nc*d), 1/kg, by rows in memory, and q (nc*d,), m/s; float64, C-contiguous and read-only."""

    W: Array
    q: Array


class CSR(NamedTuple):
    """W in compressed rows: row i has data[k] in column indices[k] for k in indptr[i]:indptr[i+1], columns ascending, no zeros.

    indptr (nc*d + 1,) and indices: int32; data: float64, 1/kg; q (nc*d,), m/s. C-contiguous and read-only.
    """

    indptr: Index32
    indices: Index32
    data: Array
    q: Array


def dense(blocks: Blocks, q: Array) -> Dense:
    """W, given by blocks, as one array."""
    W: Array = _dense(*blocks)
    W.setflags(write=False)
    return Dense(W, q)


def csr(blocks: Blocks, q: Array) -> CSR:
    """W, given by blocks, in compressed rows."""
    indptr, indices, data = _csr(*blocks)
    for array in (indptr, indices, data):
        array.setflags(write=False)
    return CSR(indptr, indices, data, q)


@kernel
def _dense(first, neighbours, block):  # type: ignore[no-untyped-def]
    nc, d = len(first) - 1, block.shape[1]
    W = np.zeros((nc * d, nc * d))
    for i in range(nc):
        for k in range(first[i], first[i + 1]):
            for a in range(d):
                for b in range(d):
                    W[i * d + a, neighbours[k] * d + b] = block[k, a, b]
    return W


@kernel
def _csr(first, neighbours, block):  # type: ignore[no-untyped-def]
    nc, d = len(first) - 1, block.shape[1]
    indptr = np.zeros(nc * d + 1, np.int32)
    indices, data, at = np.empty(block.size, np.int32), np.empty(block.size), 0
    for i in range(nc):
        for a in range(d):
            for k in range(first[i], first[i + 1]):
                for b in range(d):
                    if block[k, a, b] != 0:
                        indices[at], data[at] = neighbours[k] * d + b, block[k, a, b]
                        at += 1
            indptr[i * d + a + 1] = at
    return indptr, indices[:at].copy(), data[:at].copy()
