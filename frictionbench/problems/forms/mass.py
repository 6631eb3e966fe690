"""The inverse of a mass matrix.

A multibody system's mass matrix is block diagonal, with a block for each body or each set of coupled generalised coordinates.
Each block's inverse is dense, so the inverse has the same block structure. Verdicts are found with it and count only the
rounding of its entries, so that an ill-conditioned block's is refined.
"""

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.sparse.csgraph import connected_components

from frictionbench.problems.check import require
from frictionbench.problems.rows import Array, Index64, Rows

UNREFINED = 1e4  # the largest M_ii X_ii of an unrefined X; the condition number of M scaled to a unit diagonal is no less


def inverse_mass(mass: Rows) -> Rows:
    """The inverse of a symmetric positive definite (nv, nv) matrix by rows, block by block.

    Errors: InputError naming `mass` if it is not symmetric to rounding or not positive definite.
    """
    n, value = len(mass.start) - 1, mass.value
    is_diagonal = np.array_equal(mass.start, np.arange(n + 1)) and np.array_equal(mass.column, mass.start[:-1])
    if is_diagonal and bool((value > 0).all()):
        return Rows(mass.start, mass.column, 1 / value)
    length = np.diff(mass.start)
    row = np.repeat(np.arange(n), length)
    diagonal = np.bincount(row, np.where(row == mass.column, value, 0.0), n)
    require(bool((diagonal > 0).all()), "mass", "not positive definite: a diagonal entry is not positive")
    coupled = length.max() == n  # a row without zeros couples all coordinates, as that of a robot's base does
    label = np.zeros(n, int) if coupled else connected_components(mass.matrix(n), directed=False)[1]
    size = np.bincount(label)
    start = np.append(0, size[label].cumsum()).astype(np.int32)
    column, inverse = np.empty(start[-1], np.int32), np.empty(start[-1])
    blocks = np.split(np.argsort(label, kind="stable"), size.cumsum()[:-1])
    entries = np.split(np.argsort(label[row], kind="stable"), np.bincount(label[row]).cumsum()[:-1])
    place, allowed = np.empty(n, int), 1e-12 * np.abs(value).max()
    for coordinates, in_block in zip(blocks, entries, strict=True):
        place[coordinates] = np.arange(len(coordinates))
        block = np.zeros((len(coordinates), len(coordinates)))
        block[place[row[in_block]], place[mass.column[in_block]]] = value[in_block]
        require(bool(np.abs(block - block.T).max() <= allowed), "mass", "not symmetric")
        at = start[coordinates][:, None] + np.arange(len(coordinates))
        column[at], inverse[at] = coordinates, _inverse(block, coordinates)
    return Rows(start, column, inverse)


def _inverse(block: Array, coordinates: Index64) -> Array:
    """The symmetric inverse of a dense block. Errors: InputError naming mass and the coordinates of the block."""
    try:
        inverse = cho_solve(cho_factor(block), np.eye(len(block)))
    except LinAlgError:
        inverse = np.full_like(block, np.nan)
    named = coordinates[:6].tolist()
    require(bool(np.isfinite(inverse).all()), "mass", f"not positive definite in the coordinates {named}")
    if (np.diag(block) * np.diag(inverse)).max() > UNREFINED:
        inverse = _refined(block, inverse)
    return np.asarray((inverse + inverse.T) / 2)


def _refined(M: Array, inverse: Array) -> Array:
    """X + X (I - M X), twice, with M scaled by powers of 2 to a diagonal near 1."""
    scale = np.exp2(-np.round(np.log2(np.diag(M)) / 2))
    scale = scale * scale[:, None]
    parts, X = _parts(M * scale), inverse / scale
    for _ in range(2):
        X = (X + X.T) / 2
        missed = np.eye(len(M), dtype=np.longdouble)
        for one in parts:
            for other in _parts(X):
                missed -= one @ other.T
        X = X + X @ missed.astype(float)
    return X * scale


def _parts(matrix: Array) -> list[Array]:
    """Three summands of a matrix, with so few digits in a row of the first two that their products are exact (Ozaki 2012)."""
    bits, parts = (53 - np.log2(len(matrix))) // 2, []
    large = 1.5 * np.exp2(np.ceil(np.log2(np.abs(matrix).max(axis=1, keepdims=True))) + 52 - bits)
    for shift in (large, large * 2.0**-bits):
        parts.append(matrix + shift - shift)
        matrix = matrix - parts[-1]
    return [*parts, matrix]
