"""Contacts on bodies fixed by joints: the round-off left in W does not affect the results."""

import numpy as np
import pytest

from frictionbench.problems.residual import residual
from frictionbench.problems.verify import verify
from frictionbench.solvers import Answer, Status, solve
from tests.helpers.friction_problems import contacts_of


def held(seed, gap=1.0):
    """A body held by four joints where three would do, with one contact on it, open by `gap` m/s, and a free sliding mass."""
    random = np.random.default_rng(seed)
    joints = np.zeros((4, 5))
    joints[:, :3] = random.standard_normal((4, 3))
    normal, tangent = np.zeros((2, 5)), np.zeros((2, 5))
    normal[0, :3], tangent[0, :3] = random.standard_normal((2, 3))
    normal[1, 3] = tangent[1, 4] = 1.0
    mass = np.diag([*10 ** random.uniform(-2, 2, 3), 2.0, 2.0])
    free = np.array([0.0, 0.0, 0.0, -1.0, 3.0])
    return contacts_of(normal, tangent, 0.5, free, mass=mass, bias=[gap, 0.0], joints=joints)


@pytest.mark.parametrize("seed", range(12))
def test_force_on_open_locked_contact(seed):
    problem = held(seed)
    exact = solve(problem, "lemke", tol=1e-12).impulse
    assert residual(problem, exact) <= 1e-12
    for size in (1e-3, 1.0, 1e3):
        pushed = exact + np.array([[size, 0.0], [0.0, 0.0]])
        assert residual(problem, pushed) > min(1.0, size) * 1e-3
        assert verify(problem, Answer(pushed, Status.SOLVED), "lcp", 1e-8).verdict == "wrong"
    assert not problem.W[[0, 1]].toarray().any()
    assert not problem.W[:, [0, 1]].toarray().any()


@pytest.mark.parametrize("seed", range(12))
def test_force_on_closed_locked_contact(seed):
    problem = held(seed, gap=0.0)
    exact = solve(problem, "lemke", tol=1e-12).impulse
    pushed = exact.copy()
    pushed[0] = 5.0, -2.0
    assert residual(problem, pushed) <= 1e-12
    assert np.array_equal(problem.contact_velocity(pushed)[0], problem.q[:2])
    pushed[0] = 5.0, -2.6  # out of the cone
    assert residual(problem, pushed) > 1e-3
