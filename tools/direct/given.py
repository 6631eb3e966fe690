"""What calls by hand are given and return, and what they form of it with numpy, unscaled.

A problem in the plane is the dense arrays M (nv, nv), N and T (nc, nv), v* (nv,), b (nc,) and mu (nc,), which a user of a
library has at hand. The friction LCP is

    z = (c, beta+, beta-, lambda),      w = [W G + e lambda; mu c - beta+ - beta-] + q,

and the relaxation's QP is min ½ v'Mv - (M v*)'v with C v + b >= 0, two rows N_i + mu_i T_i and N_i - mu_i T_i a contact.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import FrictionProblem

Array = NDArray[np.float64]


class Arrays(NamedTuple):
    """A problem in the plane, without joints and friction bias."""

    M: Array
    N: Array
    T: Array
    v: Array
    b: Array
    mu: Array


class Called(NamedTuple):
    """What a call returns: impulse (nc, 2), N s; whether the library claims success; its own time where it needs a child, s."""

    impulse: Array
    claimed: bool
    clock: float | None = None


def arrays(problem: FrictionProblem) -> Arrays:
    """The dense arrays of a problem."""
    M, N, T = problem.mass.toarray(), problem.normal.toarray(), problem.tangent.toarray()
    return Arrays(M, N, T, problem.free_velocity.copy(), problem.bias.copy(), problem.friction.copy())


def program(given: Arrays) -> tuple[Array, Array, Array, Array]:
    """The QP's P, q, G and h, with G v <= h."""
    M, N, T, v, b, mu = given
    slip = mu[:, None] * T
    return M, -M @ v, -np.stack([N + slip, N - slip], axis=1).reshape(2 * len(mu), len(v)), np.repeat(b, 2)


def of_multipliers(given: Arrays, z: Array) -> Array:
    """The impulses of the QP's multipliers."""
    return np.column_stack([z[0::2] + z[1::2], given.mu * (z[0::2] - z[1::2])])


def delassus(given: Arrays) -> tuple[Array, Array]:
    """W and q, a contact's normal row first."""
    M, N, T, v, b, mu = given
    J = np.stack([N, T], axis=1).reshape(2 * len(mu), len(v))
    q = J @ v
    q[0::2] += b
    return J @ np.linalg.solve(M, J.T), q


def lcp(given: Arrays) -> tuple[Array, Array]:
    """The friction LCP's M and q."""
    W, q = delassus(given)
    nc = len(given.mu)
    D = np.zeros((2 * nc, 3 * nc))
    i = np.arange(nc)
    D[2 * i, i], D[2 * i + 1, nc + i], D[2 * i + 1, 2 * nc + i] = 1.0, 1.0, -1.0
    M = np.zeros((4 * nc, 4 * nc))
    M[: 3 * nc, : 3 * nc] = D.T @ W @ D
    M[nc + i, 3 * nc + i] = M[2 * nc + i, 3 * nc + i] = 1.0
    M[3 * nc + i, i], M[3 * nc + i, nc + i], M[3 * nc + i, 2 * nc + i] = given.mu, -1.0, -1.0
    return M, np.concatenate([D.T @ q, np.zeros(nc)])


def of_lcp(z: Array) -> Array:
    """The impulses of the friction LCP's solution."""
    nc = len(z) // 4
    return np.column_stack([z[:nc], z[nc : 2 * nc] - z[2 * nc : 3 * nc]])
