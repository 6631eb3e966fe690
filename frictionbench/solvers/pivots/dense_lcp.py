"""The dense LCP, scaled so that tolerances are dimensionless (solvers.pivots.scaling)."""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.scaling import Scaling, scaling


class DenseLCP(NamedTuple):
    """The scaled w = M y + q, M (n, n) and q (n,), the LCP and the scaling that it comes from, and the contacts' units."""

    lcp: LCP
    scale: Scaling
    M: Array
    q: Array
    units: Array

    @property
    def share(self) -> float:
        """By how much smaller an error of a scaled row must be than tol, so that each contact's is within tol of its unit."""
        nc = len(self.units)
        if not nc:
            return 1.0
        D = np.minimum(self.scale.D[:nc], self.scale.D[nc:-nc].reshape(nc, -1).min(axis=1))
        return min(1.0, float((D * self.units).min()) / self.scale.theta)

    def answer(self, y: Array, status: Status, detail: str = "", clock: float | None = None, **work: int) -> Answer:
        """The answer of a scaled solution y (n,)."""
        z = self.scale.solution(y)
        return Answer(self.lcp.impulse(z), status, work, z=z, detail=detail, clock=clock)


def dense_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> DenseLCP:
    """The scaled dense LCP of a friction problem, in space with so many facets, or of a bare LCP."""
    lcp = problem if isinstance(problem, LCP) else problem.lcp(facets)
    scale = scaling(lcp)
    units = np.zeros(0) if isinstance(problem, LCP) else problem.units
    return DenseLCP(lcp, scale, scale.matrix(lcp), scale.vector(lcp.q), units)
