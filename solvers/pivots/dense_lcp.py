"""The dense LCP, scaled so that tolerances are dimensionless (solvers.pivots.scaling)."""

from typing import NamedTuple

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.pivots.scaling import Scaling, scaling


class DenseLCP(NamedTuple):
    """The scaled w = M y + q, M (n, n) and q (n,), and the LCP and the scaling that it comes from."""

    lcp: LCP
    scale: Scaling
    M: Array
    q: Array

    def answer(self, y: Array, status: Status, detail: str = "", clock: float | None = None, **work: int) -> Answer:
        """The answer of a scaled solution y (n,)."""
        z = self.scale.solution(y)
        return Answer(self.lcp.impulse(z), status, work, z=z, detail=detail, clock=clock)


def dense_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> DenseLCP:
    """The scaled dense LCP of a friction problem, in space with so many facets, or of a bare LCP."""
    lcp = problem if isinstance(problem, LCP) else problem.lcp(facets)
    scale = scaling(lcp)
    return DenseLCP(lcp, scale, scale.matrix(lcp.dense), scale.vector(lcp.q))
