"""Interior point for the convex relaxation, with the same factorisation as for Coulomb's law itself.

Where Coulomb's law has 0 <= c ⟂ u_n >= 0, the relaxation (problems.forms.relaxation) has 0 <= c ⟂ u_n - mu lambda >= 0: a
contact may slide only while it opens. One sign more makes the problem monotone, and Mehrotra's method hardly ever fails
(Wright 1997); in space, where products of Lorentz' cone do not commute, it fails once in some hundred random problems, and
restarts. The comparison with interior_point shows what the simpler model saves: the matrix and the arithmetic are the same.
"""

from itertools import chain

from frictionbench.problems.check import Array
from frictionbench.problems.residual import relaxation_residual
from frictionbench.solvers.interface import Answer, solver
from frictionbench.solvers.interior.phases import Phased, Prepared, first_point, run
from frictionbench.solvers.interior.point import start_point
from frictionbench.solvers.interior.predictor_corrector import predictor_corrector

STARTS = ((0.1, 10.0), (10.0, 1.0))  # after the first: impulses and speeds, one large against the other, to differ from it
SHARE = 250  # factorisations from each start: above the default limit, so that only a larger one is shared out
PATIENCE = 60  # iterations without progress: a heavy body on a light one needs impulses a million times the first ones


@solver("relaxation_ip", family="interior point", model="relaxation", dimension=(2, 3), sparse=True)
class RelaxationInteriorPoint(Phased):
    """Mehrotra's predictor-corrector on the convex relaxation, one sparse factorisation in the velocities an iteration."""

    relaxed = True

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the factorisations, 200 by default."""
        _, system = prepared
        points = chain([first_point(system)], (start_point(system, *at) for at in STARTS))
        phases = ((predictor_corrector, point, SHARE) for point in points)
        return run(prepared, phases, tol, 200 if limit is None else limit, PATIENCE, relaxation_residual)
