"""Motions that studies compare: by the event-driven scheme of a given accuracy, and by solvers at a tight tolerance."""

from collections.abc import Callable

import numpy as np

from frictionbench.problems import SCHEMES, FrictionProblem, Impact, NoSolution, Scene, Step, follow, simulation, start
from frictionbench.solvers import solve
from studies.study import Array

SAMPLES = 10  # times at which motions are compared
FINEST = 1e-11  # the accuracy of the motion that the others are compared with
TOL = 1e-10


def by_events(law: Impact, accuracy: float) -> Callable[[Scene, Step, Callable[[FrictionProblem], Array]], Step]:
    """The event-driven scheme with this law and accuracy."""
    return lambda made, now, answer: follow(made, now, answer, law, accuracy)


def sampled(made: Scene, scheme: Callable[..., Step], every: int = 1) -> tuple[Array, int]:
    """The coordinates (samples, nq) after each so many steps, fewer where the scheme ends; and the work."""
    now, path, work = start(made), [], 0
    try:
        for _ in range(SAMPLES):
            for _ in range(every):
                now = scheme(made, now, exact)
                work += len(now.solved) + sum(smooth.evaluations for smooth in now.smooth)
            path.append(now.q)
    except NoSolution:
        pass
    return np.array(path).reshape(len(path), len(made.q0)), work


def path(stage: Scene, answer: Callable[[FrictionProblem], Array], scheme: str, steps: int | None = None) -> Array:
    """The positions (steps + 1, nv) of a motion."""
    return np.array([step.q for step in simulation(stage, answer, SCHEMES[scheme], steps)])


def exact(problem: FrictionProblem) -> Array:
    """The impulses (nc, d) by a solver that is exact up to rounding."""
    return solve(problem, "lemke", tol=1e-12).impulse


def coulomb(problem: FrictionProblem) -> Array:
    """The impulses (nc, d) of Coulomb's law, by the portfolio."""
    return solve(problem, "hybrid", tol=TOL).impulse


def relaxed(problem: FrictionProblem) -> Array:
    """The impulses (nc, d) of the convex relaxation."""
    return solve(problem, "relaxation_ip", tol=TOL).impulse
