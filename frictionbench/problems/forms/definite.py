"""Whether a given matrix is positive semidefinite, as W must be.

The test estimates the smallest and the largest eigenvalue from a few products with the matrix (Lanczos 1950). A Ritz value is a
weighted mean of eigenvalues, so the smallest is never below the smallest eigenvalue and the largest never above the largest. A
few steps suffice for well separated extreme eigenvalues, such as the negative ones of a matrix that is indefinite by more than
rounding. For up to STEPS rows the values are exact.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array, InputError, require

LARGEST_INPUT = 1e150  # for an entry of W in 1/kg, and for friction: the squares of larger ones overflow
FILE_ROUNDING = 1e-6  # relative to the largest entry: an asymmetry up to this counts as rounding in a file
INDEFINITE = 1e-6  # relative to the largest eigenvalue: W may be indefinite by this, because files round its digits
STEPS = 60  # products with the matrix; with at most this number of rows the values are exact


def require_semidefinite(field: str, W: sparse.csr_array) -> None:
    """Errors: InputError naming the field if W's (n, n) largest entry is not 0 or from 1/LARGEST_INPUT to LARGEST_INPUT; if
    only one of its triangles has entries and they exceed rounding, because the other triangle was probably not stored; or if
    its symmetric part has an eigenvalue below -INDEFINITE times the largest, as estimated by spectrum_ends."""
    least, most = 1 / LARGEST_INPUT, LARGEST_INPUT
    require(not W.nnz or least <= abs(W).max() < most, field, f"its largest entry must be 0 or from {least:g} to {most:g}")
    sides = sparse.tril(W, -1, format="coo"), sparse.triu(W, 1, format="coo")
    for side, other in (sides, sides[::-1]):
        if side.nnz and not other.nnz and abs(side.data).max() > FILE_ROUNDING * abs(W).max():
            most = abs(side.data).argmax()
            i, j = side.row[most], side.col[most]
            raise InputError(f"{field}: holds one triangle: entry ({i}, {j}) is {side.data[most]:.3g}, but ({j}, {i}) is 0")
    least, largest = spectrum_ends(W)
    require(least >= -INDEFINITE * max(largest, 0.0), field, "not positive semidefinite")


def spectrum_ends(A: sparse.csr_array) -> tuple[float, float]:
    """Estimates of the smallest and the largest eigenvalue of (A + A')/2, for A (n, n); (0, 0) if n = 0."""
    n = A.shape[0]
    if not n:
        return 0.0, 0.0
    symmetric = sparse.csr_array((A + A.T) / 2)
    random = np.random.default_rng(0)
    count = min(n, STEPS)
    basis, image = np.zeros((count, n)), np.zeros((count, n))
    direction = random.standard_normal(n)
    for k in range(count):
        basis[k] = _orthogonal_to(basis[:k], direction)
        image[k] = symmetric @ basis[k]
        direction = image[k] - basis[: k + 1].T @ (basis[: k + 1] @ image[k])
        if np.linalg.norm(direction) <= 1e-12 * np.linalg.norm(image[k]):  # an invariant subspace: continue orthogonally to it
            direction = random.standard_normal(n)
    values = np.linalg.eigvalsh(basis @ image.T)
    diagonal = symmetric.diagonal()
    return float(min(values[0], diagonal.min())), float(max(values[-1], diagonal.max()))


def _orthogonal_to(basis: Array, direction: Array) -> Array:
    """The normalised part of direction orthogonal to basis's orthonormal rows; projected twice to reduce rounding errors."""
    for _ in range(2):
        direction = direction - basis.T @ (basis @ direction)
        direction = direction / np.linalg.norm(direction)
    return direction
