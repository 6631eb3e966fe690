"""Sliding contacts at the force and acceleration level, at which Painlevé's paradox occurs.

While every contact slides with the velocity's sign s, friction is known from the normal force f >= 0, and the normal
accelerations are linear in it:

    0 <= f  ⟂  A f + K >= 0,      A = N M^-1 (N - s mu T)',      K = N M^-1 k + dN/dt v.

A is not symmetric. One contact with p = A: where p > 0 the problem has one solution for every K, where p < 0 it has none for
K < 0 and two for K > 0 (Painlevé 1895; Lötstedt 1981; Baraff 1993; Pfeiffer and Glocker 1996). The same contact at the
level of impulses always has a solution, three of them where p < 0 < K.
"""

from enum import Enum

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from frictionbench.problems import LCP


class Regime(Enum):
    """What a single sliding contact does next, by the signs of p and K."""

    SLIDE = "slide"
    OPEN = "open"
    IMPACT = "stick (impulse)"
    THREE = "three"


def force_level_lcp(mass, normal, tangent, friction, force, sliding: ArrayLike, normal_rate: ArrayLike = 0.0) -> LCP:
    """The LCP of the normal forces f (nc,), N, with w the normal accelerations, m/s^2.

    mass: (nv, nv). normal, tangent: (nc, nv). friction: (nc,). force: k (nv,), with gyroscopic terms and known friction.
    sliding: (nc,), the sign of each contact's tangential velocity; 0 for a contact whose friction is already in the force.
    normal_rate: dN/dt v (nc,), m/s^2.
    """
    M, N, T = (sparse.csr_array(matrix).toarray() for matrix in (mass, normal, tangent))
    direction = N - (np.sign(sliding) * friction)[:, None] * T
    return LCP(N @ np.linalg.solve(M, direction.T), N @ np.linalg.solve(M, force) + normal_rate)


def regime(p: float, K: float) -> Regime:
    """What one contact does with A = p and K; ties count as slide where p > 0 and otherwise as open."""
    if p > 0:
        return Regime.OPEN if K > 0 else Regime.SLIDE
    if K < 0:
        return Regime.IMPACT
    return Regime.THREE if p < 0 < K else Regime.OPEN
