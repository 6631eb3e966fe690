"""Motions of studies: by the event-driven scheme of a given accuracy, sampled at a few times, with their work."""

from collections.abc import Callable

import numpy as np

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import NoSolution, Step, start
from frictionbench.problems.schemes.event_driven import Impact, follow
from frictionbench.solvers import solve

SAMPLES = 10  # times at which motions are compared
FINEST = 1e-11  # the accuracy of the motion that the others are compared with


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


def exact(problem: FrictionProblem) -> Array:
    """The impulses by a solver that is exact up to rounding."""
    return solve(problem, "lemke", tol=1e-12).impulse
