"""The scaled LCP (solvers.pivots.scaled_lcp) with a dense matrix."""

from typing import NamedTuple

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.lcp import by_unknown, dense_matrix
from frictionbench.solvers.pivots.scaled_lcp import ScaledLCP, scaled_lcp


class DenseLCP(NamedTuple):
    """The scaled LCP w = M y + q, with M (n, n) and q (n,), and the ScaledLCP from which it was made."""

    scaled: ScaledLCP
    M: Array
    q: Array

    @property
    def share(self) -> float:
        """The factor of tol that bounds the errors of scaled rows, so that each contact's residual is within tol."""
        nc = self.scaled.contacts[0]
        if not nc or isinstance(self.scaled.problem, LCP):
            return 1.0
        more = 1 + by_unknown(self.scaled.problem.friction, len(self.q))  # tangential defects are multiplied by 1 + mu
        more[:nc] = 1.0
        return min(1.0, float((more / self.scaled.unit[1])[:-nc].min()))


def dense_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> DenseLCP:
    """The scaled dense LCP of a friction problem, in space with so many facets, or of a bare LCP."""
    scaled = scaled_lcp(problem, facets)
    return DenseLCP(scaled, dense_matrix(scaled.M.start, scaled.M.rows, scaled.M.row, len(scaled.q)), scaled.q)
