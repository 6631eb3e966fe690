"""Newton's method on dense rows, the first of hybrid's methods for few contacts in space."""

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import residual_with_floor
from frictionbench.problems.subproblems import side_by_side
from frictionbench.solvers.dense.few_contacts import few_contacts, few_steps


def robot(seed: int, joints: int = 2) -> FrictionProblem:
    """Ten velocities with a dense mass matrix, of which the last four are locked by redundant equations: contacts with and
    without friction, one that the equations lock, one in a plane, a limit and dry friction. With a single joint, a very light
    body is welded to another instead."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(10, 10))
    normal, tangent = rng.normal(size=(6, 10)), rng.normal(size=(6, 2, 10))
    normal[:, 6:], tangent[:, :, 6:] = 0.0, 0.0
    normal[1], tangent[1] = np.eye(10)[7], np.eye(10)[8:]  # locked
    tangent[2, 1] = 0.0  # in a plane
    normal[3], tangent[3] = np.eye(10)[0], 0.0  # a limit
    normal[4], tangent[4], tangent[4, 0, 1] = 0.0, 0.0, 1.0  # dry friction
    F = np.eye(10)[6:]
    law = {"friction": np.array([0.5, 0.3, 0.7, 0.0, 0.0, 0.0]), "friction_bias": np.array([0.0, 0.0, 0.0, 0.0, 0.05, 0.0])}
    held = {"joints": np.vstack([F, F.sum(axis=0)]), "joint_bias": np.zeros(5)} if joints else {}
    mass = np.diag(rng.uniform(1, 3, 10)) if joints else A @ A.T + np.eye(10)  # with another, contact 1 is not locked exactly
    if joints == 1:
        held, mass[0, 0] = {"joints": np.eye(10)[:1] - np.eye(10)[5:6]}, 1e-11
    rows = {"normal": normal, "tangent": tangent.reshape(12, 10), "bias": np.array([0.0, 0.0, 0.1, 0.0, 1.0, -0.1])}
    return FrictionProblem(mass=mass, free_velocity=rng.normal(size=10), dimension=3, **rows, **law, **held)


@pytest.mark.parametrize("joints", [0, 1, 2])
@pytest.mark.parametrize("seed", range(6))
def test_the_residual_is_the_verifiers(seed: int, joints: int) -> None:
    """Of impulses that are no solution, also where joints lock a contact: scale, units, velocities and floor are the same."""
    problem = robot(seed, joints)
    guess = np.random.default_rng(seed).uniform(0, 1, (6, 3))
    impulse, found, floor, counts = few_contacts(problem, 1e300, few_steps(problem), guess)
    assert counts["steps"] == 0
    assert (found, floor) == pytest.approx(residual_with_floor(problem, impulse), rel=1e-9)


@pytest.mark.parametrize("joints", [0, 2])
@pytest.mark.parametrize("seed", [0, 1, 2, 4, 5, 6])  # of 3 no method finds a solution
def test_contacts_limits_and_dry_friction_are_solved(seed: int, joints: int) -> None:
    problem = robot(seed, joints)
    cold = fb.solve(problem, "hybrid")
    assert cold.status is fb.Status.SOLVED
    assert cold.work["members"] == 1
    assert fb.residual(problem, cold.impulse) <= 1e-8
    warm = fb.solve(problem, "hybrid", tol=1e-7, start=cold.impulse)
    assert warm.work == {"newton sweeps": 0, "newton steps": 0, "members": 1}


@pytest.mark.parametrize("skew", [0.0, 0.05])
def test_w_alone_is_enough_and_may_be_unsymmetric(skew: float) -> None:
    problem, S = robot(1, 0), np.random.default_rng(1).normal(size=(18, 18))
    moves = problem.W.diagonal() > 0
    W = problem.W.toarray() + skew * (S - S.T) * np.outer(moves, moves)
    known = FrictionProblem.from_delassus(W, problem.q, problem.friction, 3, problem.friction_bias)
    answer = fb.solve(known, "hybrid")
    assert answer.work["members"] == 1
    assert fb.residual(known, answer.impulse) <= 1e-8
    np.testing.assert_array_equal(fb.solve_many([known], "hybrid")[0], answer.impulse)


def test_without_friction_tangents_are_left_out() -> None:
    """Their impulses are zero, also from a start that has some."""
    problem = robot(3, 0).replace(friction=np.zeros(6), friction_bias=np.zeros(6))
    impulse = fb.solve(problem, "hybrid", start=np.ones((6, 3))).impulse
    assert fb.residual(problem, impulse) <= 1e-8
    assert not impulse[:, 1:].any()


def test_islands_of_unlike_speeds_are_solved_together() -> None:
    """Two robots side by side, one a million times slower."""
    one = robot(1, 0)
    slow = one.replace(free_velocity=1e-6 * one.free_velocity, bias=1e-6 * one.bias, friction_bias=1e-6 * one.friction_bias)
    problem = side_by_side(one, slow)
    assert problem.spread > 1e5
    answer = fb.solve(problem, "hybrid")
    assert answer.work["members"] == 1
    assert fb.residual(problem, answer.impulse) <= 1e-8


@pytest.mark.parametrize("case", ["dog-settle-244", "fetch_slide-hit-014", "hand_block-grasp-409", "rodent-fall-124"])
def test_redundant_contacts_of_robots_are_solved_by_careful_steps(case: str) -> None:
    """Full steps alone go round in circles among active sets."""
    problem = fb.problem("robot_step", case=case)
    answer = fb.solve(problem, "hybrid")
    assert answer.work["members"] == 1
    assert answer.work["newton steps"] > 6
    assert fb.residual(problem, answer.impulse) <= 1e-8
