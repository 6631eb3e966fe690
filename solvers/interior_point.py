"""Interior point methods for Coulomb friction itself, sparse in the velocities of the bodies.

In the plane the problem is the friction LCP; in space it has the circular cone as it is (solvers.interior.point). A step costs
one sparse factorisation of the size of the mass matrix (solvers.interior.newton, solvers.sparse_lu.multifrontal), as for the
convex relaxation. Mehrotra's predictor-corrector (solvers.interior.predictor_corrector) comes first: about ten iterations, few
more for a thousand boxes than for ten.

The problem is not monotone, and the predictor-corrector can be trapped: in a few random instances of a hundred, and in large
sheared pyramids with much friction. Then the central path is followed around its folds (solvers.interior.central_path), first
from around where Gauss-Seidel gets in SWEEPS sweeps (solvers.interior.centred_point), or around impulses given if these are
nearer, which show how the contacts are loaded; then from up to six starts that know nothing. Each path arrives with a chance
that falls with the number of contacts, and one that winds on is left for the next.

Given impulses to start from, the predictor-corrector sets out from the centred point around them. As this keeps the distance
from the boundary that their residual suggests, a good start saves most of the iterations, and a bad one does no harm.
"""

from collections.abc import Iterator

import numpy as np

from problems import FrictionProblem
from problems.check import Array
from problems.residual import residual
from solvers.interface import Answer, impulses, solve, solver
from solvers.interior.central_path import trace
from solvers.interior.centred_point import centred_point
from solvers.interior.phases import Phase, Phased, Prepared, first_point, run
from solvers.interior.point import Point, start_point
from solvers.interior.predictor_corrector import predictor_corrector
from solvers.interior.system import System, space_of

# Impulses and speeds, relative to a contact's own, by dimension: each of these arrives in three of four instances in the plane.
STARTS = {
    2: ((0.1, 10.0), (1.0, 10.0), (0.1, 100.0), (1.0, 100.0), (10.0, 1.0), (1.0, 1.0)),
    3: ((1.0, 100.0), (1.0, 10.0), (0.1, 1.0), (10.0, 100.0), (1.0, 1.0), (10.0, 10.0)),
}
SWEEPS = 1000  # before the central path is followed: as dear as ten or twenty factorisations
NEAR = 1e-10  # a start's least distance from the boundary, in residuals, to step on from
FAR = {2: (0.3,), 3: (0.8, 0.4, 1.6, 0.2, 3.0)}  # and to follow paths from, by dimension
LIMIT = 2000  # factorisations
PATIENCE = 12  # iterations of the predictor-corrector without progress: more than ever helped


@solver(
    "interior_point",
    family="interior point",
    model="coulomb",
    dimension=(2, 3),
    warm_start=True,
    sparse=True,
    members=("nsgs",),
)
class InteriorPoint(Phased):
    """Predictor-corrector on Coulomb's law, then its central path; one sparse factorisation an iteration.

    A portfolio where it is trapped: the path starts from what nsgs left, whose work is counted under that name.
    shortcut: try the predictor-corrector first; otherwise follow the path from the beginning.
    paths: follow paths where the predictor-corrector is trapped; otherwise end there.
    """

    shortcut: bool = True
    paths: bool = True

    def solve(self, prepared: Prepared, tol: float, limit: int | None, start: Array | None = None) -> Answer:
        """limit bounds the factorisations."""
        swept: dict[str, int] = {}
        phases = self._phases(*prepared, start, swept)
        limit = LIMIT if limit is None else limit
        answer = run(prepared, phases, tol, limit, PATIENCE, residual)
        answer.work |= {f"nsgs {unit}": count for unit, count in swept.items()}
        return answer

    def _phases(self, problem: FrictionProblem, system: System, start: Array | None, swept: dict[str, int]) -> Iterator[Phase]:
        """The methods in turn, with the points they start from; swept: the work of nsgs, if it comes to that."""
        if start is not None:
            yield predictor_corrector, _around(problem, system, impulses(start, system.offset.shape), NEAR)
        if self.shortcut:
            yield predictor_corrector, first_point(system)
        if not self.paths:
            return
        near = solve(problem, "nsgs", limit=SWEEPS)
        swept |= near.work
        guess = near.impulse
        if start is not None and residual(problem, start) < residual(problem, guess):
            guess = start
        for far in FAR[problem.dimension]:
            yield trace, _around(problem, system, guess, far)
        for impulse, speed in STARTS[problem.dimension]:
            point = start_point(system, impulse, speed)
            if problem.dimension == 3:  # with large mu paths arrive only where the friction is what mu c allows
                point.s[:, 3] *= np.maximum(system.friction, 1)
            yield trace, point


def _around(problem: FrictionProblem, system: System, impulse: Array, least: float) -> Point:
    """The centred point around impulses (nc, d), as far from the boundary as they are from a solution, or by `least`."""
    distance = max(residual(problem, impulse), least)
    return centred_point(system, space_of(system), impulse, problem.contact_velocity(impulse), distance)
