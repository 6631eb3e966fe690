"""u = W r + q as plain arrays, for solvers that hand them to C or to a library."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import set_read_only
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
    nc, d = len(blocks.first) - 1, blocks.block.shape[1]
    W = np.zeros((nc * d, nc * d))
    W.reshape(nc, d, nc, d)[np.repeat(np.arange(nc), np.diff(blocks.first)), :, blocks.neighbours] = blocks.block
    W.setflags(write=False)
    return Dense(W, q)


def csr(blocks: Blocks, q: Array) -> CSR:
    """W, given by blocks, in compressed rows."""
    W = blocks.matrix()
    set_read_only(W)
    return CSR(W.indptr, W.indices, W.data, q)
