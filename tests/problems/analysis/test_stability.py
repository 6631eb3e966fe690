"""Backward error and sensitivity distinguish an unstable solver from an ill-posed instance."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.stability import backward_error, sensitivity
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, nothing


def lemke(problem):
    return solve(problem, "lemke").impulse


@pytest.mark.parametrize("seed", range(10))
def test_exact_answer_has_zero_backward_error(seed) -> None:
    problem = random_problem(seed, contacts=8)
    assert backward_error(problem, lemke(problem)) < 1e-10


def test_perturbed_data_make_answer_exact() -> None:
    """A sliding block pushed .1 % too hard: u_n = .001 of the fall, to be taken off q_n."""
    problem = block(speed=1.0)
    r = lemke(problem) * 1.001
    u = problem.contact_velocity(r)
    expected = abs(u[0, 0] / problem.q[0])
    assert backward_error(problem, r) == pytest.approx(expected, rel=1e-9)
    mended = FrictionProblem.from_delassus(problem.W, problem.q - [u[0, 0], 0], problem.friction, 2)
    assert backward_error(mended, r) < 1e-14


def test_friction_perturbation() -> None:
    """The answer for mu = .5 is exact for a mu that is 1/.51 - 1 smaller or larger than .51."""
    r = lemke(block(friction=0.5))
    assert backward_error(block(friction=0.51), r) == pytest.approx(0.01 / 0.51, rel=1e-9)


def test_large_backward_error() -> None:
    problem = block()
    assert backward_error(problem, np.array([[0.0, 1.0]])) > 0.1
    assert backward_error(problem, np.array([[np.nan, 0.0]])) == np.inf
    assert backward_error(nothing(), np.zeros((0, 2))) == 0


def test_sensitivity_of_well_and_ill_posed_instances() -> None:
    assert sensitivity(block(), lemke) < 2
    # This contact has three solutions where q_t = -1 and q_n > 0 is small, and one where q_n is large: at q_n = 0 it jumps.
    W = np.array([[1.6, -1.2], [-1.2, 3.4]])
    near = [FrictionProblem.from_delassus(W, [q_n, -1.0], [1.5], 2) for q_n in (1e-9, 0.5)]
    assert sensitivity(near[0], lemke) > 1e3 * sensitivity(near[1], lemke)
    assert sensitivity(nothing(), lemke) == 0


def test_sensitivity_of_a_slow_part_beside_a_fast_one() -> None:
    """As above, where q is changed by 1e-7 of each part's own velocity."""
    ill, well = np.array([[1.6, -1.2], [-1.2, 3.4]]), np.eye(2)
    W = np.block([[well, np.zeros((2, 2))], [np.zeros((2, 2)), ill]])
    whole = FrictionProblem.from_delassus(W, [-1e9, 1e9, 0.5, -1.0], [0.5, 1.5], 2)
    near = FrictionProblem.from_delassus(W, [-1e9, 1e9, 1e-9, -1.0], [0.5, 1.5], 2)
    assert sensitivity(whole, lemke) < 1e2
    assert sensitivity(near, lemke) > 1e4
