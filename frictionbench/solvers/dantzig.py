"""Dantzig's principal pivoting for contact, one index at a time, after Baraff (1994).

    w = M z + q,   w, z >= 0,   w'z = 0.

The pairs are processed in order, contact by contact: normal, sliding speed, tangent directions. The pairs processed so far
satisfy their conditions; the others are ignored, with z = 0. If the next pair r has w_r < 0, its impulse z_r is increased
until w_r = 0. When a variable of a pair already processed reaches zero, it is exchanged with its complement.

In Baraff's formulation a contact is clamped or free and a friction force has limits mu f_n. Here the pair w_lambda = mu c -
e'beta and lambda of the LCP expresses these limits, so that their dependence on c needs no special case. Increasing z_r is then
a path of Lemke's method for the pairs processed, with a covering vector of one entry: w_r = ... + z0, from z0 = -w_r to z0 = 0
(the variable dimension method of van der Heyden 1980). Ties are excluded by a perturbation of q as in solvers.lemke.

Every path succeeds if M is a P-matrix, in particular if it is positive definite, and for frictionless contact (Baraff 1994).
With friction a path may end on a ray, and the method stalls: the existence theorem of the friction LCP requires covering
vectors without zeros.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import deadline
from frictionbench.solvers.interface import solver
from frictionbench.solvers.pivots.inverse_basis import Matrix
from frictionbench.solvers.pivots.lemke_path import (
    ACCURACY,
    COMPLEMENTARY,
    HARRIS,
    INACCURATE,
    PERTURBATION,
    RAY,
    STUCK,
    USUAL,
    add_coordinates,
    basic_values,
    draw,
    follow_lemke_path,
    lemke_state,
)
from frictionbench.solvers.pivots.principal_pivoting import PrincipalPivoting
from frictionbench.solvers.pivots.scaled_lcp import ScaledLCP, finish
from frictionbench.solvers.pivots.vectors import fill, put


@kernel
def dantzig(
    order: Index64, M: Matrix, q: Array, unit: Array, tol: float, limit: int, until: float
) -> tuple[int, Array, int, int]:
    """(how it ended, y, pivots, inversions) for the scaled problem; order: the indices in the order of processing."""
    n, state = len(q), lemke_state(M, len(q))
    basis, x, y, work, blocking = state.basis, state.x, state.y, state.work, state.blocking
    drawn = np.empty(n)
    x[:n] = -1.0
    size, error = PERTURBATION, np.inf
    draw(1, drawn)
    while size > 1e-14 and error > tol:
        # Later rounds, with a smaller perturbation, process the pairs with a negative entry again.
        for i in range(n):
            blocking[i] = x[i] >= 0.0
        put(state.q, q)
        add_coordinates(basis, drawn, size, state.q)
        basic_values(basis, state.q, x, ACCURACY)
        for r in order:
            blocking[r] = True
            if x[r] >= 0.0:
                continue
            fill(y, 0.0)
            y[r] = 1.0
            fill(basis.d, 0.0)
            add_coordinates(basis, y, 1.0, basis.d)
            code = follow_lemke_path(state, HARRIS * size, USUAL, limit, until)
            fill(y, 0.0)
            if code != COMPLEMENTARY:
                return STUCK if code == RAY else code, y, work[0], work[1]
        error = finish(state, q, unit)
        size *= 1e-2
    return COMPLEMENTARY if error <= tol else INACCURATE, y, work[0], work[1]


@kernel
def contact_order(n: int, nc: int) -> Index64:
    """The indices of z (n,), contact by contact: c, lambda, beta; for a bare LCP, nc = 0, in their own order."""
    order, at = np.arange(n), 0
    for i in range(nc):
        order[at], order[at + 1] = i, n - nc + i
        for m in range((n - 2 * nc) // nc):
            order[at + 2 + m] = nc + i * ((n - 2 * nc) // nc) + m
        at += n // nc
    return order


@solver("dantzig", family="pivoting", model="lcp", dimension=(2, 3))
class Dantzig(PrincipalPivoting):
    """Dantzig's principal pivoting, one contact after the other. (Baraff 1994)

    facets: of the polygon that approximates the cone's section in space. limit bounds the pivots, by default 10 000 + 100 n.
    """

    def pivot(self, lcp: ScaledLCP, tol: float, limit: int) -> tuple[int, Array, int, int]:
        return dantzig(contact_order(len(lcp.q), lcp.contacts[0]), lcp.M, lcp.q, lcp.unit, tol, limit, deadline())
