"""Lemke's path on a dense tableau: for LCPs of some dozens of unknowns, where arithmetic costs less than bookkeeping.

The basic variables are x - T' t for values t of the nonbasic ones, at first those of the slack basis w = q + M z + d z0. T_p is
the rate at which they fall as the p-th nonbasic one rises. If it enters, with a = T_p, and the variable of row s leaves,

    T_js /= a_s,    T_ji -= a_i T_js  for all other columns j,      and    T_ps = 1 / a_s,    T_pi = -a_i / a_s

is the column of the variable that left. The rules for ties and pivots are those of solvers.pivots.lemke_path, and so is the
path. Nothing is refined on the way, and rounding errors accumulate: the caller must check the solution.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import lean, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.pivots.inverse_basis import InverseBasis
from frictionbench.solvers.pivots.lemke_path import COMPLEMENTARY, INACCURATE, LEAST_PIVOT, LIMIT, LemkeState, ratio_test
from frictionbench.solvers.pivots.vectors import fill

SMALL = 64  # unknowns up to which it is used: from some 80 on lemke_path is faster, as it exploits the zeros of M


class Tableau(NamedTuple):
    """T (n+1, n). at (3n+1,): at[i] is the basic variable of row i < n, at[n + k] the column of the nonbasic variable k. w_i is
    variable i, z_i is n + i, z0 is 2n. The arrays may be longer, for larger problems."""

    T: Array
    at: Index64


@part
def new_tableau(n: int) -> Tableau:
    """A tableau for n unknowns, at most SMALL."""
    n = min(n, SMALL)
    return Tableau(np.empty((n + 1, n)), np.empty(3 * n + 1, np.int64))


@lean
def follow_in_tableau(state: LemkeState, tableau: Tableau, slack: float, limit: int) -> int:
    """Follow Lemke's path from the slack basis, and return how it ended, as follow_lemke_path; a ray is INACCURATE.

    At a complementary basis y is the solution for the right-hand side v in place of q, cut off at 0. v is overwritten.
    """
    T, at, x, exact, q, d = tableau.T, tableau.at, state.x, state.v, state.q, state.basis.d
    n = len(q)
    a = state.basis.work[0, :n]
    _fill(tableau, state)
    entering, p, s, z0_row = 2 * n, n, _most_negative(q, d), -1
    while s >= 0:
        if state.work[0] >= limit:
            return LIMIT
        for i in range(n):
            a[i] = T[p, i]
        t = (x[s] if z0_row < 0 else max(x[s], 0.0)) / a[s]
        u, leaving = exact[s] / a[s], at[s]
        exchange(T, a, p, s)
        for i in range(n):
            x[i] -= t * a[i]
            exact[i] -= u * a[i]
        x[s], exact[s], at[s], at[n + leaving] = t, u, entering, p
        z0_row = s if z0_row < 0 else z0_row
        state.work[0] += 1
        if leaving == 2 * n:
            break
        entering = leaving - n if leaving >= n else leaving + n
        p = at[n + entering]
        size = 0.0
        for i in range(n):
            size = max(size, abs(T[p, i]))
        s = ratio_test(x, T[p, :n], state.blocking, z0_row, LEAST_PIVOT * size, slack)
    if s < 0 and z0_row >= 0:
        return INACCURATE
    fill(state.y, 0.0)
    for i in range(n):
        if at[i] >= n:
            state.y[at[i] - n] = max(exact[i], 0.0)
    return COMPLEMENTARY


@lean
def _fill(tableau: Tableau, state: LemkeState) -> None:
    """The tableau of the slack basis."""
    M, d, q, x, T, at = state.basis.M, state.basis.d, state.q, state.x, tableau.T, tableau.at
    n = len(q)
    for j in range(n):
        for i in range(n):
            T[j, i] = 0.0
        for e in range(M.start[j], M.start[j + 1]):
            T[j, M.rows[e]] = -M.column[e]
        T[n, j], x[j], at[j], at[2 * n + j] = -d[j], q[j], j, j
    at[3 * n] = n


@lean
def _most_negative(q: Array, d: Array) -> int:
    """The row of the largest -q/d, at which z0 enters; -1 if none is positive."""
    s, t = -1, 0.0
    for i in range(len(q)):
        if -q[i] > t * d[i]:
            s, t = i, -q[i] / d[i]
    return s


@lean
def exchange(T: Array, a: Array, p: int, s: int) -> None:
    """Pivot: column p enters in row s. a: a copy of column p."""
    n, pivot = len(a), a[s]
    for j in range(n + 1):
        entry = T[j, s]
        if entry != 0.0 and j != p:
            entry /= pivot
            for i in range(n):
                T[j, i] -= a[i] * entry
            T[j, s] = entry
    for i in range(n):
        T[p, i] = -a[i] / pivot
    T[p, s] = 1.0 / pivot


@lean
def store(tableau: Tableau, basis: InverseBasis) -> None:
    """Store the complementary basis at the end of a path, for whose kernel K the tableau holds -K^-1."""
    T, at, n, k = tableau.T, tableau.at, len(basis.d), 0
    for i in range(n):
        j = at[i] - n
        if j >= 0:
            basis.z[k] = basis.w[k] = j
            basis.row[j] = basis.column[j] = k
            k += 1
    for c in range(k):
        r, p = 0, at[n + basis.w[c]]
        for i in range(n):
            if at[i] >= n:
                basis.inverse[c, r] = -T[p, i]
                r += 1
    basis.size[0] = k
