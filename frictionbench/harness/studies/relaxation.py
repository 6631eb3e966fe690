"""Can a step with friction be recast as a convex problem? The relaxation's error, and Anitescu and Hart's fixed point."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from frictionbench.harness.studies.moves import TOL, coulomb, path, relaxed
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual
from frictionbench.problems.scene import GRAVITY
from frictionbench.problems.scenes import scene
from frictionbench.results.store import Row
from frictionbench.solvers import solve

PILES: dict[str, dict[str, Any]] = {
    "stack": {"blocks": 5},
    "pyramid": {"rows": 4},
    "wall": {"rows": 3, "columns": 3},
    "arch": {"stones": 9, "push": 1.0},
}
FRICTIONS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6)
STEPS = (1e-4, 1e-3, 1e-2)
GAPS = "stewart_trinkle"


def errors(frictions: Iterable[float] = FRICTIONS, steps: Iterable[float] = STEPS) -> Iterator[Row]:
    """First problems of pushed piles: the relaxation beside Coulomb's law, and two iterations towards the law."""
    for name, size in PILES.items():
        for friction in frictions:
            for step in steps:
                problem = scene(name, **{"push": 1.0} | size, friction=friction, step=step).problem()
                v, w = problem.velocity(coulomb(problem)), problem.velocity(relaxed(problem))
                counts = {
                    spec: answer.work[unit] if residual(problem, answer.impulse) <= 1e-8 else None
                    for spec, unit in (("anitescu_hart", "relaxations"), ("staggered", "rounds"))
                    for answer in (solve(problem, spec, tol=1e-8),)
                }
                yield {
                    "scene": name,
                    "friction": friction,
                    "step": step,
                    "residual": residual(problem, relaxed(problem)),
                    "error": energy_norm(problem, w - v) / energy_norm(problem, problem.free_velocity),
                    **counts,
                }


def energy_norm(problem: FrictionProblem, v: Array) -> float:
    return float(np.sqrt(v @ (problem.mass @ v)))


def cycle(frictions: Iterable[float] = np.linspace(0.45, 1, 12), b: float = 0.97, rounds: int = 300) -> Iterator[Row]:
    """One contact W = [[1, b], [b, 1]] that slides along +t: the fixed point written out, the solver, and staggering."""
    for mu in frictions:
        one = FrictionProblem(
            mass=np.linalg.inv([[1, b], [b, 1]]),
            normal=[[1, 0]],
            tangent=[[0, 1]],
            friction=[mu],
            free_velocity=[-1, 10],
            bias=[0],
        )
        exact = abs(one.contact_velocity(coulomb(one))[0, 1])
        near, far = (fixed_point(one, start, count) for start, count in ((exact * (1 + 1e-3), 3), (0.0, rounds)))
        away = np.abs(near - exact)
        yield {
            "friction": mu,
            "solutions": census(one).count,
            "predicted": abs(mu * (mu - b)) / (1 - 2 * mu * b + mu**2),
            "measured": float((away[3] / away[0]) ** (1 / 3)),
            "converges": bool(abs(far[-1] - exact) <= 1e-6 * exact),
            "cycles": bool(abs(far[-1] - far[-3]) <= 1e-6 * exact and abs(far[-1] - far[-2]) > 1e-3 * exact),
            "solver": solve(one, "anitescu_hart", tol=1e-8).status.name.lower(),
            "staggered": solve(one, "staggered", tol=1e-8).status.name.lower(),
        }


def fixed_point(one: FrictionProblem, start: float, count: int) -> Array:
    """lam^0 ... lam^count; each relaxation is solved by another method than that of the solver anitescu_hart."""
    lams = [start]
    for _ in range(count):
        shifted = one.replace(bias=one.friction * lams[-1])
        lams.append(abs(one.contact_velocity(relaxed(shifted))[0, 1]))
    return np.array(lams)


def gaps(friction: float = 0.6, speed: float = 1.0, steps: Iterable[float] = (0.016, 0.008, 0.004, 0.002)) -> Iterator[Row]:
    """How high the relaxation lifts a sliding block: after a sudden start, and after a smooth one down a slope."""
    for step in steps:
        thrown = scene("stopping_block", friction=friction, speed=speed, step=step, duration=0.4)
        down = scene("incline", friction=0.3, angle=0.5, step=step, duration=0.4)
        normal = np.array([-np.sin(0.5), np.cos(0.5)])
        q = path(down, relaxed, GAPS)
        sliding = np.abs(np.diff(q[:, :2] @ np.array([np.cos(0.5), np.sin(0.5)])) / step).max()
        yield {
            "step": step,
            "hop": np.ptp(path(thrown, relaxed, GAPS)[:, 1]),
            "hop_predicted": (friction * speed / (1 + friction**2)) ** 2 / (2 * GRAVITY),
            "smooth": ((q[:, :2] - q[0, :2]) @ normal).max(),
            "smooth_predicted": step * 0.3 * sliding,
            "coulomb": np.ptp(path(thrown, coulomb, GAPS)[:, 1]),
        }


