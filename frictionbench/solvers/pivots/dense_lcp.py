"""The scaled LCP (solvers.pivots.scaled_lcp) with a dense matrix."""

from typing import Any, NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.lcp import by_unknown, dense_matrix
from frictionbench.solvers.interface import Status
from frictionbench.solvers.pivots.scaled_lcp import scaled_lcp


class DenseLCP(NamedTuple):
    """The scaled LCP w = M y + q, with M (n, n) and q (n,), and the ScaledLCP it was made from, or another form that has q,
    unit and answer; another q is perturbed."""

    scaled: Any
    M: Array
    q: Array

    @property
    def share(self) -> float:
        """The factor of tol that bounds the errors of scaled rows, so that each contact's residual is within tol."""
        problem = self.scaled.problem
        if isinstance(problem, LCP) or not problem.contacts:
            return 1.0
        more = 1 + by_unknown(problem.friction, len(self.q))  # tangential defects are multiplied by 1 + mu
        more[: problem.contacts] = 1.0
        return min(1.0, float((more / self.scaled.unit[1])[: -problem.contacts].min()))

    def status(self, y: Array, tol: float) -> Status:
        """The status of a y that a library calls a solution: of a perturbed q it is a claim where it holds of the given q."""
        if self.q is self.scaled.q:
            return Status.SOLVED
        force, speed = self.scaled.unit
        error = np.abs(np.minimum(force * y, speed * (self.M @ y + self.scaled.q))).max()
        return Status.SOLVED if error <= tol else Status.STALLED


def dense_lcp(problem: FrictionProblem | LCP, facets: int = 8) -> DenseLCP:
    """The scaled dense LCP of a friction problem, in space with so many facets, or of a bare LCP."""
    scaled = scaled_lcp(problem, facets)
    return DenseLCP(scaled, dense_matrix(scaled.M.start, scaled.M.rows, scaled.M.row, len(scaled.q)), scaled.q)
