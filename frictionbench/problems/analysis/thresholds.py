"""Conditions on which the theory of a problem depends, and known sufficient conditions for the existence of a solution.

    p          every contact alone has p = a - mu |b| >= 0, with a = W_nn and b = W_nt of its own block: in sliding, a normal
               force opposes the approach (Painlevé 1895), and its own LCP has a P0 matrix
    P0         the whole friction LCP has a P0 matrix: no principal minor is negative
    pointed    the friction cone is pointed: no contact impulses cancel, so impulses are bounded by the data
    gaps       no bias is negative: nothing overlaps

The LCP, in space that of polygons, has a solution if no bias is negative, as a secondary ray needs v'q < 0 with v'Qv = 0, hence
v'q = v'b (Anitescu and Potra 1997). It also has one if the cone is pointed, because then v'Qv = 0 implies v = (0, 0, lambda).
"""

from collections.abc import Callable
from itertools import combinations

import numpy as np

from frictionbench.problems.analysis.labels import POINTED, p0_margin, pointedness
from frictionbench.problems.friction import FrictionProblem

MOST_UNKNOWNS = 12  # the unknowns of the largest LCP whose principal minors are all computed: 4095 determinants


def is_p0(problem: FrictionProblem) -> bool:
    """Whether no principal minor of the friction LCP's matrix is negative, after scaling to a unit diagonal.

    Beyond MOST_UNKNOWNS unknowns only the blocks of single contacts are examined.
    """
    lcp = problem.lcp()
    if lcp.size > MOST_UNKNOWNS:
        return p0_margin(problem) >= 0
    Q = lcp.dense
    root = np.sqrt(np.where(np.diag(Q) > 0, np.diag(Q), 1.0))
    Q = Q / root[:, None] / root
    for size in range(1, len(Q) + 1):
        picks = np.array(list(combinations(range(len(Q)), size)))
        if (np.linalg.det(Q[picks[:, :, None], picks[:, None, :]]) < -1e-10).any():
            return False
    return True


def gaps_only(problem: FrictionProblem) -> bool:
    """Whether nothing overlaps: no bias is negative."""
    return bool(problem.bias.min(initial=0.0) >= 0)


THRESHOLDS: dict[str, Callable[[FrictionProblem], bool]] = {
    "p": lambda problem: p0_margin(problem) >= 0,
    "P0": is_p0,
    "pointed": lambda problem: pointedness(problem) <= POINTED,
    "gaps": gaps_only,
}


def existence(problem: FrictionProblem, pointed: bool) -> str:
    """Why the problem is known to have a solution: "gaps", "pointed", or "" if neither condition holds."""
    open_contacts = problem.mechanical and not problem.joint_bias.any() and gaps_only(problem)
    return "gaps" if open_contacts else "pointed" if pointed else ""
