"""Motions that studies compare: solvers at a tight tolerance, and the ends of simulations."""

from collections.abc import Callable

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import simulate
from frictionbench.solvers import solve

TOL = 1e-10


def coulomb(problem: FrictionProblem) -> Array:
    """The impulses (nc, d) of Coulomb's law, by the portfolio."""
    return solve(problem, "hybrid", tol=TOL).impulse


def relaxed(problem: FrictionProblem) -> Array:
    """The impulses (nc, d) of the convex relaxation."""
    return solve(problem, "relaxation_ip", tol=TOL).impulse


def path(stage: Scene, answer: Callable[[FrictionProblem], Array], scheme: str, steps: int | None = None) -> Array:
    """The positions (steps + 1, nv) of a motion."""
    return np.array([step.q for step in simulate(stage, answer, SCHEMES[scheme], steps)])
