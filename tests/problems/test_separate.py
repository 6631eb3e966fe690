"""Tests of problems.subproblems: parts of a problem that nothing connects."""

import numpy as np
import pytest

from frictionbench.harness.contract.check import permuted
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.subproblems import separate, side_by_side
from tests.helpers.friction_problems import known_by_W

PROBLEMS = random_problem(0, 5), scene("chain", links=3).problem(), random_problem(1, 3)


@pytest.fixture(params=[False, True], ids=["mechanics", "Delassus"])
def whole(request) -> FrictionProblem:
    """Three problems as one, their contacts and velocities in random order."""
    apart = side_by_side(*PROBLEMS)
    random = np.random.default_rng(0)
    contact, v = random.permutation(apart.contacts), random.permutation(len(apart.free_velocity))
    rows = permuted(apart, contact)
    mixed = rows.replace(
        mass=apart.mass[v][:, v],
        normal=rows.normal[:, v],
        tangent=rows.tangent[:, v],
        free_velocity=apart.free_velocity[v],
        joints=apart.joints[:, v],
    )
    return known_by_W(mixed) if request.param else mixed


def test_parts_move_as_in_the_whole(whole) -> None:
    impulse = np.random.default_rng(1).random((whole.contacts, 2))
    velocity = whole.contact_velocity(impulse)
    parts = list(separate(whole))
    assert sorted(np.concatenate([contacts for contacts, _ in parts])) == list(range(whole.contacts))
    for contacts, part in parts:
        assert np.allclose(part.contact_velocity(impulse[contacts]), velocity[contacts])
        assert np.array_equal(part.friction, whole.friction[contacts])
    assert len(parts) >= 3
    assert all(len(list(separate(part))) == 1 for _, part in parts)


def test_a_problem_in_one_part_is_itself() -> None:
    problem = scene("stack", blocks=3).problem()
    ((contacts, part),) = separate(problem)
    assert part is problem
    assert np.array_equal(contacts, range(problem.contacts))
