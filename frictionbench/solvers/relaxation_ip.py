"""Interior point method for the convex relaxation, with the same factorisation as for Coulomb's law.

Coulomb's law has 0 <= c ⟂ u_n >= 0; the relaxation (problems.forms.relaxation) has 0 <= c ⟂ u_n - mu lambda >= 0: a contact may
slide only while it opens. The additional term makes the problem monotone, and Mehrotra's method hardly ever fails (Wright
1997). In space, where the products of Lorentz' cone do not commute, it fails in about one of a hundred random problems, and
restarts. The matrix and the arithmetic are those of interior_point: the comparison shows what the simpler model saves.
"""

from itertools import chain

from frictionbench.problems.check import Array
from frictionbench.problems.residual import relaxation_residual
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.interior.phases import Phased, Prepared, first_point, run
from frictionbench.solvers.interior.point import start_point
from frictionbench.solvers.interior.predictor_corrector import predictor_corrector

STARTS = ((0.1, 10.0), (10.0, 1.0))  # after the first: (impulse, speed), with other ratios than in the first
START_SHARE = 250  # factorisations from each start: above the default limit, so that only larger limits are divided
PATIENCE = 60  # iterations without progress: a heavy body on a light one needs impulses a million times the first ones


@solver("relaxation_ip", family="interior point", model="relaxation", dimension=(2, 3))
class RelaxationInteriorPoint(Phased):
    """Mehrotra's predictor-corrector on the convex relaxation, one sparse factorisation in the velocities an iteration."""

    relaxed = True

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the factorisations, 200 by default."""
        _, system = prepared
        points = chain([first_point(system)], (start_point(system, *at) for at in STARTS))
        phases = ((predictor_corrector, point, START_SHARE) for point in points)
        return run(prepared, phases, tol, 200 if limit is None else limit, PATIENCE, relaxation_residual)
