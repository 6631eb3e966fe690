"""Defects and violations: zero at solutions, each about its own part of the law, the defects without units."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances import make_instance
from frictionbench.problems.measures import defects, judged, penetration, violations
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.recorded.own import EngineStep
from frictionbench.problems.residual import residual
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, contacts_of, nothing, spatial


@pytest.mark.parametrize(
    "problem",
    [random_problem(1, contacts=5), spatial(2, friction_bias=True), make_instance("cubes", boxes=2, push=1.0)],
    ids=["planar", "biased", "cubes"],
)
def test_zero_at_solution(problem) -> None:
    found = defects(problem, solve(problem, "interior_point", tol=1e-13).impulse)
    assert max(found) <= 1e-11
    assert max(defects(problem, 1.1 * solve(problem, "interior_point").impulse)) > 1e-3


def test_single_violations() -> None:
    """A block of 2 kg sliding at 1 m/s: r = (.1962, -.0981) by hand. No friction at all, or half a weight."""
    problem = block(speed=1.0, friction=0.5, mass=2.0)
    right = np.array([[0.1962, -0.0981]])
    assert max(defects(problem, right)) < 1e-15
    frictionless = defects(problem, right * [1, 0])
    assert frictionless.signorini < 1e-15
    assert frictionless.dissipation == pytest.approx(0.5)
    light = defects(problem, right / 2)
    assert light.signorini == pytest.approx(0.5)
    assert light.dissipation < 1e-15
    assert defects(problem, np.array([[0.1962, 0.0981]])).ncp > 0.05  # pushes along
    assert defects(problem, np.array([[-0.1, 0.0]])).ncp > 0.05  # pulls


def test_unit_invariance_and_infinite_values() -> None:
    problem, r = random_problem(4, contacts=4), np.random.default_rng(0).standard_normal((4, 2))
    heavy = problem.replace(mass=1000 * problem.mass, free_velocity=3 * problem.free_velocity, bias=3 * problem.bias)
    assert defects(heavy, 3000 * r) == pytest.approx(defects(problem, r), rel=1e-9)
    assert set(defects(problem, r * np.nan)) == {np.inf}
    assert set(defects(problem, r[:2])) == {np.inf}
    assert defects(nothing(), np.zeros((0, 2))) == (0, 0, 0)


def test_defects_bound_residual() -> None:
    """Coulomb's law is Signorini's and the dissipation's together: where both are small, so is the residual."""
    for seed in range(20):
        problem: FrictionProblem = spatial(seed, contacts=4, friction=0.5)
        r = solve(problem, "interior_point", tol=1e-12).impulse
        off = r + 1e-6 * np.random.default_rng(seed).standard_normal(r.shape) * np.abs(r).max()
        found = defects(problem, off)
        assert residual(problem, off) <= 10 * (found.signorini + found.dissipation)


H = 0.01


def ball(*velocity: float, gap: float = 0.0) -> FrictionProblem:
    """A point of 1 kg on a floor of friction 0.5; velocities normal first."""
    rows = np.eye(3)
    return contacts_of(rows[:1], rows[1:], 0.5, velocity, mass=rows, bias=[gap / H])


@pytest.mark.parametrize(
    ("velocity", "impulse", "expected"),
    [
        ((-1.0, 3.0, 0.0), (1.0, -0.5, 0.0), (0, 0, 0, 0)),  # slides, exactly
        ((-1.0, 0.3, 0.0), (1.0, -0.3, 0.0), (0, 0, 0, 0)),  # sticks, exactly
        ((-1.0, 3.0, 0.0), (0.9, -0.45, 0.0), (0.1, 0, 0, 0)),  # still approaches
        ((1.0, 3.0, 0.0), (0.5, -0.25, 0.0), (0.5, 0, 0, 0)),  # pulled down or pushed while open
        ((-1.0, 3.0, 0.0), (1.0, -0.7, 0.0), (0, 0.2, 0, 0)),  # friction of 0.7 in a cone of 0.5
        ((-1.0, 0.3, 0.0), (1.0, -0.28, 0.0), (0, 0, 0, 0.02)),  # creeps at 0.02 m/s inside the cone
        ((-1.0, 3e9, 0.0), (1.0, 0.0, -0.5), (0, 0, 0.5, 0.5)),  # friction across the slip
    ],
)
def test_each_law(velocity, impulse, expected) -> None:
    found = violations(ball(*velocity), np.array([impulse]))
    assert np.array(found).ravel() == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize(
    ("speed", "violated"),
    [(0.0, 0.0), (0.4, 0.0), (1.0, 0.0), (1.2, 0.2), (-0.3, 0.3)],  # m/s out of a penetration of 1 m/s times the step
)
def test_penetration_may_be_left_but_not_deepened(speed, violated) -> None:
    step = EngineStep(ball(-2.0, 0.0, 0.0, gap=-H), [[2.0 + speed, 0.0, 0.0]], step=H)
    assert penetration(step) == pytest.approx(H)
    assert violations(judged(step), step.impulse).signorini == pytest.approx([violated], abs=1e-12)
    unknown = EngineStep(step.problem, step.impulse)
    assert judged(unknown) is step.problem
    assert penetration(unknown) is None
