"""Scaling of an LCP, so that tolerances inside a method are dimensionless.

With a positive diagonal D and a number theta, z = theta D y turns LCP(M, q) into

    w^ = (D M D) y + (D q) / theta,      D_i = 1/sqrt(M_ii),      theta = max |D q|,

which has a unit diagonal and a unit right side, the same solutions, the same signs. A row without a diagonal (the sliding
speed of a friction contact) is scaled by the column through which it acts: D_i = 1 / max_j D_j |M_ji|.
"""

from dataclasses import dataclass

import numpy as np

from frictionbench.problems import LCP
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean
from frictionbench.problems.forms.lcp import dense_matrix


@dataclass(frozen=True, eq=False)
class Scaling:
    """D (n,) and theta; z = theta * D * y."""

    D: Array
    theta: float

    def matrix(self, lcp: LCP) -> Array:
        """D M D as a dense array (n, n) in C order."""
        start, column, value = lcp.rows
        scaled = value * np.repeat(self.D, np.diff(start)) * self.D[column]
        dense: Array = dense_matrix(start, column, scaled, lcp.size)
        return dense

    def vector(self, q: Array) -> Array:
        """D q / theta."""
        return self.D * q / self.theta

    def solution(self, y: Array) -> Array:
        """z of the unscaled LCP."""
        return self.theta * self.D * y


def scaling(lcp: LCP) -> Scaling:
    """The scaling of an LCP; rows and columns of zeros are not scaled."""
    return Scaling(*diagonal_scaling(*lcp.rows, lcp.q))


@kernel
def diagonal_scaling(start, column, value, q):  # type: ignore[no-untyped-def]
    """D and theta."""
    n = len(q)
    D, reach = np.zeros(n), np.zeros(n)
    for i in range(n):
        for k in range(start[i], start[i + 1]):
            if column[k] == i and value[k] != 0:
                D[i] = 1 / np.sqrt(abs(value[k]))
    # Rows without a diagonal are scaled by their columns, then the remaining ones by their rows.
    for by_column in (True, False):
        for i in range(n):
            reach[i] = 0.0
        for i in range(n):
            for k in range(start[i], start[i + 1]):
                bare, other = (column[k], i) if by_column else (i, column[k])
                if D[bare] == 0:
                    reach[bare] = max(reach[bare], D[other] * abs(value[k]))
        scale_reached(D, reach)
    return D, complete(D, q)


@lean
def scale_reached(D, reach):  # type: ignore[no-untyped-def]
    """D is 1/reach where something is reached."""
    for i in range(len(D)):
        if reach[i] > 0:
            D[i] = 1 / reach[i]


@lean
def complete(D, q):  # type: ignore[no-untyped-def]
    """D is 1 where nothing has scaled it; theta."""
    theta = 0.0
    for i in range(len(D)):
        if D[i] == 0:
            D[i] = 1.0
        theta = max(theta, abs(D[i] * q[i]))
    return theta if theta > 0 else 1.0
