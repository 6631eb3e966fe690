"""Scaling of an LCP, so that tolerances inside a method are pure numbers.

With a positive diagonal D and a number theta, z = theta D y turns LCP(M, q) into

    w^ = (D M D) y + (D q) / theta,      D_i = 1/sqrt(M_ii),      theta = max |D q|,

which has a unit diagonal and a unit right side, the same solutions, the same signs. A row without a diagonal (the sliding
speed of a friction contact) is scaled by the column through which it acts: D_i = 1 / max_j D_j |M_ji|.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from problems import LCP
from problems.check import Array


@dataclass(frozen=True, eq=False)
class Scaling:
    """D (n,) and theta; z = theta * D * y."""

    D: Array
    theta: float

    def matrix(self, M: Array) -> Array:
        """D M D for a dense M, in C order."""
        return np.ascontiguousarray(M * self.D[:, None] * self.D)

    def vector(self, q: Array) -> Array:
        """D q / theta."""
        return self.D * q / self.theta

    def solution(self, y: Array) -> Array:
        """z of the LCP as given."""
        return self.theta * self.D * y

    def guess(self, z: Array) -> Array:
        """y of a z of the LCP as given."""
        return z / (self.theta * self.D)


def scaling(lcp: LCP) -> Scaling:
    """The scaling of an LCP; rows and columns of zeros keep their size."""
    diagonal = np.abs(lcp.M.diagonal())
    size = np.sqrt(diagonal)
    D = np.where(diagonal > 0, 1 / np.where(diagonal > 0, size, 1.0), 0.0)
    bare = np.flatnonzero(diagonal == 0)
    if len(bare):
        M = abs(sparse.csr_array(lcp.M))
        for action in (M.T, M):
            reach = _row_max(sparse.csr_array(action)[bare] * np.where(D > 0, D, 0.0))
            D[bare] = np.where((D[bare] == 0) & (reach > 0), 1 / np.where(reach > 0, reach, 1.0), D[bare])
        D[D == 0] = 1.0
    theta = float(np.abs(D * lcp.q).max(initial=0.0)) or 1.0
    return Scaling(D, theta)


def _row_max(rows: sparse.csr_array) -> Array:
    return np.asarray(rows.max(axis=1).toarray()).ravel() if rows.shape[0] else np.zeros(0)
