"""Painlevé's paradox and the discontinuity in initial data: how far motions part that begin almost alike."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product
from math import hypot, sqrt
from typing import Any

import numpy as np

from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.check import Array
from frictionbench.problems.scene import Scene
from frictionbench.problems.scenes import scene
from frictionbench.problems.schemes import SCHEMES, NoSolution
from frictionbench.problems.simulate import first_problem, simulate
from frictionbench.results.store import Row
from frictionbench.solvers import solve

STEP, STEPS = 0.002, 10  # s, and their number
G, HEIGHT, FALL, ASPECT = 9.81, 0.0051, 1.0, 3.0  # m/s^2; of the fall of a tall block, m; its first speed, m/s; its shape
ROD = {"tip_velocity": -3.0, "friction": 1.6}  # at its steepest angle, where p < 0 from mu = 4/3 on
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "rod at p > 0": ("painleve_rod", ROD | {"friction": 1.0}),
    "rod at p < 0": ("painleve_rod", ROD),
    "rod leaving at p < 0": ("painleve_rod", ROD | {"lift": G * STEP}),
    "jam": ("jam", {}),
    "flat landing": ("two_corner_block", {"fall": FALL, "friction": 1.0, "aspect": ASPECT, "velocity": 0.0}),
}
SCHEMES_COMPARED = ("anitescu_potra", "stewart_trinkle", "moreau", "event_driven")
SOLVERS = ("lemke", "nsgs", "interior_point")
SIZES = (1e-8, 1e-5, 1e-2)  # of the changes, m/s
SPINS = tuple(float(10.0**power) for power in np.arange(-6, 0.5, 0.5))  # rad/s
LIFTS = (0.0, 0.5, 0.9, 1.1, 1.5, 2.0, 4.0, 8.0, 16.0, 32.0)  # of the rod's tip, over g h


def ensembles(
    cases: Iterable[str] = CASES,
    schemes: Iterable[str] = SCHEMES_COMPARED,
    solvers: Iterable[str] = SOLVERS,
    sizes: Iterable[float] = SIZES,
    members: int = 4,
) -> Iterator[Row]:
    """Neighbours of each undisturbed motion: the largest distance of velocities on the way, and at the end."""
    for case, scheme, solver in product(cases, schemes, solvers):
        stage = begin(case)
        middle = motion(stage, scheme, solver)
        for size in sizes:
            apart, last = [], []
            for seed in range(members):
                way = np.random.default_rng(seed).normal(size=len(stage.v0))
                found = motion(replace(stage, v0=stage.v0 + size * way / np.linalg.norm(way)), scheme, solver)
                common = min(len(found), len(middle))
                away = np.linalg.norm(found[:common] - middle[:common], axis=1)
                apart.append(float(away.max(initial=0.0)))
                last.append(float(away[-1]) if common == STEPS else None)
            whole = len(middle) == STEPS
            yield {
                "case": case,
                "scheme": scheme,
                "solver": solver,
                "size": size,
                "members": members,
                "ended": sum(end is not None for end in last),
                "velocity": middle[-1] if whole else None,
                "most_apart": max(apart) if whole else None,
                "apart": max((end for end in last if end is not None), default=None),
            }


def begin(case: str) -> Scene:
    """The undisturbed start; the block that lands is lifted to its height."""
    name, settings = CASES[case]
    stage = scene(name, **settings, step=STEP)
    return replace(stage, q0=stage.q0 + np.array([0.0, HEIGHT, 0.0])) if case == "flat landing" else stage


def motion(stage: Scene, scheme: str, solver: str, steps: int = STEPS) -> Array:
    """The velocities (steps, nv) after each step, fewer where the scheme has no solution."""

    def answer(problem: FrictionProblem) -> Array:
        return solve(problem, solver, tol=1e-10).impulse

    found = []
    try:
        for now in simulate(stage, answer, SCHEMES[scheme], steps):
            found.append(now.v)  # noqa: PERF401, what was found before the failure is kept
    except NoSolution:
        pass
    return np.array(found[-steps:]).reshape(-1, len(stage.v0))


def landings(schemes: Iterable[str] = SCHEMES_COMPARED, spins: Iterable[float] = SPINS) -> Iterator[Row]:
    """A tall block that lands almost flat with a small spin: one corner hits first, the other a moment later.

    closed: the spin at the end after two hits in sequence, with half width b, half height H and R^2 = b^2 + H^2: the first hit
    turns the block about its corner with v b/(4/3 R^2), the second leaves 1 - 3/2 (b/R)^2 of it (Housner 1963), and the weight
    takes 3/4 g b/R^2 a second from it.
    """
    speed, b, radius = sqrt(FALL**2 + 2 * G * HEIGHT), 0.5, hypot(0.5, ASPECT / 2)
    falling = STEPS * STEP - (speed - FALL) / G
    closed = speed * b / (4 / 3 * radius**2) * (1 - 1.5 * (b / radius) ** 2) - 0.75 * G * b / radius**2 * falling
    for scheme, spin in product(schemes, spins):
        stage = begin("flat landing")
        found = motion(replace(stage, v0=stage.v0 + np.array([0.0, 0.0, spin])), scheme, "lemke")
        tilt = spin * (speed - FALL) / G
        yield {
            "scheme": scheme,
            "spin": spin,
            "delay": 2 * b * tilt / speed,
            "after": abs(float(found[-1, 2])) if len(found) == STEPS else None,
            "closed": closed,
        }


def lifts(solvers: Iterable[str] = SOLVERS, steps: Iterable[float] = (0.004, 0.002, 0.001)) -> Iterator[Row]:
    """The rod's first step where p < 0, with its tip moving up: which solution each solver returns, and how many there are."""
    for step, lift in product(steps, LIFTS):
        stage = scene("painleve_rod", **ROD, lift=lift * G * step, step=step)
        count = census(first_problem(stage)).velocity_count
        for solver in solvers:
            v = motion(stage, "anitescu_potra", solver, 1)[0]
            yield {"step": step, "lift": lift, "solver": solver, "solutions": count, "along": float(v[0])}


