"""Interior point methods for Coulomb friction itself, sparse in the velocities of the bodies.

In the plane the problem is the friction LCP; in space it has the circular cone as it is (solvers.contact_point). A step costs
one sparse factorisation of the size of the mass matrix (solvers.contact_newton, solvers.multifrontal), as for the convex
relaxation. Mehrotra's predictor-corrector (solvers.predictor_corrector) comes first: about ten
iterations, few more for a thousand boxes than for ten. The problem is not monotone, and in a few random instances of a hundred,
hardly ever in a stack or a pyramid, it is trapped; then the central path is followed around its folds (solvers.central_path),
from up to four starts.
"""

from collections.abc import Iterator

import numpy as np

from problems import FrictionProblem
from problems.check import Array
from problems.residual import residual
from solvers.central_path import trace
from solvers.contact_system import System, prepare
from solvers.interface import Answer, solver
from solvers.interior_phases import Phase, run
from solvers.predictor_corrector import predictor_corrector

STARTS = ((1.0, 1.0), (0.1, 10.0), (0.01, 10.0), (0.1, 1.0))  # impulses and speeds, relative to a contact's own
PATIENCE = 12  # iterations of the predictor-corrector without progress: more than ever helped


@solver("interior_point", family="interior point", model="coulomb", dimension=(2, 3), sparse=True)
class InteriorPoint:
    """Predictor-corrector on Coulomb's law, then its central path; one sparse factorisation an iteration.

    shortcut: try the predictor-corrector first; otherwise follow the path from the beginning.
    """

    shortcut: bool = True

    def prepare(self, problem: FrictionProblem) -> tuple[FrictionProblem, System]:
        return problem, prepare(problem)

    def solve(
        self, prepared: tuple[FrictionProblem, System], tol: float, limit: int | None, start: Array | None = None
    ) -> Answer:
        """limit bounds the factorisations, 2000 by default."""
        problem, system = prepared
        limit = 2000 if limit is None else limit
        return run(problem, system, self._phases(problem.contacts), tol, limit, PATIENCE, residual)

    def _phases(self, contacts: int) -> Iterator[Phase]:
        """The methods in turn, with the impulses and speeds they start from."""
        if self.shortcut:
            yield predictor_corrector, float(np.sqrt(contacts)), 1.0  # between nothing and all the others on top
        for impulse, speed in STARTS:
            yield trace, impulse, speed
