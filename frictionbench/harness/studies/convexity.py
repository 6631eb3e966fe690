"""Is the solution set of a friction problem convex? All solutions of small problems, listed."""

import json
from collections.abc import Iterable, Iterator

import numpy as np

from frictionbench.harness.plans import families
from frictionbench.harness.plans.plan import Source
from frictionbench.harness.plans.suites import EXAMPLES
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import Census, census
from frictionbench.problems.analysis.polyhedra import Shape
from frictionbench.problems.analysis.thresholds import is_p0, is_pointed
from frictionbench.problems.check import Array
from frictionbench.problems.instances import instances, make_instance
from frictionbench.problems.instances.recorded_step import recorded_steps
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import first_problem, simulate
from frictionbench.results.store import Row
from frictionbench.solvers import solve

MOST = 5  # contacts of a problem whose solutions are listed: a tenth of a second
SHAPES = {shape: shape.value.replace(" ", "_") for shape in Shape}


def scenes() -> Iterator[Row]:
    """The first problems of scenes and instances with few contacts."""
    for source in (*families.sources(families.ONE, families.SMALL), *JAMMED):
        make = make_instance if source.scene in instances() else lambda name, **given: first_problem(scene(name, **given))
        problem = make(source.scene, **source.parameters)
        if problem.contacts > MOST or (found := listed(problem)) is None:
            continue
        yield {
            "scene": source.scene,
            "parameters": json.dumps(source.parameters),
            "contacts": problem.contacts,
            "impulses": found.shape.value,
            "velocities": found.velocity_shape.value,
            "pointed": is_pointed(problem),
            "p0": is_p0(problem),
        }


JAMMED = tuple(
    Source(name, settings)
    for name, settings in (("jam", {"sideways": 0.0}), ("wedge", {"friction": 0.5}), ("wedge", {"friction": 0.6}))
)


def jam(friction: float = 0.5, points: int = 41) -> Iterator[Row]:
    """Solutions of the jam by their closed form, and the middle of each and of the one without impulses.

    Normal impulses c = s m V/(2 mu) on both walls leave the speed v = max(1 - s, 0) V; with s beyond 1 friction is below its
    limit. The gap z'w of the LCP is computed by hand: at both contacts (mu c - beta) times the speed.
    """
    problem = first_problem(scene("jam", friction=friction))
    upwards, speed = problem.tangent.toarray()[:, 1], float(problem.free_velocity[1])
    for s in np.linspace(0, 2, points):
        normal = s * speed / (2 * friction)
        stopped = min(s, 1.0) * speed  # by the friction on both walls
        impulse = np.column_stack([np.full(2, normal), -upwards * stopped / 2])
        middle_speed = speed - stopped / 2
        yield {
            "share": s,
            "normal": normal,
            "velocity": problem.velocity(impulse)[1],
            "residual": residual(problem, impulse),
            "middle_residual": residual(problem, impulse / 2),
            "middle_gap": 2 * (friction * normal / 2 - stopped / 4) * middle_speed / speed**2,
        }


def block(
    frictions: Iterable[float] = np.linspace(0.5, 4, 8), aspects: Iterable[float] = (0.25, 0.5, 1, 2, 4), draws: int = 150
) -> Iterator[Row]:
    """Random free velocities of a block on two corners, of uniform direction in the metric of the kinetic energy."""
    for aspect in aspects:
        for friction in frictions:
            random = np.random.default_rng(0)  # the same draws at each point, so that neighbours differ by the problem alone
            problem = first_problem(scene("two_corner_block", aspect=aspect, friction=friction))
            root = np.sqrt(problem.mass.diagonal())
            found = [census(problem.replace(free_velocity=random.normal(size=3) / root)) for _ in range(draws)]
            yield {
                "friction": friction,
                "aspect": aspect,
                "p0": is_p0(problem),
                "draws": draws,
                **tally(found),
            }


def motions(names: Iterable[str] = EXAMPLES, steps: int | None = None, most: int = 60) -> Iterator[Row]:
    """The problems of simulated motions, at most so many of each spread over it, and the recorded steps with few contacts."""
    for name in names:
        met = [one.problem for step in simulate(scene(name), answer, steps=steps) for one in step.solved]
        few = [problem for problem in met if 0 < problem.contacts <= MOST]
        yield {"source": name, **counted(few[:: -(-len(few) // most) or 1])}
    kept = [make_instance("recorded_step", case=case) for case in recorded_steps()]
    yield {"source": "recorded steps", **counted([problem for problem in kept if problem.dimension == 2])}


def counted(problems: list[FrictionProblem]) -> Row:
    """How many problems have few contacts, of how many all solutions are listed, and their shapes."""
    few = [problem for problem in problems if 0 < problem.contacts <= MOST]
    found = [one for problem in few if (one := listed(problem)) is not None]
    return {"problems": len(few), "listed": len(found), **tally(found)}


def tally(found: list[Census]) -> Row:
    """How many sets of impulses have each shape, and how many have several velocities."""
    shapes = [one.shape for one in found]
    return {text: shapes.count(shape) for shape, text in SHAPES.items()} | {
        "several_velocities": sum(one.velocity_count != 1 and one.shape is not Shape.NONE for one in found),
        "most_velocities": max((one.velocity_count or 0 for one in found), default=0),
    }


def listed(problem: FrictionProblem) -> Census | None:
    """All solutions; None where round-off forbids to tell them apart."""
    try:
        return census(problem)
    except ArithmeticError:
        return None


def answer(problem: FrictionProblem) -> Array:
    """The impulses by which motions continue."""
    return solve(problem, "hybrid", tol=1e-10).impulse


TALLY = {
    **{text: f"problems whose set of impulses is {shape.value}" for shape, text in SHAPES.items()},
    "several_velocities": "problems whose solutions have more than one velocity",
    "most_velocities": "the most isolated velocities of one problem",
}
STUDY = Study(
    name="convexity",
    question="Is the solution set convex?",
    method="""All solutions of planar problems of up to five contacts are listed, mode by mode, as polyhedra. Their union is
    not convex if the middle of two solutions is none, by the verifier's residual. The jam's solutions are also written down
    in closed form and their middles measured by the gap z'w of the LCP. A block on two corners takes random velocities over a
    grid of friction and height over width. How often it matters: problems spread over the seven examples, simulated,
    and the recorded steps.""",
    tables=(
        Table(
            scenes,
            {
                "scene": "scene or instance",
                "parameters": "its settings, JSON",
                "contacts": "number of contacts",
                "impulses": "shape of the set of impulses",
                "velocities": "shape of the set of contact velocities",
                "pointed": "whether the friction cone is pointed",
                "p0": "whether the LCP has a P0 matrix",
            },
        ),
        Table(
            jam,
            {
                "share": "normal impulse over the least one that stops the disc",
                "normal": "normal impulse on each wall, N s",
                "velocity": "of the disc afterwards, m/s",
                "residual": "of this solution",
                "middle_residual": "of the middle of this solution and of no impulse",
                "middle_gap": "z'w of that middle over m V^2, V the free velocity",
            },
        ),
        Table(
            block,
            {
                "friction": "mu",
                "aspect": "height over width",
                "p0": "whether the LCP has a P0 matrix",
                "draws": "free velocities",
                **TALLY,
            },
        ),
        Table(
            motions,
            {
                "source": "motion",
                "problems": f"problems with one to {MOST} contacts",
                "listed": "those whose solutions are listed",
                **TALLY,
            },
        ),
    ),
)
