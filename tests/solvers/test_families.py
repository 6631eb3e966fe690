"""Families of problems on which the accurate methods are sure: random ones, exact ties, unlike masses and special values."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.random_bodies import random_problem
from tests.helpers.friction_problems import assert_solved, spatial

PIVOTS = {"lemke": 1e-11, "path_search": 1e-8}
POINTS = dict.fromkeys(("interior_point", "relaxation_ip"), 1e-8)
BOTH = pytest.mark.parametrize(("spec", "tol"), (PIVOTS | POINTS).items())
IN_SPACE = pytest.mark.parametrize("spec", POINTS)


@BOTH
def test_random_problems(spec, tol) -> None:
    """Mu to 10, more contacts than freedoms; b >= 0, so that each has a solution to which Lemke's method leads."""
    answers = [
        assert_solved(random_problem(seed, contacts=1 + seed % 50), spec, tol) for seed in range(100 if spec in PIVOTS else 40)
    ]
    assert sum(answer.work.get("restarts", 0) for answer in answers) <= 2
    for seed in range(50) if spec == "lemke" else ():
        assert_solved(random_problem(seed, contacts=1 + seed, mass_ratio=1e6), spec, 1e-9)


def test_dantzig_solves_little_friction_and_frictionless_contacts_of_any_rank() -> None:
    """The former is a floor under regressions, not a promise."""
    for seed in range(30):
        assert_solved(random_problem(seed, contacts=1 + seed, friction=0.0), "dantzig", 1e-12)
        assert_solved(random_problem(seed, contacts=1 + seed % 20, friction=0.2), "dantzig")


@BOTH
@pytest.mark.parametrize("mu", [0.0, 0.05, 0.5, 10.0])
def test_stacks_and_pyramids_with_exact_ties(mu, spec, tol) -> None:
    for push in (0.0, 0.3):
        for blocks in (1, 4, 50):
            assert_solved(scene("stack", blocks=blocks, friction=mu, push=push).problem(), spec, tol)
        assert_solved(scene("pyramid", rows=6, friction=mu, push=push).problem(), spec, tol)


@BOTH
@pytest.mark.parametrize("ratio", [1e-6, 1e3, 1e6])
def test_mass_ratios(ratio, spec, tol) -> None:
    """Impulses have sixteen digits, so that what a light body feels under heavy ones is known to 1e-16 times the ratio."""
    for blocks, mu in ((2, 0.05), (5, 2.0), (25, 1.0)):
        problem = scene("stack", blocks=blocks, mass_ratio=ratio, push=0.1, friction=mu).problem()
        assert_solved(problem, spec, max(tol, 1e-14 * ratio))


@IN_SPACE
@pytest.mark.parametrize("friction", [0.1, 3.0])
@pytest.mark.parametrize(("contacts", "nv"), [(1, 6), (8, 18), (20, 60)])
def test_random_problems_in_space(contacts, nv, friction, spec) -> None:
    for seed in range(3):
        assert_solved(spatial(seed, contacts, nv, friction), spec)
        assert_solved(spatial(seed, contacts, nv, friction, friction_bias=True, joints=seed), spec)


@IN_SPACE
@pytest.mark.parametrize("push", [0.0, 1.0])
@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_stacks_of_cubes_with_exact_ties(friction, push, spec) -> None:
    assert_solved(cubes(30, friction=friction, push=push), spec, tol=1e-9)
    assert_solved(cubes(10, friction=friction, push=push, mass_ratio=1e4), spec)


@IN_SPACE
@pytest.mark.parametrize("known", [scene("pyramid", rows=4).problem(), spatial(4, contacts=6, nv=24)], ids=["plane", "space"])
def test_special_values(known, spec) -> None:
    nc, nv = known.contacts, len(known.free_velocity)
    mixed, root = known.friction * (np.arange(nc) % 2), np.random.default_rng(0).standard_normal((nv, nv))
    for changes in (
        {"friction": np.zeros(nc)},
        {"friction": mixed},
        {"friction": mixed, "friction_bias": np.full(nc, 0.1)},
        {"friction": np.full(nc, 1e-9)},
        {"friction": np.full(nc, 50.0)},
        {"free_velocity": np.zeros(nv), "bias": np.zeros(nc)},
        {"bias": np.full(nc, 1e3)},
        {"mass": known.mass * 1e9},
        {"mass": known.mass * np.tile([1.0, 1e6], nv)[:nv]},
        {"mass": root @ root.T + np.eye(nv)},
    ):
        assert_solved(known.replace(**changes), spec)
