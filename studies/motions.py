"""Motions and problems for studies; motions are event-driven to a given accuracy, or by solvers at a tight tolerance."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import frictionbench as fb
from frictionbench.problems import (
    SCHEMES,
    FrictionProblem,
    Impact,
    NoSolution,
    Scene,
    Solve,
    Step,
    first_problem,
    follow,
    simulation,
    start,
)
from frictionbench.solvers import solve
from studies.study import Array

SAMPLES = 10  # times at which motions are compared
REFERENCE_ACCURACY = 1e-11  # the accuracy of the reference motion
TOL = 1e-10


def by_events(law: Impact, accuracy: float) -> Callable[[Scene, Step, Solve], Step]:
    """Return the event-driven scheme with this law and accuracy."""
    return lambda made, now, answer: follow(made, now, answer, law, accuracy)


def sampled(made: Scene, scheme: Callable[..., Step], every: int = 1) -> tuple[Array, int]:
    """Return the coordinates (samples, nq) after every `every` steps, fewer if the scheme ends early, and the work."""
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


def path(stage: Scene, answer: Solve, scheme: str, steps: int | None = None) -> Array:
    """Return the positions (steps + 1, nv) of a motion."""
    return np.array([step.q for step in simulation(stage, answer, SCHEMES[scheme], steps)])


def problem_of(name: str, settings: Mapping[str, Any]) -> FrictionProblem:
    """Return an instance, or the first problem of a scene."""
    return fb.instance(name, **settings) if name in fb.instances() else first_problem(fb.scene(name, **settings))


def thrown(problem: FrictionProblem, draws: int, seed: int) -> list[FrictionProblem]:
    """Return the problem with random free velocities, uniformly distributed in direction in the norm of a diagonal M."""
    random, root = np.random.default_rng(seed), np.sqrt(problem.mass.diagonal())
    return [problem.replace(free_velocity=random.normal(size=len(root)) / root) for _ in range(draws)]


def apart(problem: FrictionProblem, v: Array, w: Array) -> float:
    """Return |v - w|_M / |v*|_M, in the norm of the kinetic energy."""
    free = problem.free_velocity
    return float(np.sqrt((v - w) @ (problem.mass @ (v - w)) / (free @ (problem.mass @ free))))


def by(spec: str, tol: float = TOL) -> Solve:
    """The impulses (nc, d) of a problem by this solver."""
    return lambda problem: solve(problem, spec, tol=tol).impulse


exact = by("lemke", 1e-12)
coulomb = by("hybrid")
relaxed = by("relaxation_ip")
