"""Interior point on the friction LCP itself: how often and how fast, beside the relaxation, and paths that fold."""

from collections.abc import Iterable, Iterator
from itertools import compress, product
from typing import Any

import numpy as np

from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.analysis.thresholds import is_p0
from frictionbench.problems.check import Array
from frictionbench.problems.instances import make_instance
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import first_problem
from frictionbench.results.store import Row
from frictionbench.solvers import Answer, solve
from frictionbench.solvers.interior.phases import first_point, run
from frictionbench.solvers.interior.predictor_corrector import predictor_corrector
from frictionbench.solvers.interior.system import build_system, in_velocities

TOL, LIMIT, PATIENCE = 1e-8, 200, 12
END = 1e-4  # t at which a path is near enough to its end
FRICTIONS = (0.1, 0.3, 1.0, 3.0, 10.0)


def plain(problem: FrictionProblem) -> Answer:
    """Mehrotra's predictor-corrector on Coulomb's law from one start, and nothing after it."""
    prepared = in_velocities(problem), build_system(in_velocities(problem), False)
    return run(prepared, [(predictor_corrector, first_point(prepared[1]), LIMIT)], TOL, LIMIT, PATIENCE, residual)


def compared(problem: FrictionProblem) -> Row:
    """Which of the three methods solve the problem, with their factorisations; with paths: predictor-corrector, then paths."""
    answers = {"plain": plain(problem), "paths": solve(problem, "interior_point", tol=TOL)}
    relaxed = solve(problem, "relaxation_ip", tol=TOL)
    found = {name: (residual(problem, one.impulse) <= TOL, one) for name, one in answers.items()}
    found["relaxation"] = (relaxation_residual(problem, relaxed.impulse) <= TOL, relaxed)
    return {name: bool(solved) for name, (solved, _) in found.items()} | {
        f"{name}_work": one.work["factorisations"] if solved else None for name, (solved, one) in found.items()
    }


def random(frictions: Iterable[float] = FRICTIONS, contacts: Iterable[int] = (5, 15, 40), seeds: int = 15) -> Iterator[Row]:
    """Planar bodies that touch at random."""
    for friction, count, seed in product(frictions, contacts, range(seeds)):
        problem = make_instance("random", contacts=count, friction=friction, seed=seed)
        yield {"friction": friction, "contacts": problem.contacts, "seed": seed, **compared(problem)}


def piles(frictions: Iterable[float] = (0.05, 0.2, 0.8), blocks: Iterable[int] = (1, 5, 20, 50, 100, 200)) -> Iterator[Row]:
    """Stacks on a slope whose lowest block is pushed."""
    for friction, count in product(frictions, blocks):
        problem = scene("stack", blocks=count, friction=friction, push=1.0, slope=0.1).problem()
        yield {"friction": friction, "blocks": count, **compared(problem)}


def threshold(ratios: Iterable[float] = (0.25, 0.5, 0.9, 1.1, 2, 3, 4, 6), draws: int = 60) -> Iterator[Row]:
    """Random free velocities of a square block on two corners, of uniform direction in the metric of the kinetic energy."""
    for ratio in ratios:
        problem = first_problem(scene("two_corner_block", friction=ratio))
        draw = np.random.default_rng(0)
        root = np.sqrt(problem.mass.diagonal())
        thrown = [problem.replace(free_velocity=draw.normal(size=3) / root) for _ in range(draws)]
        rows = [compared(one) for one in thrown]
        yield {
            "ratio": ratio,
            "p0": is_p0(problem),
            "draws": draws,
            "several": sum(census(one).velocity_count != 1 for one in thrown),
            **{name: sum(row[name] for row in rows) for name in ("plain", "paths", "relaxation")},
            "plain_work": float(np.median([row["plain_work"] for row in rows if row["plain"]] or [np.nan])),
        }


def path(frictions: Iterable[float] = (1.0, 10.0), contacts: int = 5, seeds: Iterable[int] = range(16)) -> Iterator[Row]:
    """Central paths of random problems: of each friction the one that turns most often of those that arrive."""
    for friction in frictions:
        problems = [make_instance("random", contacts=contacts, friction=friction, seed=seed) for seed in seeds]
        traced = [central_path(problem.lcp()) for problem in problems]
        trapped = [residual(problem, plain(problem).impulse) > TOL for problem in problems]
        arrived = [points[-1][1] <= END for points in traced]
        folded = [bool(arrives and folds(points)) for arrives, points in zip(arrived, traced, strict=True)]
        counts = {
            "traced": len(traced),
            "arrived": sum(arrived),
            "folded": sum(folded),
            "trapped": sum(trapped),
            "both": sum(map(all, zip(trapped, folded, strict=True))),
        }
        for length, t in max(compress(traced, arrived), key=folds):
            yield {"friction": friction, "length": length, "t": t, **counts}


