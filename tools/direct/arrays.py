"""The inputs and results of calls by hand, and the forms that they make with numpy and scipy, without scaling.

A problem of nc contacts of dimension d consists of the arrays M and M^-1 (nv, nv), J (nc*d, nv), with a contact's normal row
first, v* (nv,), b (nc*d,), mu (nc,) and the joint equations F v = f, F (nj, nv), which a library's user would have: dense up to
DENSE contacts, otherwise scipy's sparse arrays. A problem given only by W and q has no mechanics. The friction LCP in the plane
is

    z = (c, beta+, beta-, lambda),      w = [W G + e lambda; mu c - beta+ - beta-] + q,

and the relaxation is min ½ v'Mv - (M v*)'v with S (J v + b) >= 0 in the plane, S_i = [1 mu; 1 -mu], and in the second-order
cone in space, S_i = diag(1, mu, mu); its multipliers z are impulses r = S'z.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import FrictionProblem, InputError

Array = NDArray[np.float64]
DENSE = 60  # contacts up to which dense arrays are faster


class Arrays(NamedTuple):
    """A problem by its mechanics, or by W and q if only these are known."""

    d: int
    mu: Array
    M: Any = None
    inverse: Any = None
    J: Any = None
    v: Any = None
    b: Any = None
    F: Any = None
    f: Any = None
    W: Any = None
    q: Any = None


class Called(NamedTuple):
    """The result of a call: impulse (nc, d), N s; whether the library claims success; its own time if it needs a child process,
    s; the compliance (nc, d) of its contacts if they are soft, 1/kg."""

    impulse: Array
    claimed: bool
    clock: float | None = None
    softness: Array | None = None


def arrays(problem: FrictionProblem) -> Arrays:
    """Return the arrays of a problem. Errors: InputError if it has a friction bias, for which these calls have no place."""
    if problem.friction_bias.any():
        raise InputError("friction_bias: calls by hand have none")
    nc, d = problem.contacts, problem.dimension
    kept = (lambda matrix: matrix.toarray()) if nc <= DENSE else sparse.csr_array
    if not problem.mechanical:
        return Arrays(d, problem.friction.copy(), W=kept(problem.W), q=problem.q.copy())
    b = np.zeros((nc, d))
    b[:, 0] = problem.bias
    M = sparse.csc_matrix(problem.mass)
    parts = kept(M), kept(sparse.csr_array(sparse.linalg.inv(M))), kept(problem.jacobian)
    motion = problem.free_velocity.copy(), b.ravel(), kept(problem.joints), -problem.joint_bias
    return Arrays(d, problem.friction.copy(), *parts, *motion)


def program(problem: Arrays) -> tuple[Any, Array, Any, Array]:
    """Return the relaxation's P, q, G and h, with h - G v in the cone."""
    S, nc, d = _edges(problem), len(problem.mu), problem.d
    h = np.einsum("iab,ib->ia", S, problem.b.reshape(nc, d)).ravel()
    if sparse.issparse(problem.J):
        G = -(sparse.bsr_array((S, np.arange(nc), np.arange(nc + 1))) @ problem.J)
    else:
        G = -(S @ problem.J.reshape(nc, d, -1)).reshape(nc * d, -1)
    return problem.M, -problem.M @ problem.v, G, h


def with_joints(problem: Arrays, G: Any, h: Array, first: bool = False) -> tuple[Any, Array, int]:
    """Return G above F, or F above G, the same of h and f, and the number of joint equations."""
    if not len(problem.f):
        return G, h, 0
    rows, right = ((problem.F, G), (problem.f, h)) if first else ((G, problem.F), (h, problem.f))
    stacked = sparse.vstack(rows, format="csc") if sparse.issparse(G) else np.vstack(rows)
    return stacked, np.concatenate(right), len(problem.f)


def of_multipliers(problem: Arrays, z: Array) -> Array:
    """Return the impulses for the relaxation's multipliers, of which the first belong to G."""
    return np.einsum("iab,ia->ib", _edges(problem), z[: problem.d * len(problem.mu)].reshape(-1, problem.d))


def _edges(problem: Arrays) -> Array:
    """Return S (nc, d, d)."""
    mu = problem.mu
    S = np.zeros((len(mu), problem.d, problem.d))
    S[:, 0, 0] = 1.0
    if problem.d == 2:
        S[:, 1, 0], S[:, 0, 1], S[:, 1, 1] = 1.0, mu, -mu
    else:
        S[:, 1, 1] = S[:, 2, 2] = mu
    return S


def delassus(problem: Arrays) -> tuple[Any, Array]:
    """Return W and q, with a contact's normal row first."""
    if problem.W is not None:
        return problem.W, problem.q
    return problem.J @ problem.inverse @ problem.J.T, problem.J @ problem.v + problem.b


def dense(matrix: Any) -> Array:
    """Return a matrix as a numpy array."""
    return matrix.toarray() if sparse.issparse(matrix) else matrix


def lcp(problem: Arrays) -> tuple[Array, Array]:
    """Return M and q of Glocker and Pfeiffer's friction LCP in the plane, of (r_n, mu r_n + r_t, g-)."""
    W, q = map(dense, delassus(problem))
    nc, i = len(problem.mu), np.arange(len(problem.mu))
    M = np.zeros((3 * nc, 3 * nc))
    M[: 2 * nc, nc : 2 * nc] = np.vstack([W[::2, 1::2], W[1::2, 1::2]])
    M[: 2 * nc, :nc] = np.vstack([W[::2, ::2], W[1::2, ::2]]) - M[: 2 * nc, nc : 2 * nc] * problem.mu
    M[nc + i, 2 * nc + i], M[2 * nc + i, i], M[2 * nc + i, nc + i] = 1.0, 2 * problem.mu, -1.0
    return M, np.concatenate([q[::2], q[1::2], np.zeros(nc)])


def of_lcp(problem: Arrays, z: Array) -> Array:
    """Return the impulses for a solution of the friction LCP."""
    normal, edge, _ = np.reshape(z, (3, -1))
    return np.column_stack([normal, edge - problem.mu * normal])
