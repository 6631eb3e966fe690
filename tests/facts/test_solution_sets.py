"""Number and shape of the solutions of friction problems; convexity of the set is the talk's open problem (page 31)."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.analysis.labels import pointedness
from frictionbench.problems.analysis.polyhedra import Shape
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, solve
from tests.helpers.friction_problems import contacts_of


def jam(mu=0.5, bias=(0.0, 0.0)) -> FrictionProblem:
    """A particle between two walls that face each other, moving along them."""
    return contacts_of([[1, 0], [-1, 0]], [[0, 1], [0, 1]], mu, [0, 1], bias=bias)


def wedge(angle, mu) -> FrictionProblem:
    """A particle pressed into a wedge of two walls, each at `angle` from its axis."""
    normal = np.array([[np.cos(angle), np.sin(angle)], [-np.cos(angle), np.sin(angle)]])
    return contacts_of(normal, np.column_stack([normal[:, 1], -normal[:, 0]]), mu, [0, -1])


def on_arc(t, mu) -> np.ndarray:
    """The solution at t in [0, 1]: both walls press with t/(2 mu), and the velocity left is 1 - t."""
    return np.array([[t / (2 * mu), -t / 2]] * 2)


@pytest.mark.parametrize("mu", [0.1, 0.5, 2.0])
def test_jam_solutions_are_arc_and_ray(mu) -> None:
    problem = jam(mu)
    for t in np.linspace(0, 1, 5):
        assert residual(problem, on_arc(t, mu)) <= 1e-15
        assert problem.velocity(on_arc(t, mu)) == pytest.approx([0, 1 - t])
    beyond = on_arc(1, mu)
    beyond[:, 0] += 3
    assert residual(problem, beyond) <= 1e-15

    found = census(problem)
    assert found.shape is Shape.NOT_CONVEX
    arc, ray = (next(p for p in found.pieces if p.mode == mode) for mode in ("rr", "ss"))
    ends = np.array([on_arc(0, mu).ravel(), on_arc(1, mu).ravel()])
    assert sorted(arc.vertices.tolist()) == pytest.approx(np.array(sorted(ends.tolist())), abs=1e-12)
    assert len(arc.rays) == 0
    assert ray.vertices == pytest.approx(ends[1:])
    assert len(ray.rays) == 2
    assert found.velocity_count is None


def test_jam_overlap_solvability() -> None:
    for bias, solvable in (((-0.1, -0.1), False), ((-0.1, 0.1), True), ((0.1, 0.1), True)):
        problem = jam(bias=bias)
        assert (census(problem).shape is not Shape.NONE) is solvable
        answer = solve(problem, "lemke", tol=1e-10)
        assert answer.status is (Status.SOLVED if solvable else Status.INFEASIBLE)
        assert (residual(problem, answer.impulse) <= 1e-10) is solvable


def test_pointed_cone_is_solvable() -> None:
    """A ray of Lemke's method needs N c + D beta = 0 with c != 0, so where the friction cone is pointed it solves these random
    problems with negative bias. Some of the others have no solution, and one that has may still end on a ray."""
    seen = {True: 0, False: 0}
    for seed in range(80):
        base = random_problem(seed, contacts=1 + seed % 4, bodies=1)
        problem = base.replace(bias=-np.random.default_rng(seed).random(base.contacts))
        pointed = pointedness(problem) < 1e-7
        solvable = census(problem).shape is not Shape.NONE
        if pointed:
            assert solvable
            assert solve(problem, "lemke").status is Status.SOLVED
        seen[solvable] += 1
    assert seen[False] >= 5


@pytest.mark.parametrize("angle", [0.3, 1.0])
@pytest.mark.parametrize("factor", [0.5, 0.99, 1.0, 1.01, 3.0])
def test_wedge_impulses_are_unbounded_above_threshold(angle, factor) -> None:
    """... and the velocity is unique, zero, all the same."""
    found = census(wedge(angle, np.tan(angle) * factor))
    assert any(len(piece.rays) for piece in found.pieces) is (factor >= 1)
    assert found.velocity_count == 1
    assert found.velocities[0].vertices == pytest.approx(np.zeros((1, 4)), abs=1e-10)
