"""Distances of velocities, and answers refined to rounding: the same outcome as before, or none."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.harness.contract.check import permuted
from frictionbench.problems.analysis.outcomes import REFINED_RESIDUAL, refined, velocity_distance
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual, residual_floor
from frictionbench.problems.subproblems import side_by_side
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, known_by_W, nothing, spatial


def test_distance_of_a_sliding_block_from_the_same_with_less_friction() -> None:
    """2 kg falls at q_n and slides: impulses (m |q_n|, -mu m |q_n|) change its velocity by |q_n| sqrt(1 + mu^2)."""
    problem = block(speed=1.0)
    exact = solve(problem, "lemke").impulse
    less = exact * [1.0, 0.8]
    expected = 0.2 * 0.5 / np.sqrt(1 + 0.5**2)
    assert velocity_distance(problem, less, exact) == pytest.approx(expected, rel=1e-12)
    alone = known_by_W(problem)
    assert velocity_distance(alone, less, exact) == pytest.approx(expected, rel=1e-12)
    assert velocity_distance(problem, exact[:0], exact) is None
    assert velocity_distance(nothing(), np.zeros((0, 2)), np.zeros((0, 2))) is None


def test_distance_does_not_see_how_impulses_are_distributed() -> None:
    """A block on twice the same contact."""
    one = block(speed=0.0)
    twice = permuted(one, np.array([0, 0]))
    share = solve(one, "lemke").impulse
    assert velocity_distance(twice, np.vstack([share, 0 * share]), np.vstack([0.3 * share, 0.7 * share])) < 1e-15


@pytest.mark.parametrize("seed", range(6))
def test_refined_answers_stay_near_and_reach_rounding(seed) -> None:
    problems = [
        random_problem(seed, contacts=8),
        spatial(seed, contacts=8, friction_bias=True),
        spatial(seed, contacts=8, nv=24, joints=2),
        fb.scene("pyramid", rows=4, push=1.0 + 0.1 * seed).problem(),
    ]
    for problem in (*problems, side_by_side(problems[0], problems[3])):
        rough = solve(problem, "interior_point", tol=1e-5).impulse
        finest = refined(problem, rough)
        assert residual(problem, finest) <= max(REFINED_RESIDUAL, residual_floor(problem, finest))
        assert velocity_distance(problem, rough, finest) < 1e-3


def test_two_motions_of_the_jam_stay_apart() -> None:
    """Normal impulses of V/(2 mu) on both walls stop the disc, none let it pass with V; rounding is no outcome."""
    problem = fb.scene("jam").problem()
    passing, stopped = np.zeros((2, 2)), problem.velocity_scale * np.array([[1.0, 0.5], [1.0, -0.5]])
    assert velocity_distance(problem, refined(problem, passing), refined(problem, stopped)) == pytest.approx(1.0)
    assert velocity_distance(problem, stopped, passing + 1e-16) is None


def test_what_is_no_answer_is_not_refined() -> None:
    problem = block(speed=0.0, joints=[[0.0, 1.0]], joint_bias=[1.0])  # a joint pushes it into the ground
    assert refined(problem, np.zeros((1, 2))) is None
    assert refined(block(), np.full((1, 2), np.nan)) is None
