"""The common part of the principal pivoting methods: the scaled LCP, the default limit, the tolerance and the answer."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.forms.lcp import tangent_basis
from frictionbench.problems.residual import TOL_SHARE
from frictionbench.solvers.interface import Answer
from frictionbench.solvers.pivots.scaled_lcp import STATUSES, ScaledLCP, scaled_lcp


@dataclass(frozen=True)
class PrincipalPivoting(ABC):
    """A method that exchanges complementary pairs of the scaled LCP until its basic solution is nonnegative."""

    facets: int = 8
    dense_matrices = 2  # the inverse of the basis, old and new

    def __post_init__(self) -> None:
        tangent_basis(3, self.facets)  # refuses a wrong number

    @abstractmethod
    def pivot(self, lcp: ScaledLCP, tol: float, limit: int) -> tuple[int, Array, int, int]:
        """(how it ended, y (n,), pivots, inversions) for the scaled problem; how it ended: see pivots.lemke_path."""

    def form(self, problem: FrictionProblem | LCP) -> ScaledLCP:
        return scaled_lcp(problem, self.facets)

    def solve(self, prepared: ScaledLCP, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        ended, y, pivots, inversions = self.pivot(prepared, TOL_SHARE * tol, limit or 10_000 + 100 * len(prepared.q))
        return prepared.answer(y, STATUSES[ended], pivots=pivots, inversions=inversions)
