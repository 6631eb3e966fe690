"""Idle problems: those whose answer without friction satisfies Coulomb's law."""

import numpy as np
import pytest

from frictionbench.harness.cells.reference import Reference
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.analysis.mode import distance_to_next_mode, mode
from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.subproblems import side_by_side
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, contacts_of, known_by_W
from tests.helpers.frictionless import friction_at_work


def _solve(problem):
    return solve(problem, "hybrid", tol=1e-12).impulse


def test_in_space_and_given_by_the_delassus_matrix():
    for push in (0.0, 1.0):
        cubes = make_instance("cubes", boxes=2, push=push)
        assert idle(cubes, _solve) == idle(known_by_W(cubes), _solve) == (push == 0)


@pytest.mark.parametrize("seed", range(30))
def test_found_wherever_an_independent_search_finds_it(seed):
    """One or two bodies, contacts of which many are multiples of others, rough, smooth, at rest, sliding and opening."""
    draw = np.random.default_rng(seed)
    nv, nc = int(draw.integers(2, 5)), int(draw.integers(2, 7))
    mass = np.diag(draw.uniform(0.5, 2.0, nv))
    normal = draw.normal(size=(2, nv))[draw.integers(0, 2, nc)] * draw.uniform(0.5, 2.0, (nc, 1))
    tangent = draw.normal(size=(2 * nc, nv)) * np.repeat(draw.random(nc) < 0.5, 2)[:, None]
    problem = contacts_of(normal, tangent, draw.choice([0.0, 0.5, 3.0], nc), draw.normal(size=nv), mass=mass)
    assert idle(problem, Reference()) == (not friction_at_work(problem))


def test_a_slow_part_beside_a_fast_one_has_its_own_modes():
    slow = block(speed=1.0, friction=0.1).replace(free_velocity=[1e-7, -1e-7])
    fast = block(speed=1e3)
    problem = side_by_side(slow, fast)
    assert mode(problem, _solve(problem)) == "rr"
    alone = min(distance_to_next_mode(part, _solve(part)) for part in (slow, fast))
    assert distance_to_next_mode(problem, _solve(problem)) == pytest.approx(alone, rel=1e-6)
    assert not idle(problem, _solve)
