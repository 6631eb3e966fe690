"""Following the path of Lemke's method from a complementary basis, in floating point.

The problem is scaled, so that the tolerances here are dimensionless. Entering columns are computed with the inverse of the
active part of the basis and iterative refinement against M; the inverse is recomputed when it becomes inaccurate. Near ties are
resolved in favour of the largest pivot (Harris 1973); the caller excludes exact ties by perturbing q.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, lean, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import late
from frictionbench.solvers.pivots.inverse_basis import InverseBasis, Matrix, exchange_pair, refactor, slack_basis, transform
from frictionbench.solvers.pivots.vectors import put

Flags = NDArray[np.bool_]

COMPLEMENTARY, RAY, LIMIT, INACCURATE, STUCK = range(5)  # how a path ends
PERTURBATION = 1e-7  # of q, whose largest entry is 1: half of the digits for the perturbation, half for the solution
HARRIS = 1e-4  # how far below zero a variable may go at a near tie, relative to the perturbation, which must still resolve ties
LEAST_PIVOT = 1e-10  # the smallest pivot, relative to its column: smaller entries may be errors of the column
ACCURACY = 1e-12  # relative defect above which a transformed column is refined: some thousand units of rounding
FINEST = 4e-16  # relative defect that refinement can reach: twice the unit of rounding
# The smallest pivot and the accuracy of columns: usually, and in restarts.
USUAL, FULL = (LEAST_PIVOT, ACCURACY), (1e-13, FINEST)
CERTIFICATE = ACCURACY  # largest defect of a ray, relative to its size: as accurate as entering columns
LOSS = 1e-9  # relative defect after refinement above which the inverse is recomputed


class LemkeState(NamedTuple):
    """A point of the path w = M z + q + d z0, and the workspace of the methods that follow it.

    basis: with M and d. q (n,): the perturbed right-hand side. x (n+1,): the values of the basic variables. a (n+1,): the
    entering column, on a ray the ray's direction (z, z0). blocking (n+1,): the variables that must stay nonnegative.
    y (n,): a solution. v (n,): workspace. work (2,): the pivots and inversions so far.
    """

    basis: InverseBasis
    q: Array
    x: Array
    a: Array
    blocking: Flags
    y: Array
    v: Array
    work: Index64


@part
def lemke_state(M: Matrix, n: int) -> LemkeState:
    """The state at the slack basis of M, with d = 0, for up to n unknowns."""
    vectors, blocking = np.zeros((5, n + 1)), np.ones(n + 1, np.bool_)
    x, a, q, y, v = vectors[0], vectors[1], vectors[2, :n], vectors[3, :n], vectors[4, :n]
    return LemkeState(slack_basis(M, n), q, x, a, blocking, y, v, np.zeros(2, np.int64))


@inlined
def first_unknowns(state: LemkeState, n: int) -> LemkeState:
    """The state of a smaller problem of n unknowns in the same memory; its M is stored in the arrays of the larger one."""
    b = state.basis
    basis = InverseBasis(b.M, b.d[:n], b.inverse, b.z, b.w, b.row, b.column, b.size, b.work)
    x, a, blocking = state.x[: n + 1], state.a[: n + 1], state.blocking[: n + 1]
    return LemkeState(basis, state.q[:n], x, a, blocking, state.y[:n], state.v[:n], state.work)


@lean
def ratio_test(x: Array, a: Array, blocking: Flags, z0: int, least: float, slack: float) -> int:
    """The basic variable that first blocks x - t a >= 0: z0 if possible, else the largest pivot of near ties; -1 on a ray.

    least: the smallest entry of a that counts. slack: how far below zero a variable may go for the sake of a larger pivot.
    """
    bound = np.inf
    for i in range(len(a)):
        if a[i] > least and blocking[i]:
            bound = min(bound, (max(x[i], 0.0) + slack) / a[i])
    if a[z0] > least and x[z0] <= bound * a[z0]:
        return z0
    best, pivot = -1, least
    for i in range(len(a)):
        if a[i] > pivot and blocking[i] and x[i] <= bound * a[i]:
            best, pivot = i, a[i]
    return best


@lean
def basic_values(basis: InverseBasis, q: Array, x: Array, accuracy: float) -> float:
    """x (n+1,) = the basic variables' values for the right-hand side q; returns the relative defect."""
    rhs = basis.work[1]
    for i in range(len(q)):
        rhs[i] = -q[i]
    return transform(basis, rhs, x, accuracy)[0]


