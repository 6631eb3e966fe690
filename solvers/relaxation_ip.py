"""Interior point for the convex relaxation, with the same factorisation as for the friction LCP itself.

Where Coulomb's law has 0 <= c ⟂ u_n >= 0, the relaxation (problems.relaxation) has 0 <= c ⟂ u_n - mu lambda >= 0: a contact may
slide only while it opens. One sign more makes the LCP monotone, and Mehrotra's method hardly ever fails (Wright 1997). Beside
interior_point it tells what the model saves: the matrix and the arithmetic are the same.
"""

import numpy as np

from problems import FrictionProblem
from problems.check import Array
from problems.residual import relaxation_residual
from solvers.contact_newton import new_work, start_point
from solvers.contact_system import System, prepare
from solvers.interface import Answer, Status, solver
from solvers.predictor_corrector import Best, is_solved, predictor_corrector

PATIENCE = 60  # a heavy body on a light one needs impulses a million times the first ones


@solver("relaxation_ip", family="interior point", model="relaxation", sparse=True)
class RelaxationInteriorPoint:
    """Mehrotra's predictor-corrector on the convex relaxation, one sparse factorisation in the velocities an iteration."""

    def prepare(self, problem: FrictionProblem) -> tuple[FrictionProblem, System]:
        return problem, prepare(problem, relaxed=True)

    def solve(
        self, prepared: tuple[FrictionProblem, System], tol: float, limit: int | None, start: Array | None = None
    ) -> Answer:
        """limit bounds the factorisations, 200 by default."""
        problem, system = prepared
        if not problem.q.any():
            return Answer(np.zeros_like(system.offset), Status.SOLVED, {"iterations": 0, "factorisations": 0})
        history = np.empty((200 if limit is None else limit) + 1)
        best = Best(np.zeros_like(system.offset), np.array([np.inf]))
        first = start_point(system, float(np.sqrt(problem.contacts)), 1.0)
        used = predictor_corrector(system, first, new_work(system), best, tol / 2, PATIENCE, history)
        if is_solved(best, tol, system, problem, relaxation_residual):
            status = Status.SOLVED
        else:
            status = Status.WORK_LIMIT if used == len(history) else Status.STALLED
        work = {"iterations": used, "factorisations": used - 1}
        return Answer(best.impulse * system.impulse, status, work, tuple(history[:used].tolist()))