def folds(points: list[tuple[float, float]]) -> int:
    """How often t turns along a path."""
    return int(np.sum(np.diff(np.sign(np.diff([t for _, t in points]))) != 0))


def central_path(lcp: LCP, most: int = 600, length: float = 0.2) -> list[tuple[float, float]]:
    """The path z_i w_i = t, w - M z - q = t (e - M e - q) from z = w = e at t = 1, as (arc length, t), until t <= END.

    With a = log z and c = log t it is the curve G(a, c) = e^(c - a) - M e^a - q - e^c (e - M e - q) = 0, followed by its length
    in (a, c): a step along the tangent, Newton's method back by least squares, and half the step where that fails.
    """
    M, q = lcp.dense, lcp.q / np.abs(lcp.q).max()
    start = 1 - M.sum(axis=1) - q

    def defect(x: Array) -> tuple[Array, Array]:
        z, t = np.exp(x[:-1]), np.exp(x[-1])
        return t / z - M @ z - q - t * start, np.column_stack([-np.diag(t / z) - M * z, t / z - t * start])

    x, way, points, total = np.zeros(len(q) + 1), -np.eye(len(q) + 1)[-1], [(0.0, 1.0)], 0.0
    while len(points) < most and points[-1][1] > END:
        tangent = np.linalg.svd(defect(x)[1])[2][-1]
        tangent *= np.sign(tangent @ way)
        step = length
        while step > 1e-6:
            trial = x + step * tangent
            for _ in range(6):
                value, slope = defect(trial)
                trial = trial - np.linalg.lstsq(slope, value, rcond=None)[0]
            near = np.linalg.norm(trial - x) < 1.5 * step and (trial - x) @ tangent > 0.7 * np.linalg.norm(trial - x)
            if near and np.abs(defect(trial)[0]).max() < 1e-9 * max(1.0, np.exp(np.abs(trial).max())):
                break
            step /= 2
        else:
            break
        total += float(np.linalg.norm(trial - x))
        way, x = trial - x, trial
        points.append((total, float(np.exp(x[-1]))))
    return points


SOLVED: dict[str, Any] = {
    "plain": "whether the predictor-corrector alone solves it to 1e-8",
    "paths": "whether interior_point does, which follows central paths where the predictor-corrector is trapped",
    "relaxation": "whether the relaxation's interior point solves the relaxation to 1e-8",
}
WORK = {f"{name}_work": f"factorisations of {name}, null if not solved" for name in SOLVED}
STUDY = Study(
    name="interior",
    question="Does an interior point method work on the friction problem itself?",
    method=f"""The same predictor-corrector with the same factorisation solves Coulomb's law and its convex relaxation to
    {TOL:g}, from one start, with at most {LIMIT} factorisations; the solver interior_point goes on along central paths where
    the first is trapped. They meet random bodies over mu and the number of contacts, stacks over mu and height, and random
    velocities of a block on two corners, whose matrix is P0 up to mu H/w = 1; the census counts its solutions. Central
    paths of small random problems are followed by their length with a dense method of a few lines, written for this study.""",
    tables=(
        Table(random, {"friction": "mu", "contacts": "number of contacts", "seed": "of the instance", **SOLVED, **WORK}),
        Table(piles, {"friction": "mu", "blocks": "height of the stack", **SOLVED, **WORK}),
        Table(
            threshold,
            {
                "ratio": "mu H/w",
                "p0": "whether the LCP has a P0 matrix",
                "draws": "free velocities",
                "several": "how many have several velocities as solutions",
                **{name: text.replace("whether", "for how many") for name, text in SOLVED.items()},
                "plain_work": "median factorisations of the predictor-corrector where it solves",
            },
        ),
        Table(
            path,
            {
                "friction": "mu",
                "length": "of the path so far, in logarithms",
                "t": "z_i w_i, 1 at the start",
                "traced": "paths traced with this friction; this one turns most often of those that arrive",
                "arrived": f"how many reach t = {END:g} in 600 steps",
                "folded": "how many of these turn",
                "trapped": "on how many of these problems the predictor-corrector is trapped",
                "both": "on how many both",
            },
        ),
    ),
)
