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


def welded(heavy, links):
    """A plate of 1 g between two heavy bodies, welded to them, stands over the floor; 10 t fall on them; beside it a chain."""
    nv = 8 + 2 * (links + 1)
    joints = np.zeros((4 + 2 * links, nv))
    ends = [(0, 2), (2, 4), (1, 3), (3, 5), *((8 + k, 10 + k) for k in range(2 * links))]
    for row, (i, j) in zip(joints, ends, strict=True):
        row[i], row[j] = 1.0, -1.0
    normal, tangent = np.zeros((2, nv)), np.zeros((2, nv))
    normal[0, 2] = tangent[0, 3] = normal[1, 6] = tangent[1, 7] = 1.0
    normal[1, 4] = tangent[1, 5] = -1.0
    mass = np.diag([heavy, heavy, 1e-3, 1e-3, heavy, heavy, 1e4, 1e4, *np.ones(nv - 8)])
    return contacts_of(normal, tangent, 0.3, [0.5, 0.0] * 3 + [-10.0, 0.0] + [0.0] * (nv - 8), mass=mass, joints=joints)


@pytest.mark.parametrize("links", [0, 60])  # by a dense inverse and by the factors of a band
@pytest.mark.parametrize("heavy", [3e2, 3e3, 1e4])
def test_a_light_plate_welded_between_heavy_bodies_moves(heavy, links):
    problem, whole = welded(heavy, links), 2 * heavy + 1e-3
    assert problem.W[0, 0] == pytest.approx(1 / whole, rel=1e-6)
    supported = np.array([[1e5 - whole / 2, 0.0], [1e5, 0.0]])
    through = np.array([[0.0, 0.0], [10.5 / (1 / whole + 1e-4), 0.0]])
    assert verify(problem, Answer(supported, Status.SOLVED), "lcp", 1e-6).verdict == "solved"
    assert verify(problem, Answer(through, Status.SOLVED), "lcp", 1e-6).verdict == "wrong"
