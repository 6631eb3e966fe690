"""A friction problem in velocities of unit mass, for libraries that take contact rows J and no Delassus matrix.

With M = L L', w = L'v / theta and r = theta E r^ (solvers.outside.scaled_delassus),

    J^ = E J L^-T,      w* = L'v* / theta,      b^ = E b / theta,      W^ = J^ J^',      q^ = J^ w* + b^.

L has entries only between the first of a row of M and its diagonal, so that the factorisation of a block diagonal mass matrix
is one of its blocks.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.outside.scaled_delassus import SPACE, ScaledDelassus, scaled_delassus


class Whitened(NamedTuple):
    """The rows J^ (3 nc, nv), three a contact, normal first, w* (nv,) and b^ (3 nc,)."""

    given: ScaledDelassus
    J: Array
    v: Array
    b: Array


def whitened(problem: FrictionProblem) -> Whitened:
    """The whitened rows of a problem without joints; the third row of a planar contact is zero."""
    given = scaled_delassus(problem, SPACE, matrix=False)
    parts = _whiten(*problem.contact_rows, *problem.mass_rows, problem.free_velocity, problem.offset, given.E, given.theta)
    return Whitened(given, *parts)


@kernel
def _whiten(start, column, J, m_start, m_column, m_value, free, offset, E, theta):  # type: ignore[no-untyped-def]
    """J^, w* and b^."""
    nc, nv, d = len(E), len(free), J.shape[1]
    L, begin = _factor(m_start, m_column, m_value)
    rows, v, b = np.zeros((3 * nc, nv)), np.zeros(nv), np.zeros(3 * nc)
    for j in range(nv):
        for k in range(begin[j], j + 1):
            v[k] += L[j, k] * free[j] / theta
    for i in range(nc):
        for a in range(d):
            row = rows[3 * i + a]
            for k in range(start[i], start[i + 1]):
                row[column[k]] = E[i] * J[k, a]
            b[3 * i + a] = E[i] * offset[i, a] / theta
            for j in range(nv):  # L y = (E J)'
                for k in range(begin[j], j):
                    row[j] -= L[j, k] * row[k]
                row[j] /= L[j, j]
    return rows, v, b


@part
def _factor(start, column, value):  # type: ignore[no-untyped-def]
    """L (nv, nv) and the column of the first entry of each of its rows."""
    n = len(start) - 1
    L, begin = np.zeros((n, n)), np.empty(n, np.int64)
    for i in range(n):
        begin[i] = min(column[start[i]], i)
        for k in range(start[i], start[i + 1]):
            if column[k] <= i:
                L[i, column[k]] = value[k]
        for j in range(begin[i], i + 1):
            for k in range(max(begin[i], begin[j]), j):
                L[i, j] -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(L[i, i]) if i == j else L[i, j] / L[j, j]
    return L, begin
