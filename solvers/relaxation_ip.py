"""Interior point for the convex relaxation, with the same factorisation as for Coulomb's law itself.

Where Coulomb's law has 0 <= c ⟂ u_n >= 0, the relaxation (problems.forms.relaxation) has 0 <= c ⟂ u_n - mu lambda >= 0: a
contact may slide only while it opens. One sign more makes the problem monotone, and Mehrotra's method hardly ever fails
(Wright 1997); in space, where products of Lorentz' cone do not commute, once in some hundred random problems, and starts anew.
Beside interior_point it tells what the model saves: the matrix and the arithmetic are the same.
"""

import numpy as np

from problems import FrictionProblem
from problems.check import Array
from problems.residual import relaxation_residual
from solvers.interface import Answer, solver
from solvers.interior.phases import run
from solvers.interior.point import start_point
from solvers.interior.predictor_corrector import predictor_corrector
from solvers.interior.system import System, in_velocities, prepare

STARTS = ((0.1, 10.0), (10.0, 1.0))  # after the first: impulses and speeds, relative to a contact's own
PATIENCE = 60  # a heavy body on a light one needs impulses a million times the first ones


@solver("relaxation_ip", family="interior point", model="relaxation", dimension=(2, 3), sparse=True)
class RelaxationInteriorPoint:
    """Mehrotra's predictor-corrector on the convex relaxation, one sparse factorisation in the velocities an iteration."""

    def form(self, problem: FrictionProblem) -> FrictionProblem:
        return in_velocities(problem)

    def setup(self, problem: FrictionProblem) -> tuple[FrictionProblem, System]:
        return problem, prepare(problem, relaxed=True)

    def solve(
        self, prepared: tuple[FrictionProblem, System], tol: float, limit: int | None, start: Array | None = None
    ) -> Answer:
        """limit bounds the factorisations, 200 by default."""
        problem, system = prepared
        starts = ((float(np.sqrt(problem.contacts)), 1.0), *STARTS)
        phases = ((predictor_corrector, start_point(system, impulse, speed)) for impulse, speed in starts)
        return run(problem, system, phases, tol, 200 if limit is None else limit, PATIENCE, relaxation_residual)
