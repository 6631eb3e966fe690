"""The inverse of a mass matrix.

A multibody system's mass matrix is block diagonal: a block per body, or per set of coordinates that generalised
coordinates couple. Each block's inverse is dense, so the inverse has the blocks' own sparsity.
"""

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.check import require
from frictionbench.problems.rows import Array, Index64, Rows, from_matrix


def inverse_mass(mass: Rows) -> Rows:
    """The inverse of a symmetric positive definite (nv, nv) matrix by rows, block by block.

    Errors: InputError naming `mass` where it is not symmetric to round-off or not positive definite.
    """
    n, value = len(mass.start) - 1, mass.value
    alone = np.array_equal(mass.start, np.arange(n + 1)) and np.array_equal(mass.column, mass.start[:-1])
    if alone and bool((value > 0).all()):
        return Rows(mass.start, mass.column, 1 / value)
    matrix = mass.matrix(n)
    return from_matrix(_by_blocks(matrix, *connected_components(matrix, directed=False)))


def _by_blocks(mass: sparse.csr_array, count: int, label: Index64) -> sparse.csr_array:
    """The inverse, block by block; label: (nv,), the block of each coordinate. Errors: as of inverse_mass."""
    asymmetry = abs(mass - mass.T)
    require(bool(np.all(mass.diagonal() > 0)), "mass", "not positive definite: a diagonal entry is not positive")
    require(not asymmetry.nnz or asymmetry.max() <= 1e-12 * abs(mass).max(), "mass", "not symmetric")
    order = np.argsort(label, kind="stable")
    blocks = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
    rows, columns, entries = [], [], []
    for block in blocks:
        rows.append(np.repeat(block, len(block)))
        columns.append(np.tile(block, len(block)))
        entries.append(_inverse(mass[block][:, block].toarray(), block).ravel())
    triplets = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_array(sparse.coo_array(triplets, shape=mass.shape))


def _inverse(block: Array, coordinates: Index64) -> Array:
    """The inverse of a dense block, symmetric. Errors: InputError naming mass and the coordinates of the block."""
    try:
        inverse = cho_solve(cho_factor(block), np.eye(len(block)))
    except LinAlgError:
        inverse = np.full_like(block, np.nan)
    named = coordinates[:6].tolist()
    require(bool(np.isfinite(inverse).all()), "mass", f"not positive definite in the coordinates {named}")
    return np.asarray((inverse + inverse.T) / 2)