@lean
def entering_column(state: LemkeState, p: int, z_enters: bool, accuracy: float) -> tuple[float, float]:
    """a = the column of z_p (z0 if p = n) or w_p as it enters; returns the relative defect and the size, as transform does."""
    basis, rhs = state.basis, state.basis.work[3]
    M, n = basis.M, len(basis.d)
    if p == n:
        put(rhs[:n], basis.d)
        return transform(basis, rhs, state.a, accuracy)
    for i in range(n):
        rhs[i] = 0.0
    if z_enters:
        for e in range(M.start[p], M.start[p + 1]):
            rhs[M.rows[e]] = M.column[e]
    else:
        rhs[p] = -1.0
    return transform(basis, rhs, state.a, accuracy)


@lean
def exchange(state: LemkeState, p: int, z_enters: bool, s: int, t: float) -> None:
    """Exchange the basic member of pair s for z_p or w_p, which increases to t."""
    exchange_pair(state.basis, state.a, p, z_enters, s)
    for i in range(len(state.x)):
        state.x[i] -= t * state.a[i]
    state.x[s] = 0.0
    state.x[p] = t
    state.work[0] += 1


@lean
def follow_lemke_path(state: LemkeState, slack: float, precision: tuple[float, float], limit: int, until: float) -> int:
    """Follow Lemke's path from a complementary basis whose basic variables all increase with z0, and return how it ended.

    slack: how far below zero near ties may reach. precision: USUAL or FULL, which also recomputes x after every pivot.
    limit: of the pivots in state.work. until: the deadline.
    """
    basis, x, a, n = state.basis, state.x, state.a, len(state.q)
    pivot, accuracy = precision
    p, fresh = n, True  # z0 enters first
    z_enters = p == n
    while True:
        defect, size = entering_column(state, p, z_enters, accuracy)
        if p < n:
            s = ratio_test(x, a, state.blocking, n, pivot * size, slack)
            t = max(x[s], 0.0) / a[s] if s >= 0 else 0.0
        else:  # z0 rises until the last basic variable becomes nonnegative
            s, t = -1, 0.0
            for i in range(n):
                if state.blocking[i] and x[i] < t * a[i]:
                    s, t = i, x[i] / a[i]
            if s < 0:
                return COMPLEMENTARY
        if not fresh and (s < 0 or defect > LOSS):
            if not renew(state, accuracy):
                return INACCURATE
            fresh = True
            continue
        if defect > LOSS:
            return INACCURATE
        if s < 0:
            for i in range(n + 1):
                a[i] = -a[i] if basis.row[i] >= 0 else 0.0
            if z_enters:
                a[p] = 1.0
            return RAY
        if state.work[0] >= limit or late(until):
            return LIMIT

        w_leaves = basis.row[s] < 0
        exchange(state, p, z_enters, s, t)
        if s == n:
            return COMPLEMENTARY
        if state.work[0] % 64 == 0 or accuracy == FINEST:
            basic_values(basis, state.q, x, accuracy)
        p, z_enters, fresh = s, w_leaves, False


@part
def renew(state: LemkeState, accuracy: float) -> bool:
    """Recompute the inverse and x; False if the basis is singular to working accuracy."""
    state.work[1] += 1
    if not refactor(state.basis):
        return False
    basic_values(state.basis, state.q, state.x, accuracy)
    return True


@lean
def add_matrix_product(M: Matrix, v: Array, u: Array) -> None:
    """u += M v."""
    for j in range(len(u)):
        if v[j] != 0.0:
            for e in range(M.start[j], M.start[j + 1]):
                u[M.rows[e]] += M.column[e] * v[j]


@lean
def is_ray(M: Matrix, d: Array, v: Array, v0: float, s: Array) -> bool:
    """Whether v >= 0, v != 0, v0 >= 0, s = M v + d v0 >= 0 and v's = 0; s is overwritten."""
    size = 0.0
    for i in range(len(v)):
        s[i] = d[i] * v0
        size = max(size, abs(v[i]))
    add_matrix_product(M, v, s)
    slack = CERTIFICATE * size
    within = size > CERTIFICATE * abs(v0) and v0 >= -slack
    for i in range(len(v)):
        within = within and v[i] >= -slack and s[i] >= -slack and min(v[i], s[i]) <= slack
    return within


@lean
def add_coordinates(basis: InverseBasis, y: Array, size: float, v: Array) -> None:
    """v += the vector whose coordinates in a complementary basis are size * y, that is y_w - M y_z."""
    z = basis.work[0]
    for i in range(len(v)):
        if basis.row[i] < 0:
            z[i] = 0.0
            v[i] += size * y[i]
        else:
            z[i] = -size * y[i]
    if basis.size[0]:
        add_matrix_product(basis.M, z, v)


@lean
def draw(seed: int, drawn: Array) -> None:
    """Pseudorandom numbers from [1, 2), determined by the seed, by Knuth's MMIX linear congruential generator."""
    state = np.uint64(seed)
    for i in range(-4, len(drawn)):
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        if i >= 0:
            drawn[i] = 1.0 + np.float64(state >> np.uint64(11)) / 9007199254740992.0
