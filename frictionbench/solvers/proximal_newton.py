"""Proximal points of Coulomb's law in space, each found by Newton's method.

The proximal point of an anchor a solves the contact problem with u + rho s (r - a) in place of u, s the contacts' scales: as
if every contact were slightly compliant, and unloaded at a. However redundant the contacts are, its impulses are isolated, and
for large rho it separates into one small problem a contact, which Newton's method (solvers.interior.alart_curnier) solves in a
few steps. Then a moves there and rho is halved; if Newton's method fails, it starts from a again, with a rho five times larger.

    a <- r,  rho <- rho / 2      where |s F| fell below a hundredth of the residual,         otherwise    rho <- 5 rho.

From a given start rho begins with its residual, as in Levenberg and Marquardt's method near solutions that are not isolated: a
larger rho only holds it up there.

Where a is stationary it is a Coulomb solution, for every rho. For a monotone problem the anchors converge; Coulomb's law is not
monotone, so they need not. It solves problems that trap interior points: large friction, and contacts in random directions.

References: Rockafellar 1976; Yamashita and Fukushima 2001; Acary, Brémond and Huber 2018, section 4.4.
"""

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual
from frictionbench.solvers.clock import is_past
from frictionbench.solvers.interface import Answer, Status, impulses, solver
from frictionbench.solvers.interior.alart_curnier import new_state, newton
from frictionbench.solvers.interior.predictor_corrector import last_step
from frictionbench.solvers.interior.system import System, build_system, in_velocities, new_work

LIMIT = 1500  # factorisations by default: most problems that are solved take less than 500
STEPS = 20  # of Newton's method for one proximal point: it converges within a few, or not at all
ENOUGH = 1e-2  # |s F| required of a proximal point, relative to the least residual so far: an anchor need not be exact
ACCURATE = 1e-11  # and relative to the largest free velocity: near what rounding leaves
SOFT, SOFTER, STIFFER = 1.0, 5.0, 0.5  # rho at first, a contact's own scale, and its factors after a failure and a success
LEAST = 1e-8  # of rho: below, G is singular to rounding


@solver("proximal_newton", family="newton", model="coulomb", dimension=(3,), warm_start=True, sparse=True)
class ProximalNewton:
    """Proximal points found by Newton's method on Alart and Curnier's equations, sparse in the velocities.

    Work: factorisations, and anchors tried. History: the residual after each of them.
    """

    def form(self, problem: FrictionProblem) -> FrictionProblem:
        """Joints are eliminated, which leaves a problem in Delassus form."""
        if problem.joints.shape[0]:
            laws = (problem.friction, problem.dimension, problem.friction_bias)
            problem = FrictionProblem.from_delassus(problem.W, problem.q, *laws)
        return in_velocities(problem)

    def setup(self, problem: FrictionProblem) -> tuple[FrictionProblem, System]:
        return problem, build_system(problem)

    def solve(
        self, prepared: tuple[FrictionProblem, System], tol: float, limit: int | None, start: Array | None = None
    ) -> Answer:
        """limit bounds the factorisations, 1500 by default."""
        problem, system = prepared
        limit = LIMIT if limit is None else limit
        nc, work = problem.contacts, new_work(system)
        anchor = impulses(start, (nc, 3)) / system.impulse
        state, trial, step = new_state(nc), new_state(nc), np.zeros((nc, 3))
        state.r[:] = anchor
        impulse = anchor * system.impulse
        least = residual(problem, impulse)
        history, factorisations, rho = [least], 0, SOFT if start is None else min(SOFT, least)
        until = last_step(system)
        while least > tol and factorisations < limit and not is_past(until):
            steps = min(STEPS, limit - factorisations)
            aim = max(ACCURATE / 100, ENOUGH / 10 * min(least, 1.0))
            used, off = newton(system, state, trial, anchor, rho, step, work, aim, steps, until)
            factorisations += used
            if not used:
                break  # |s F| is zero up to rounding, the residual is not
            found = residual(problem, state.r * system.impulse)
            history.append(found)
            if found < least:
                impulse, least = state.r * system.impulse, found
            if off < max(ENOUGH * least, ACCURATE):
                anchor[:] = state.r
                rho = max(STIFFER * rho, LEAST)
            else:
                state.r[:] = anchor
                rho *= SOFTER
        spent = {"factorisations": factorisations, "anchors": len(history) - 1}
        if least <= tol:
            return Answer(impulse, Status.SOLVED, spent, tuple(history))
        status = Status.WORK_LIMIT if factorisations == limit else Status.TIME_LIMIT if is_past(until) else Status.STALLED
        return Answer(impulse, status, spent, tuple(history))
