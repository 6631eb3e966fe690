"""The local and the global form of recorded friction problems, including joints (Acary, Brémond and Huber 2018; FCLIB).

    local    u = W r + V l + q,   0 = V' r + R l + s
    global   M v = H r + G l + f,   u = H' v + w,   0 = G' v + b

with rows per contact, normal first. A global problem keeps its sparse M and H. Two kinds cannot be written as a FrictionProblem
with a mass matrix and are reduced to their local form: those with an unsymmetric M, and those whose w acts on tangential
velocities.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.archive import in_letters

MOST_COUPLED = 4000  # coordinates of one block of M, or joints of a local problem: a dense inverse takes 128 MB
MOST_DENSE = 2**27  # entries of a dense matrix: 1 GiB
SYMMETRIC = 1e-12  # relative asymmetry up to which M is symmetric, as in FrictionProblem
LETTERS = {"mass": "M", "normal": "H", "tangent": "H", "friction": "mu", "bias": "w", "joints": "G", "joint_bias": "b"}


def from_global(
    M: sparse.csr_array,
    H: sparse.csr_array,
    f: Array,
    w: Array,
    mu: Array,
    d: int,
    G: sparse.csr_array | None = None,
    b: Array | None = None,
) -> FrictionProblem:
    """The problem of a global form: M (nv, nv), H (nv, nc*d), f (nv), w (nc*d), mu (nc), G (nv, nj), b (nj)."""
    nv = M.shape[0]
    require(M.shape == (nv, nv), "M", f"expected a square matrix, got shape {M.shape}")
    require(H.shape == (nv, len(mu) * d), "H", f"expected shape {(nv, len(mu) * d)}, got {H.shape}")
    require(len(f) == nv, "f", f"expected length {nv}, got {len(f)}")
    require(len(w) == len(mu) * d, "w", f"expected length {len(mu) * d}, got {len(w)}")
    for name, value in {"M": M.data, "H": H.data, "f": f, "w": w}.items():
        require(bool(np.isfinite(value).all()), name, "all entries must be finite")
    coupled = np.bincount(connected_components(M, directed=False)[1]).max(initial=0)
    require(coupled <= MOST_COUPLED, "M", f"{coupled} coordinates are coupled; a dense inverse has at most {MOST_COUPLED}")
    free = _solve(M, f)
    normal = np.arange(len(w)) % d == 0
    off = abs(M - M.T)
    if (not off.nnz or off.max() <= SYMMETRIC * abs(M).max()) and not w[~normal].any():
        J = sparse.csr_array(H.T)
        joints = None if G is None else sparse.csr_array(G.T)
        with in_letters(LETTERS):
            return FrictionProblem(
                mass=M,
                normal=J[normal],
                tangent=J[~normal],
                friction=mu,
                free_velocity=free,
                bias=w[normal],
                joints=joints,
                joint_bias=np.zeros(0) if b is None else b,
                dimension=d,
            )
    response = _solve(M, _dense("H", H))
    W, q = sparse.csr_array(H.T @ response), H.T @ free + w
    if G is None or b is None:
        return FrictionProblem.from_delassus(W, q, mu, d)
    held = _solve(M, _dense("G", G))
    return from_local(W, q, mu, d, sparse.csr_array(H.T @ held), sparse.csr_array(G.T @ held), G.T @ free + b)


def from_local(
    W: sparse.csr_array,
    q: Array,
    mu: Array,
    d: int,
    V: sparse.csr_array | None = None,
    R: sparse.csr_array | None = None,
    s: Array | None = None,
) -> FrictionProblem:
    """The problem of a local form, without its joints: W (nc*d, nc*d), q (nc*d), mu (nc), V (nc*d, nj), R (nj, nj), s (nj)."""
    if V is None or R is None or s is None:
        return FrictionProblem.from_delassus(W, q, mu, d)
    nj = len(s)
    require(R.shape == (nj, nj), "R", f"expected shape {(nj, nj)}, got {R.shape}")
    require(V.shape == (len(q), nj), "V", f"expected shape {(len(q), nj)}, got {V.shape}")
    require(nj <= MOST_COUPLED, "R", f"{nj} joints; a dense inverse has at most {MOST_COUPLED}")
    for name, value in {"V": V.data, "R": R.data, "s": s}.items():
        require(bool(np.isfinite(value).all()), name, "all entries must be finite")
    inverse = np.linalg.pinv(R.toarray())  # joints may be redundant
    return FrictionProblem.from_delassus(W - V @ sparse.csr_array(inverse @ _dense("V", V).T), q - V @ (inverse @ s), mu, d)


def _dense(name: str, matrix: sparse.csr_array) -> Array:
    """The matrix as a dense array. Errors: InputError naming it if that is too large."""
    m, n = matrix.shape
    require(m * n <= MOST_DENSE, name, f"of shape {(m, n)} is needed dense; at most {MOST_DENSE} entries are")
    return matrix.toarray()


def _solve(M: sparse.csr_array, right: Array) -> Array:
    """M^-1 right."""
    diagonal = M.diagonal()
    if M.nnz == np.count_nonzero(diagonal) == len(diagonal):
        with np.errstate(over="ignore"):  # infinite values are refused later
            return (right.T / diagonal).T
    try:
        solution = splu(sparse.csc_array(M)).solve(right)
    except RuntimeError as error:
        raise InputError(f"M: {' '.join(str(error).split())}") from None
    require(bool(np.isfinite(solution).all()), "M", "singular")
    return solution
