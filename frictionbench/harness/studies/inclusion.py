"""Does the time-stepping scheme converge as the step shrinks? Impulses, velocities and their variation."""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from math import atan
from typing import Any

import numpy as np

from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import simulate
from frictionbench.results.store import Row
from frictionbench.solvers import solve

SCENES: dict[str, tuple[str, dict[str, Any], float]] = {  # name, settings, duration
    "rod": ("painleve_rod", {"angle": atan(2.0), "friction": 1.6, "tip_velocity": -3.0}, 0.1),
    "jam": ("jam", {"sideways": 0.1}, 0.2),
    "rocking block": ("rocking_block", {}, 0.8),
    "disc in a wedge": ("wedge", {"friction": 0.8}, 0.2),
}
STEPS = (0.01, 0.005, 0.0025, 0.00125, 0.000625)
SOLVERS = ("lemke", "nsgs", "interior_point")
SHARE = 0.75  # of m sin(angle) cos(angle) |v_t|: the rod's impulse in the limit of small steps


def refinement(
    scenes: Iterable[str] = SCENES, solvers: Iterable[str] = SOLVERS, steps: Iterable[float] = STEPS
) -> Iterator[Row]:
    """Accumulated quantities of each motion by the scheme of Anitescu and Potra, step by step finer."""
    for name in scenes:
        generator, settings, duration = SCENES[name]
        for solver in solvers:
            for step in steps:
                stage = scene(generator, **settings, step=step)
                yield {"scene": name, "solver": solver, "step": step, **accumulated(stage, solver, round(duration / step))}


def accumulated(stage: Any, solver: str, steps: int) -> Row:
    """Sums over the steps of a motion; kinetic norms are those of the mass matrix.

    With J'r the impulse of a step, v* the free and v+ the new velocity the ledger has T(v*) - T(v+) >= |J'r|^2/2 in M^-1, so
    that the sum of these squares is at most the energy at the start and the work of the external force.
    """

    def answer(problem: FrictionProblem) -> Array:
        return solve(problem, solver, tol=1e-9).impulse

    states = list(simulate(stage, answer, SCHEMES["anitescu_potra"], steps))
    weights, mass = stage.weights, np.sqrt(stage.weights)
    normal, net, squares, work = 0.0, np.zeros(len(weights)), 0.0, 0.0
    largest = 0.0
    for before, after in pairwise(states):
        for one in after.solved:
            push = one.problem.jacobian.T @ one.impulse.ravel()
            normal += float(one.impulse[:, 0].sum())
            largest = max(largest, float(one.impulse[:, 0].max(initial=0.0)))
            net = net + push
            squares += float(push @ (push / weights)) / 2
            free = one.problem.free_velocity
            work += float(weights @ (free**2 - before.v**2)) / 2
    changes = [float(np.linalg.norm(mass * (after.v - before.v))) for before, after in pairwise(states)]
    return {
        "normal": normal,
        "largest": largest,
        "net": net,
        "velocity": states[-1].v,
        "variation": sum(changes),
        "squares": squares,
        "bound": float(weights @ states[0].v ** 2) / 2 + work,
    }


STUDY = Study(
    name="inclusion",
    question="Does the scheme converge to a solution as the step shrinks?",
    method=f"""Painlevé's rod, whose tip is stopped by friction alone, the jam, a rocking block and a disc in a wedge, where
    normal impulses are not bounded by the data, are computed with steps from {STEPS[0]:g} to {STEPS[-1]:g} s by three solvers.
    Accumulated impulses, velocities at the end, the variation of the velocity in the norm of the kinetic energy, and the sum of
    the squared impulses |J'r|^2/2 in M^-1 are compared from step to step; the ledger bounds the last one by the energy at the
    start and the work of the external force.""",
    tables=(
        Table(
            refinement,
            {
                "scene": "motion",
                "solver": "by which every step is solved to 1e-9",
                "step": "s",
                "normal": "sum of all normal impulses, N s",
                "largest": "largest normal impulse, N s",
                "net": "sum of J'r, by velocity, N s and N m s",
                "velocity": "at the end, m/s and 1/s",
                "variation": "of the velocity, sum of |v+ - v|_M, root of J",
                "squares": "sum of |J'r|^2/2 in M^-1, J",
                "bound": "energy at the start and work of the external force, J",
            },
        ),
    ),
)
