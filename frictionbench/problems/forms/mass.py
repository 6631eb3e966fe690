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
from frictionbench.problems.rows import Rows, from_matrix


def inverse_mass(mass: Rows) -> Rows:
    """The inverse of a symmetric positive definite (nv, nv) matrix by rows, block by block.

    Errors: InputError naming `mass` where it is not symmetric to round-off or not positive definite.
    """
    n = len(mass.start) - 1
    inverse, diagonal = _reciprocal(*mass)
    if diagonal:
        return Rows(mass.start, mass.column, inverse)
    return from_matrix(_by_blocks(mass.matrix(n)))


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


def _by_blocks(mass: sparse.csr_array) -> sparse.csr_array:
    """The inverse of a symmetric positive definite (nv, nv) matrix, block by block.

    Errors: InputError naming `mass` where it is not symmetric to round-off or not positive definite.
    """
    diagonal = mass.diagonal()
    require(bool(np.all(diagonal > 0)), "mass", "not positive definite: a diagonal entry is not positive")
    asymmetry = abs(mass - mass.T)
    require(asymmetry.nnz == 0 or asymmetry.max() <= 1e-12 * abs(mass).max(), "mass", "not symmetric")
    count, label = connected_components(mass, directed=False)
    order = np.argsort(label, kind="stable")
    blocks = np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1])
    rows, columns, entries = [], [], []
    for block in blocks:
        dense = mass[block][:, block].toarray()
        try:
            inverse = cho_solve(cho_factor(dense), np.eye(len(block)))
        except LinAlgError:
            inverse = np.full_like(dense, np.nan)
        require(bool(np.isfinite(inverse).all()), "mass", f"not positive definite in the coordinates {block[:6].tolist()}")
        rows.append(np.repeat(block, len(block)))
        columns.append(np.tile(block, len(block)))
        entries.append((inverse + inverse.T).ravel() / 2)
    triplets = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_array(sparse.coo_array(triplets, shape=mass.shape))
