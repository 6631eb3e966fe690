"""Maximum dissipation with several contacts: all solutions ranked by kinetic energy, and which solver returns which."""

from collections.abc import Iterable, Iterator

import numpy as np
from scipy.optimize import lsq_linear

from frictionbench.harness.plans.suites import EXACT, OTHERS
from frictionbench.harness.studies.study import Study, Table
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.check import Array
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import first_problem
from frictionbench.results.store import Row
from frictionbench.solvers import solve

SOLVERS = tuple(name for name in (*EXACT, *OTHERS) if name not in ("apgd", "admm", "hybrid"))  # of the exact law
CORNERS = ((1.0, 2.5), (1.0, 3.5), (2.0, 2.5), (2.0, 3.5))  # (height over width, mu) of a block
SAME = 1e-6  # velocities closer than this, over the free one, are one solution's


def ambiguous(draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3)) -> Iterator[tuple[str, FrictionProblem]]:
    """Problems with several isolated solutions: thrown blocks, and Painlevé's rod whose tip lifts."""
    for aspect, friction in CORNERS:
        block = first_problem(scene("two_corner_block", aspect=aspect, friction=friction))
        draw, root = np.random.default_rng(1), np.sqrt(block.mass.diagonal())
        for _ in range(draws):
            thrown = block.replace(free_velocity=draw.normal(size=3) / root)
            if (census(thrown).velocity_count or 1) > 1:
                yield "block", thrown
    for angle in angles:
        for friction in (1.6, 2.2, 3.0):
            rod = first_problem(scene("painleve_rod", angle=angle, friction=friction, lift=0.002, step=1e-4))
            if (census(rod).velocity_count or 1) > 1:
                yield "rod", rod


def solutions(draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3)) -> Iterator[Row]:
    """Every solution of every such problem, the one of least energy first.

    least: the energy that friction impulses within the cones of the solution's own normal impulses can reach at least, by
    bounded least squares; the principle holds for all contacts together where it equals the solution's own.
    """
    for number, (kind, problem) in enumerate(ambiguous(draws, angles)):
        found = [piece.vertices.mean(axis=0).reshape(-1, 2) for piece in census(problem).pieces]
        energies = [energy(problem, problem.velocity(impulse)) for impulse in found]
        at_first = energy(problem, problem.free_velocity)
        for rank, k in enumerate(np.argsort(energies), start=1):
            yield {
                "number": number,
                "kind": kind,
                "contacts": problem.contacts,
                "rank": rank,
                "of": len(found),
                "energy": energies[k] / at_first,
                "least": most_dissipated(problem, found[k][:, 0]) / at_first,
                "residual": residual(problem, found[k]),
            }


def most_dissipated(problem: FrictionProblem, normal: Array) -> float:
    """The least kinetic energy, J, after friction impulses |r_t| <= mu r_n beside these normal impulses (nc,)."""
    root = np.sqrt(problem.mass.diagonal())  # bodies in the plane: a diagonal matrix
    limit = problem.friction * normal + 1e-12
    pushed = root * problem.free_velocity + problem.normal.T @ normal / root
    result = lsq_linear((problem.tangent.toarray() / root).T, -pushed, (-limit, limit), tol=1e-14)
    return float(result.cost)


def returned(
    draws: int = 120, angles: Iterable[float] = (1.0, 1.1, 1.2, 1.3), solvers: Iterable[str] = SOLVERS
) -> Iterator[Row]:
    """Which solution each solver returns, by its rank; null where its answer is none."""
    for number, (kind, problem) in enumerate(ambiguous(draws, angles)):
        known = [problem.velocity(piece.vertices.mean(axis=0)) for piece in census(problem).pieces]
        known.sort(key=lambda v: energy(problem, v))
        for solver in solvers:
            answer = solve(problem, solver, tol=1e-9)
            v = problem.velocity(answer.impulse)
            away = [np.sqrt(energy(problem, v - w) / energy(problem, problem.free_velocity)) for w in known]
            solved = residual(problem, answer.impulse) <= 1e-8 and min(away) <= SAME
            yield {
                "number": number,
                "kind": kind,
                "of": len(known),
                "solver": solver,
                "rank": int(np.argmin(away)) + 1 if solved else None,
            }


def energy(problem: FrictionProblem, v: Array) -> float:
    """The kinetic energy, J, of velocities (nv,)."""
    return float(v @ (problem.mass @ v)) / 2


STUDY = Study(
    name="dissipation",
    question="Does maximum dissipation select a solution where several contacts have several?",
    method="""Random throws of a block on two corners, and Painlevé's rod as its tip lifts, are kept where the census finds
    several isolated solutions. The solutions are ranked by the kinetic energy that they leave. For the normal impulses of each
    solution, bounded least squares finds the least energy that friction within the cones of all contacts together can leave,
    a test of the principle by a second method. Every exact solver then solves the same problems to 1e-9 from its own default
    start.""",
    tables=(
        Table(
            solutions,
            {
                "number": "of the problem",
                "kind": "block or rod",
                "contacts": "number of contacts",
                "rank": "of the solution by its kinetic energy, 1 the least",
                "of": "number of solutions",
                "energy": "kinetic energy it leaves over that of the free motion",
                "least": "least energy with its normal impulses and any friction within the cones, over the same",
                "residual": "of the solution",
            },
        ),
        Table(
            returned,
            {
                "number": "of the problem",
                "kind": "block or rod",
                "of": "number of solutions",
                "solver": "exact solver",
                "rank": "of the solution that it returns, null where its answer is none to 1e-8",
            },
        ),
    ),
)
