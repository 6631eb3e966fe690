"""Whether a given matrix is positive semidefinite, as W must be.

It is decided by estimates of the least and the largest eigenvalue from a few products with the matrix (Lanczos 1950). A Ritz
value is a weighted mean of eigenvalues: the least is never below the least eigenvalue, the largest never above the largest. Few
steps suffice for extreme eigenvalues that are well separated, such as the negative ones of a matrix that is indefinite by more
than round-off; up to STEPS rows the values are exact.
"""

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array, InputError, require

LARGEST = 1e150  # 1/kg, of an entry; squares of larger ones overflow
DIGITS = 1e-6  # of the largest entry: what is unsymmetric by no more counts as rounding in a file
INDEFINITE = 1e-6  # of the largest eigenvalue: recorded problems are indefinite by that much, as their files round W's digits
STEPS = 60  # products with the matrix; up to so many rows the values are exact


def require_semidefinite(field: str, W: sparse.csr_array) -> None:
    """Errors: InputError naming the field where W (n, n) overflows, has entries on one side of its diagonal alone that are more
    than rounding, as one stored by a triangle does, or its symmetric part has an eigenvalue below -INDEFINITE of the largest,
    as far as spectrum_ends finds it."""
    require(abs(W).max() < LARGEST if W.nnz else True, field, f"its entries must be below {LARGEST:g}")
    sides = sparse.tril(W, -1, format="coo"), sparse.triu(W, 1, format="coo")
    for side, other in (sides, sides[::-1]):
        if side.nnz and not other.nnz and abs(side.data).max() > DIGITS * abs(W).max():
            most = abs(side.data).argmax()
            i, j = side.row[most], side.col[most]
            raise InputError(f"{field}: holds one triangle: entry ({i}, {j}) is {side.data[most]:.3g}, but ({j}, {i}) is 0")
    least, largest = spectrum_ends(W)
    require(least >= -INDEFINITE * max(largest, 0.0), field, "not positive semidefinite")


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
