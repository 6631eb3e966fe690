"""Lemke's method: near ties, the floor of rounding, units, and a false ray. Its pivot counts are in tests/facts."""

import numpy as np
import pytest

from frictionbench.problems import LCP
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual_with_floor
from frictionbench.solvers.interface import Status, solve
from tests.helpers.friction_problems import assert_solved


@pytest.mark.parametrize("mu", [0.05, 10.0])
def test_stacks_with_near_ties(mu):
    """Contacts displaced by 1e-9: bases that differ by as little, and are conditioned like 1e9."""
    problem, random = scene("stack", blocks=50, friction=mu, push=0.0).problem(), np.random.default_rng(0)
    moved = {name: getattr(problem, name).copy() for name in ("normal", "tangent")}
    for rows in moved.values():
        rows.data += 1e-9 * random.standard_normal(rows.nnz) * (abs(rows.data) != 1)
    assert_solved(problem.replace(**moved), "lemke", 1e-9)


@pytest.mark.parametrize("ratio", [3e9, 1e11])
def test_heavy_tops_to_the_floor_of_rounding(ratio):
    random = np.random.default_rng(5)
    for n in (2, 4, 7, 18):
        given = {"friction": random.uniform(0.2, 0.8), "push": random.uniform(0.2, 2)}
        problem = scene("stack", blocks=n, mass_ratio=ratio, **given).problem()
        answer = solve(problem, "lemke")
        found, floor = residual_with_floor(problem, answer.impulse)
        assert answer.status is Status.ROUNDING
        assert found <= floor < 1e-3


def test_path_is_unit_invariant():
    lcp = random_problem(11, 20).lcp()
    first, second = solve(LCP(lcp.M, lcp.q), "lemke"), solve(LCP(lcp.M / 1024, lcp.q * 64), "lemke")
    assert first.work == second.work
    np.testing.assert_allclose(second.z, first.z * 65536, rtol=1e-12, atol=1e-12)


def test_ray_of_the_tableau_that_is_none() -> None:
    """The tableau ends at a ray that its certificate does not confirm: the path that is followed instead has its own basis."""
    problem = random_problem(4, contacts=10, friction=10 ** np.random.default_rng(4).uniform(-3, 6))
    answer = solve(problem, "lemke", tol=1e-10)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)
    found, floor = residual_with_floor(problem, answer.impulse)
    assert found <= max(1e-10, floor)
