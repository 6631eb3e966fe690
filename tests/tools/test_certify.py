"""Certificates of answers: what is shown to exist, and what is not called so."""

import numpy as np
import pytest

import frictionbench as fb

pytest.importorskip("flint", reason="python-flint is not installed")
from tools.certify import NotCertifiedError, certify  # it needs python-flint


def block(feet=1, speed=1.0, friction=0.5, **more):
    """A block of 2 kg that falls with 0.1 m/s onto so many feet at one point, and slides."""
    rows, mu = np.tile(np.eye(2), (feet, 1)), np.full(feet, friction)
    given = {"mass": 2 * np.eye(2), "free_velocity": [speed, -0.1], "bias": np.zeros(feet), "friction": mu}
    return fb.FrictionProblem(normal=rows[1::2], tangent=rows[::2], **given | more)


@pytest.mark.parametrize("speed", [1.0, 0.01])  # it slides on, and it sticks
def test_the_radius_is_the_error_of_the_answer(speed) -> None:
    """In rationals: r_n = 2 * 0.1 and r_t = -mu r_n, or what stops it."""
    problem = block(speed=speed)
    exact = np.array([[0.2, -min(0.1, 2 * speed)]])
    assert certify(problem, exact) < 1e-15
    assert certify(problem, exact + np.array([[2e-6, 0.0]])) == pytest.approx(1e-6 / 0.1, rel=1e-6)


def test_redundant_feet_have_one_motion() -> None:
    problem = block(feet=3)
    assert certify(problem, np.array([[0.2, -0.1], [0.0, 0.0], [0.0, 0.0]])) < 1e-15


@pytest.mark.parametrize("name", ["stack", "pyramid", "chain", "random_bodies"])  # the last in space
def test_problems_of_scenes_and_instances(name) -> None:
    given = {"stack": {"push": 1.0}, "pyramid": {"rows": 3, "push": 1.0}, "chain": {"links": 3}}
    problem = fb.problem(name, **given.get(name, {"contacts": 8, "seed": 2}))
    assert certify(problem, fb.solve(problem, "hybrid", tol=1e-10).impulse) < 1e-9


def test_friction_that_just_stops_the_block_is_not_certified() -> None:
    with pytest.raises(NotCertifiedError, match="between sticking and sliding"):
        certify(block(free_velocity=[0.0625, -0.125]), np.array([[0.25, -0.125]]))


def test_feet_that_contradict_each_other_by_rounding_are_not_certified() -> None:
    tilted = block(feet=2, friction=0.0).replace(normal=[[0.0, 1.0], [1e-14, 1.0]])
    with pytest.raises(NotCertifiedError, match="but for rounding"):
        certify(tilted, np.array([[0.1, 0.0], [0.1, 0.0]]))
