"""Estimates of the least and the largest eigenvalue of a symmetric matrix from a few products with it (Lanczos 1950).

A Ritz value is a weighted mean of eigenvalues: the least is never below the least eigenvalue, the largest never above the
largest. Few steps suffice for extreme eigenvalues that are well separated, such as the negative ones of a matrix that is
indefinite by more than round-off; up to STEPS rows the values are exact.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array

STEPS = 60  # products with the matrix; up to so many rows the values are exact


def spectrum_ends(A: sparse.csr_array) -> tuple[float, float]:
    """The least and the largest Ritz value of (A + A')/2, for A (n, n); (0, 0) where n = 0."""
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
    """The unit vector along direction less its part in the span of basis's orthonormal rows; twice, for the rounding."""
    for _ in range(2):
        direction = direction - basis.T @ (basis @ direction)
        direction = direction / np.linalg.norm(direction)
    return direction
