"""Where theory changes its mind about a problem, and whether it knows a solution to exist.

    p          every contact alone has p = a - mu |b| >= 0, with a = W_nn and b = W_nt of its own block: sliding on it, a normal
               force opposes the approach (Painlevé 1895), and its own LCP has a P0 matrix
    P0         the whole friction LCP has a P0 matrix: no principal minor is negative
    pointed    the friction cone is pointed: no contact impulses cancel, so impulses are bounded by the data
    gaps       no bias is negative: nothing overlaps

A solution exists where no bias is negative, for an LCP's ray needs v'q < 0 with v'Qv = 0, which forces v'q = v'b (Anitescu and
Potra 1997); and where the cone is pointed, for there v'Qv = 0 leaves nothing but v = (0, 0, lambda).
"""

from collections.abc import Callable
from itertools import combinations

import numpy as np

from frictionbench.problems.analysis.labels import p0_margin, pointedness
from frictionbench.problems.friction import FrictionProblem

LARGEST = 12  # unknowns of an LCP whose principal minors are all looked at
POINTED = 1e-9


def is_p0(problem: FrictionProblem) -> bool:
    """Whether no principal minor of the friction LCP's matrix is negative; rows and columns scaled to its diagonal's roots.

    Beyond LARGEST unknowns only each contact alone is looked at.
    """
    lcp = problem.lcp()
    if lcp.size > LARGEST:
        return p0_margin(problem) >= 0
    Q = lcp.dense
    root = np.sqrt(np.where(np.diag(Q) > 0, np.diag(Q), 1.0))
    Q = Q / root[:, None] / root
    for size in range(1, len(Q) + 1):
        picks = np.array(list(combinations(range(len(Q)), size)))
        if (np.linalg.det(Q[picks[:, :, None], picks[:, None, :]]) < -1e-10).any():
            return False
    return True


def is_pointed(problem: FrictionProblem) -> bool:
    """Whether no contact impulses but zero cancel."""
    return pointedness(problem) <= POINTED


def gaps_only(problem: FrictionProblem) -> bool:
    """Whether nothing overlaps: no bias is negative."""
    return bool(problem.bias.min(initial=0.0) >= 0)


THRESHOLDS: dict[str, Callable[[FrictionProblem], bool]] = {
    "p": lambda problem: p0_margin(problem) >= 0,
    "P0": is_p0,
    "pointed": is_pointed,
    "gaps": gaps_only,
}


def existence(problem: FrictionProblem, pointed: bool) -> str:
    """Why the problem is known to have a solution: "gaps", "pointed", or "" where theory does not say."""
    if not problem.mechanical or problem.joint_bias.any():
        return "pointed" if pointed else ""
    return "gaps" if gaps_only(problem) else "pointed" if pointed else ""
