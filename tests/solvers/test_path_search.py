"""Path search: its starts and its factors."""

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.solvers import solve
from tests.helpers.friction_problems import assert_solved


def test_random_problems_of_varied_size() -> None:
    for seed in range(300, 350):
        assert_solved(random_problem(seed, contacts=1 + seed % 25), "path_search[crash=0]")


def test_crash_start_shortens_path() -> None:
    problems = [random_problem(seed, contacts=30) for seed in range(20)]
    pivots = [sum(solve(p, spec).work["pivots"] for p in problems) for spec in ("path_search", "path_search[crash=0]")]
    assert pivots[0] < 0.95 * pivots[1]


def test_small_pivots_of_long_stacks_are_taken_without_new_factors() -> None:
    work = assert_solved(scene("stack", blocks=600, push=1.0).problem(), "path_search").work
    assert work["factorisations"] < work["pivots"] / 60
