"""Simulation of a scene over time."""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, Scheme, Solve, Step, start
from frictionbench.problems.schemes.anitescu_potra import anitescu_potra


def simulate(scene: Scene, solve: Solve, scheme: Scheme = anitescu_potra, steps: int | None = None) -> Iterator[Step]:
    """The initial state, then each step; by default as many as cover the scene's duration.

    Errors: InputError if the scheme refuses the scene; NoSolution, after the previous steps, if a step has no solution.
    """
    step = start(scene)
    yield step
    for _ in range(scene.steps if steps is None else steps):
        step = scheme(scene, step, solve)
        yield step


def first_problem(scene: Scene, scheme: Scheme = anitescu_potra) -> FrictionProblem:
    """The first friction problem that a scheme sets up in a scene. Errors: InputError if the scheme refuses the scene."""
    met: list[FrictionProblem] = []

    def meet(problem: FrictionProblem) -> Array:
        met.append(problem)
        return np.zeros((problem.contacts, problem.dimension))

    with suppress(NoSolution):
        scheme(scene, start(scene), meet)
    return met[0]


def first_problem_of(scene: Scene, scheme: str) -> FrictionProblem:
    """The first problem that the named scheme sets up in a scene; for the default scheme, the one after its impacts."""
    return scene.problem() if SCHEMES[scheme] is anitescu_potra else first_problem(scene, SCHEMES[scheme])
