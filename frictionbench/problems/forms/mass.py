"""The inverse of a mass matrix.

A multibody system's mass matrix is block diagonal: a block per body, or per set of coordinates that generalised
coordinates couple. Each block's inverse is dense, so the inverse has the blocks' own sparsity.
"""

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.check import require
from frictionbench.problems.compiled import kernel
from frictionbench.problems.rows import Array, Index64, Rows, from_matrix

DENSE = 300  # velocities up to which one block, as of a robot, is inverted without scipy's sparse matrices


def inverse_mass(mass: Rows) -> Rows:
    """The inverse of a symmetric positive definite (nv, nv) matrix by rows, block by block.

    Errors: InputError naming `mass` where it is not symmetric to round-off or not positive definite.
    """
    n = len(mass.start) - 1
    inverse, diagonal = _reciprocal(*mass)
    if diagonal:
        return Rows(mass.start, mass.column, inverse)
    matrix = mass.matrix(n)
    count, label = connected_components(matrix, directed=False)
    if count == 1 and n <= DENSE:
        dense = mass.dense(n)
        _require_symmetric(dense.diagonal(), float(np.abs(dense - dense.T).max()), float(np.abs(dense).max()))
        start, column = n * np.arange(n + 1, dtype=np.int32), np.tile(np.arange(n, dtype=np.int32), n)
        return Rows(start, column, _inverse(dense, np.arange(n)).ravel())
    return from_matrix(_by_blocks(matrix, count, label))


@kernel
def _reciprocal(start, column, value):  # type: ignore[no-untyped-def]
    """(1/value, whether that is the inverse: the matrix is diagonal, with positive entries)."""
    inverse = np.empty(len(value))
    for i in range(len(start) - 1):
        k = start[i]
        if start[i + 1] != k + 1 or column[k] != i or not value[k] > 0:
            return inverse, False
        inverse[k] = 1 / value[k]
    return inverse, True


def _by_blocks(mass: sparse.csr_array, count: int, label: Index64) -> sparse.csr_array:
    """The inverse, block by block; label: (nv,), the block of each coordinate. Errors: as of inverse_mass."""
    asymmetry = abs(mass - mass.T)
    _require_symmetric(mass.diagonal(), asymmetry.max() if asymmetry.nnz else 0.0, abs(mass).max() if mass.nnz else 0.0)
    order = np.argsort(label, kind="stable")
    blocks = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
    rows, columns, entries = [], [], []
    for block in blocks:
        rows.append(np.repeat(block, len(block)))
        columns.append(np.tile(block, len(block)))
        entries.append(_inverse(mass[block][:, block].toarray(), block).ravel())
    triplets = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_array(sparse.coo_array(triplets, shape=mass.shape))


def _require_symmetric(diagonal: Array, asymmetry: float, largest: float) -> None:
    require(bool(np.all(diagonal > 0)), "mass", "not positive definite: a diagonal entry is not positive")
    require(asymmetry <= 1e-12 * largest, "mass", "not symmetric")


def _inverse(block: Array, coordinates: Index64) -> Array:
    """The inverse of a dense block, symmetric. Errors: InputError naming mass and the coordinates of the block."""
    try:
        inverse = cho_solve(cho_factor(block), np.eye(len(block)))
    except LinAlgError:
        inverse = np.full_like(block, np.nan)
    named = coordinates[:6].tolist()
    require(bool(np.isfinite(inverse).all()), "mass", f"not positive definite in the coordinates {named}")
    return np.asarray((inverse + inverse.T) / 2)
