"""Sliding contacts at the level of forces and accelerations, where Painlevé's paradoxes live.

While every contact slides with the velocity's sign s, friction is known from the normal force f >= 0, and the normal
accelerations are linear in it:

    0 <= f  ⟂  A f + K >= 0,      A = N M^-1 (N - s mu T)',      K = N M^-1 k + dN/dt v.

A is not symmetric. One contact with p = A: where p > 0 the problem has one solution for every K, where p < 0 it has none for
K < 0 and two for K > 0 (Painlevé 1895; Lötstedt 1981; Baraff 1993; Pfeiffer and Glocker 1996). The same contact at the
level of impulses always has a solution, three of them where p < 0 < K. How many a problem has,
problems.nature.census.lcp_census says.
"""

from enum import Enum
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.forms.mass import invert_mass


class Regime(Enum):
    """What a single sliding contact does next, by the signs of p and K; the values are names for tables."""

    SLIDE = "slide"
    OPEN = "open"
    IMPACT = "stick (impulse)"
    THREE = "three"


def force_level_lcp(
    mass: Any, normal: Any, tangent: Any, friction: Any, force: Any, sliding: Any, normal_rate: Any = None
) -> LCP:
    """The LCP of the normal forces f (nc,), N, with w the normal accelerations, m/s^2.

    mass: (nv, nv). normal, tangent: (nc, nv). friction: (nc,). force: k (nv,), with gyroscopic terms and known friction.
    sliding: (nc,), the sign of each contact's tangential velocity; 0 for a contact whose friction is already in the force.
    normal_rate: dN/dt v (nc,), m/s^2; by default 0. Errors: InputError naming the field.
    """
    mu = check.vector("friction", friction)
    k = check.vector("force", force)
    nc, nv = len(mu), len(k)
    sign = np.sign(check.vector("sliding", sliding, nc))
    rate = check.vector("normal_rate", np.zeros(nc) if normal_rate is None else normal_rate, nc)
    N, T = check.matrix("normal", normal, (nc, nv)), check.matrix("tangent", tangent, (nc, nv))
    inverse = invert_mass(check.matrix("mass", mass, (nv, nv)))
    A = N @ inverse @ (N - sparse.diags_array(sign * mu) @ T).T
    return LCP(A, N @ (inverse @ k) + rate)


def regime(p: float, K: float) -> Regime:
    """What one contact does with A = p and K; ties count as slide where p > 0 and otherwise as open."""
    if p > 0:
        return Regime.OPEN if K > 0 else Regime.SLIDE
    if K < 0:
        return Regime.IMPACT
    return Regime.THREE if p < 0 < K else Regime.OPEN
