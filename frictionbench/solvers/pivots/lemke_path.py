"""Following the path of Lemke's method from a complementary basis, in floating point.

The problem is scaled, so that the tolerances here are dimensionless. Entering columns come from the inverse of the basis's
active part with iterative refinement against M; where that is no longer accurate the inverse is recomputed. Near ties
go to the largest pivot (Harris 1973); the caller excludes exact ties by perturbing q.
"""

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, lean, lean_kernel
from frictionbench.problems.rows import Index64
from frictionbench.solvers.clock import late
from frictionbench.solvers.pivots.inverse_basis import InverseBasis, Matrix, exchange_pair, refactor, transform
from frictionbench.solvers.pivots.vectors import put

Flags = NDArray[np.bool_]

COMPLEMENTARY, RAY, LIMIT, INACCURATE, STUCK = range(5)  # how a path ends
PERTURBATION = 1e-7  # of q, whose largest entry is 1: the root of rounding, half the digits for it, half for the solution
HARRIS = 1e-4  # how far below zero near ties may reach, relative to the perturbation, which must still resolve ties
PIVOT = 1e-10  # the smallest pivot, relative to its column: smaller entries may be the error of the column
ACCURACY = 1e-12  # relative defect above which a transformed column is refined: some thousand units of rounding
FINEST = 4e-16  # relative defect that refinement can reach: twice the unit of rounding
# The smallest pivot and the accuracy of columns, usually and in restarts.
USUAL, FULL = (PIVOT, ACCURACY), (1e-13, FINEST)
LOSS = 1e-9  # relative defect after refinement above which the inverse is computed anew


@inlined
def ratio_test(x: Array, a: Array, blocking: Flags, least: float, slack: float) -> int:
    """The pair whose basic variable blocks x - t a >= 0 first, z0 if possible; the largest pivot among near ties; -1 on a ray.

    blocking (n+1,): which variables block. least: the smallest entry of a that counts. slack: how far below zero a variable
    may go for the sake of a larger pivot.
    """
    n = len(x) - 1
    bound = np.inf
    for i in range(n + 1):
        if a[i] > least and blocking[i]:
            bound = min(bound, (max(x[i], 0.0) + slack) / a[i])
    if a[n] > least and x[n] <= bound * a[n]:
        return n
    best, pivot = -1, least
    for i in range(n):
        if a[i] > pivot and blocking[i] and x[i] <= bound * a[i]:
            best, pivot = i, a[i]
    return best


@lean
def basic_values(M: Matrix, d: Array, basis: InverseBasis, q: Array, x: Array, out: Array, accuracy: float) -> float:
    """x (n+1,) = the basic variables' values for the right side q; returns the relative defect."""
    rhs = basis.work[1, : len(q)]
    for i in range(len(q)):
        rhs[i] = -q[i]
    return transform(M, d, basis, rhs, x, out, accuracy)[0]


@inlined
def enter(M: Matrix, p: int, z_enters: bool, rhs: Array) -> None:
    """rhs = M_p where z_p enters, -e_p where w_p does: the right side whose transform is the entering column."""
    for i in range(len(rhs)):
        rhs[i] = 0.0
    if z_enters:
        for e in range(M.start[p], M.start[p + 1]):
            rhs[M.rows[e]] = M.column[e]
    else:
        rhs[p] = -1.0


@lean_kernel
def follow_lemke_path(
    M: Matrix,
    q: Array,
    d: Array,
    basis: InverseBasis,
    x: Array,
    a: Array,
    blocking: Flags,
    slack: float,
    precision: tuple[float, float],
    limit: int,
    until: float,
    work: Index64,
    space: Array,
) -> int:
    """Follow Lemke's path from a complementary basis in which z0 lets every basic variable rise, and return how it ended.

    x (n+1,): the values of the basic variables, updated. a (n+1,): at the end of a ray its direction (z, z0).
    blocking (n+1,): the variables to keep nonnegative. slack: how far near ties may reach. precision: USUAL or FULL, which
    also computes x anew with every pivot. until: the deadline.
    work: counts of pivots and inversions, updated. space (2, n): workspace.
    """
    n = len(q)
    pivot, accuracy = precision
    rhs, out = space[0], space[1]
    put(rhs, d)
    p, z_enters, fresh = n, True, True  # z0 enters first
    while True:
        defect, size = transform(M, d, basis, rhs, a, out, accuracy)
        if p < n:
            s = ratio_test(x, a, blocking, pivot * size, slack)
            t = max(x[s], 0.0) / a[s] if s >= 0 else 0.0
        else:  # to the level at which the last basic variable becomes nonnegative
            s, t = -1, 0.0
            for i in range(n):
                if blocking[i] and x[i] < t * a[i]:
                    s, t = i, x[i] / a[i]
            if s < 0:
                return COMPLEMENTARY
        if not fresh and (s < 0 or defect > LOSS):
            work[1] += 1
            if not refactor(M, d, basis):
                return INACCURATE
            basic_values(M, d, basis, q, x, out, accuracy)
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
        if work[0] >= limit or late(until):
            return LIMIT

        w_leaves = basis.row[s] < 0
        exchange_pair(M, d, basis, a, p, z_enters, s)
        for i in range(n + 1):
            x[i] -= t * a[i]
        x[s], x[p] = 0.0, t
        work[0] += 1
        if s == n:
            return COMPLEMENTARY
        if work[0] % 64 == 0 or accuracy == FINEST:
            basic_values(M, d, basis, q, x, out, accuracy)
        p, z_enters, fresh = s, w_leaves, False
        enter(M, p, z_enters, rhs)


@lean
def add_matrix_product(M: Matrix, v: Array, u: Array) -> None:
    """u += M v."""
    for j in range(len(u)):
        if v[j] != 0.0:
            for e in range(M.start[j], M.start[j + 1]):
                u[M.rows[e]] += M.column[e] * v[j]


@lean
def add_coordinates(M: Matrix, basis: InverseBasis, y: Array, size: float, v: Array, z: Array) -> None:
    """v += the vector whose coordinates in a complementary basis are size * y, that is y_w - M y_z; z (n,) is workspace."""
    for i in range(len(v)):
        if basis.row[i] < 0:
            z[i] = 0.0
            v[i] += size * y[i]
        else:
            z[i] = -size * y[i]
    if basis.size[0]:
        add_matrix_product(M, z, v)


@lean
def draw(seed: int, drawn: Array) -> None:
    """Numbers from [1, 2), the same ones for the same seed, by Knuth's MMIX congruence."""
    state = np.uint64(seed)
    for i in range(-4, len(drawn)):
        state = state * np.uint64(6364136223846793005) + np.uint64(1442695040888963407)
        if i >= 0:
            drawn[i] = 1.0 + np.float64(state >> np.uint64(11)) / 9007199254740992.0