def stopping(frictions: Iterable[float] = (0.2, 0.6, 1.0), steps: Iterable[float] = (0.016, 0.008, 0.004)) -> Iterator[Row]:
    """How far a block slides until it stops, by both models."""
    for friction in frictions:
        for step in steps:
            stage = scene("stopping_block", friction=friction, step=step, duration=1.1 / (friction * GRAVITY))
            yield {
                "friction": friction,
                "step": step,
                "exact": 1 / (2 * friction * GRAVITY),
                "coulomb": path(stage, coulomb, GAPS)[-1, 0],
                "relaxed": path(stage, relaxed, GAPS)[-1, 0],
            }


def falls(
    frictions: Iterable[float] = (0.5, 0.6, 0.7, 0.8), speeds: Iterable[float] = np.linspace(1, 4, 13), steps: int = 150
) -> Iterator[Row]:
    """A block twice as high as wide is thrown along the ground: whether it tips over, by both models."""
    for friction in frictions:
        for speed in speeds:
            stage = scene("two_corner_block", aspect=2.0, friction=friction, velocity=speed)
            ends = {
                model: path(stage, answer, GAPS, steps)[-1] for model, answer in (("coulomb", coulomb), ("relaxed", relaxed))
            }
            yield {
                "friction": friction,
                "speed": speed,
                **{model: bool(abs(q[2]) > 1.0) for model, q in ends.items()},
                "apart": float(np.hypot(*(ends["coulomb"] - ends["relaxed"])[:2])),
            }


STUDY = Study(
    name="relaxation",
    question="Can a step be recast as a convex problem?",
    method=f"""Piles that are pushed are solved by Coulomb's law and by the convex relaxation, both to {TOL:g}, over friction
    and step; the error is that of the velocity in the norm of the kinetic energy, over the free velocity. Anitescu and Hart's
    fixed point of relaxations and staggered projections then count their iterations to 1e-8. One contact with an unsymmetric
    pull shows where the fixed point cycles: written out by hand, beside the solver, the closed form of its rate and the census.
    What the error costs is seen in motions by the scheme of Stewart and Trinkle: hops, stopping distances, blocks that tip.""",
    tables=(
        Table(
            errors,
            {
                "scene": "pile, its lowest or topmost body pushed",
                "friction": "mu",
                "step": "s",
                "residual": "of the relaxation's answer by Coulomb's law",
                "error": "|v_relaxed - v_Coulomb|_M / |v*|_M",
                "anitescu_hart": "relaxations until 1e-8; null if not reached",
                "staggered": "rounds of staggered projections until 1e-8; null if not reached",
            },
        ),
        Table(
            cycle,
            {
                "friction": "mu",
                "solutions": "number of solutions",
                "predicted": "rate of the fixed point by its closed form",
                "measured": "rate of the fixed point written out, from 1e-3 beside the solution",
                "converges": "whether from 0 it arrives within 1e-6 of the solution",
                "cycles": "whether from 0 it ends in a cycle of two",
                "solver": "status of anitescu_hart",
                "staggered": "status of staggered projections",
            },
        ),
        Table(
            gaps,
            {
                "step": "s",
                "hop": "greatest height of the relaxed block after a sudden start, m",
                "hop_predicted": "(mu v/(1 + mu^2))^2/(2 g), its limit for small steps, m",
                "smooth": "greatest gap of the relaxed block that begins to slide smoothly, m",
                "smooth_predicted": "h mu |v_t| at its greatest speed, m",
                "coulomb": "greatest height by Coulomb's law after the sudden start, m",
            },
        ),
        Table(
            stopping,
            {
                "friction": "mu",
                "step": "s",
                "exact": "v^2/(2 mu g), m",
                "coulomb": "distance by Coulomb's law, m",
                "relaxed": "distance by the relaxation, m",
            },
        ),
        Table(
            falls,
            {
                "friction": "mu",
                "speed": "at which the block is thrown, m/s",
                "coulomb": "whether it tips over by Coulomb's law",
                "relaxed": "whether it tips over by the relaxation",
                "apart": "distance of the two blocks at the end, m",
            },
        ),
    ),
)