STUDY = Study(
    name="neighbours",
    question="Are Painlevé's paradox and the discontinuity in initial data real obstacles?",
    method=f"""Motions of {STEPS} steps of {STEP:g} s are repeated from neighbouring starts, whose velocities differ by random
    vectors of 1e-8 to 1e-2 m/s, with each of three solvers in each of four schemes: Painlevé's rod on either side of p = 0 and
    as its tip leaves the ground, the jam, and a tall block that lands flat, so that a small spin decides the order of two hits.
    The spin left by such a landing is compared with the closed form of two hits in sequence; the solutions of the rod's first
    step are counted by the census, independently of the solvers.""",
    tables=(
        Table(
            ensembles,
            {
                "case": "of motion",
                "scheme": "time-stepping scheme",
                "solver": "of the steps, to 1e-10",
                "size": "of the change of the first velocities, m/s and rad/s",
                "members": "number of neighbours",
                "ended": "of these with a solution in every step, as the undisturbed motion",
                "velocity": "at the end of the undisturbed motion, null where a step has no solution; m/s and rad/s",
                "most_apart": "largest distance of a neighbour's velocities on the way, m/s and rad/s",
                "apart": "the same at the end",
            },
        ),
        Table(
            landings,
            {
                "scheme": "time-stepping scheme",
                "spin": "of the start, rad/s",
                "delay": "between the two hits, s",
                "after": "spin at the end, rad/s",
                "closed": "the same by the closed form of two hits in sequence, rad/s",
            },
        ),
        Table(
            lifts,
            {
                "step": "s",
                "lift": "first velocity of the tip, upwards, over g times the step",
                "solver": "of the step, to 1e-10",
                "solutions": "number of velocities that solve the step, by the census",
                "along": "velocity of the rod's centre along the ground after the step, m/s",
            },
        ),
    ),
)
