"""The Coulomb cone itself or a polygon: error and time against the number of facets."""

from collections.abc import Iterable, Iterator

import numpy as np

from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.instances import make_instance
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import simulate
from frictionbench.results.store import Row
from frictionbench.solvers import solve

CONE, TOL = "interior_point", 1e-10
SLIDING = 0.236  # s, until the ball rolls
FACETS = (4, 6, 8, 12, 16, 24, 32, 64)
SPACE = (
    Source("cubes", {"boxes": 2, "friction": 0.2, "push": 0.5, "twist": 2.0, "fall": 1.0}),
    Source("sphere_pyramid", {"levels": 2, "friction": 0.1, "noise": 0.3}),
    Source("random_bodies", {"contacts": 8, "seed": 1}),
    Source("random_bodies", {"contacts": 20}),
    Source("rod_chain", {"links": 4}),
    Source("packed_spheres", {"spheres": 15, "noise": 1.0}),
)


def ball(facets: Iterable[int] = (0, *FACETS), step: float = 0.004, shown: int = 40) -> Iterator[Row]:
    """A sliding ball with a side spin: some points of its path, and its distances from the parabola; 0 facets for the cone."""
    stage = scene("sliding_ball", step=step, duration=SLIDING)
    assert stage.path is not None
    parabola = np.vstack([stage.path(k * step) for k in range(stage.steps + 1)])

    def path(spec: str) -> Array:
        def answer(problem: FrictionProblem) -> Array:
            return solve(problem, spec, tol=1e-9).impulse

        return np.vstack([stage.geometry.centres(now.q) for now in simulate(stage, answer)])

    cone = path(CONE)
    for count in facets:
        found = path(f"lemke[facets={count}]") if count else cone
        pick = np.linspace(0, len(found) - 1, shown).astype(int)
        yield {
            "facets": count,
            "step": step,
            "from_parabola": float(np.linalg.norm(found - parabola, axis=1).max()),
            "from_cone": float(np.linalg.norm(found - cone, axis=1).max()),
            "x": found[pick, 0],
            "y": found[pick, 1],
            "aside": (found - parabola)[pick, :2] @ _across(parabola[:, :2]),
        }


def _across(path: Array) -> Array:
    """The unit vector across the chord of a path in the plane."""
    chord = path[-1] - path[0]
    return np.array([-chord[1], chord[0]]) / np.linalg.norm(chord)


def problems(facets: Iterable[int] = FACETS[:-1], sources: Iterable[Source] = SPACE) -> Iterator[Row]:
    """Spatial problems by the cone and by polygons: the residual of Coulomb's law and the velocities' error.

    A problem may have several solutions; the second is found by refining the finest polygon's answer on the cone.
    """
    for number, source in enumerate(sources):
        problem = make_instance(source.scene, **source.parameters)
        found = {count: solve(problem, f"lemke[facets={count}]", tol=1e-10) for count in facets}
        finest = found[max(found)].impulse
        exact = [solve(problem, CONE, tol=TOL).impulse, solve(problem, "proximal_newton", tol=TOL, start=finest).impulse]
        velocities = [problem.velocity(impulse) for impulse in exact if residual(problem, impulse) <= TOL]
        for count, answer in found.items():
            v = problem.velocity(answer.impulse)
            yield {
                "number": number,
                "scene": source.scene,
                "contacts": problem.contacts,
                "facets": count,
                "unknowns": problem.contacts * (count + 2),
                "residual": residual(problem, answer.impulse),
                "error": min(_apart(problem, v, known) for known in velocities),
                "solutions_apart": _apart(problem, velocities[0], velocities[-1]),
                "pivots": answer.work.get("pivots"),
            }


def _apart(problem: FrictionProblem, v: Array, w: Array) -> float:
    """|v - w| over the free velocity, in the norm of the kinetic energy."""
    free = problem.free_velocity
    return float(np.sqrt((v - w) @ (problem.mass @ (v - w)) / (free @ (problem.mass @ free))))


def plan() -> Plan:
    """The same problems with times."""
    return Plan(
        suite="study cone",
        sources=SPACE,
        solvers=(CONE, "nsgs", *(f"lemke[facets={count}]" for count in FACETS)),
        tolerances=(1e-8,),
        time_limit=10.0,
    )


STUDY = Study(
    name="cone",
    question="The Coulomb cone itself, or a polygon?",
    method="""A ball that slides with a side spin is on a parabola; its path is computed with the circular cone and with
    polygons of 4 to 64 facets, and compared with both. The first problems of six spatial instances are solved with the cone
    to 1e-10 and with the same polygons by Lemke's method: the error is that of the velocity in the norm of the kinetic energy
    over the free velocity, to the nearer of two solutions where the polygon leads to another one. The solver runs time both
    kinds in isolation, each verified as an answer to its own model.""",
    tables=(
        Table(
            ball,
            {
                "facets": "of the polygon, 0 for the cone",
                "step": "s",
                "from_parabola": "largest distance of the path from the parabola, m",
                "from_cone": "largest distance of the path from that with the cone, m",
                "x": "points of the path, m",
                "y": "points of the path, m",
                "aside": "their distance from the parabola across its chord, m",
            },
        ),
        Table(
            problems,
            {
                "number": "of the problem",
                "scene": "instance",
                "contacts": "number of contacts",
                "facets": "of the polygon",
                "unknowns": "of the LCP",
                "residual": "of Coulomb's law",
                "error": "|v - v_cone|_M / |v*|_M to the nearer of the known solutions with the cone",
                "solutions_apart": "the same between these: above 0 there are two",
                "pivots": "of Lemke's method",
            },
        ),
    ),
    plan=plan,
)
