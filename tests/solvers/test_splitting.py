"""The splitting methods: their claims are correct and they converge at the rates known for one contact."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.solvers import Status, solve
from frictionbench.solvers.sweeps.stopping import monitor, should_continue
from tests.helpers.friction_problems import spatial

COULOMB = ["admm_coulomb", "anitescu_hart", "apgd_coulomb", "nncg", "nsgs", "staggered"]
RELAXED = ["admm", "apgd"]
ALL = COULOMB + RELAXED


@pytest.mark.parametrize("spec", ALL)
def test_claims_are_correct(spec) -> None:
    problems = [random_problem(seed, contacts=(2, 10, 30)[seed % 3]) for seed in range(12)]
    problems += [spatial(seed, contacts=6, friction_bias=seed % 2 == 0, joints=seed % 3) for seed in range(6)]
    solved = 0
    for problem in problems:
        answer = solve(problem, spec, tol=1e-7)
        assert answer.status in (Status.SOLVED, Status.STALLED, Status.WORK_LIMIT)
        if answer.status is Status.SOLVED:
            solved += 1
            assert (relaxation_residual if spec in RELAXED else residual)(problem, answer.impulse) <= 1e-7 * (1 + 1e-6)
    assert solved >= (len(problems) if spec in RELAXED else 0.75 * len(problems))


def test_a_residual_that_is_not_finite_is_a_breakdown() -> None:
    watched = monitor(tol=1e-8, limit=10, patience=5)
    assert should_continue(watched, 1.0, 0)
    assert not should_continue(watched, np.nan, 1)
    assert watched.answer(np.zeros((1, 2))).status is Status.BREAKDOWN


def test_conjugate_directions_save_sweeps() -> None:
    problem = scene("stack", blocks=5, push=0.0).problem()
    plain, conjugate = (solve(problem, spec) for spec in ("nsgs", "nncg"))
    assert plain.status is conjugate.status is Status.SOLVED
    assert conjugate.work["sweeps"] < plain.work["sweeps"] / 3


@pytest.mark.parametrize("spec", ["apgd_coulomb", "admm_coulomb", "staggered"])
def test_stack_stalls(spec) -> None:
    problem = scene("stack", blocks=20, push=0.0).problem()
    assert solve(problem, "nsgs").status is not Status.SOLVED
    assert solve(problem, spec).status is Status.SOLVED


def test_slow_stack_is_not_stalled() -> None:
    # The residual stays at 1.3e-8 for three thousand iterations before it falls on.
    problem = scene("stack", blocks=50, push=0.3).problem()
    answer = solve(problem, "apgd")
    assert answer.status is Status.SOLVED
    assert relaxation_residual(problem, answer.impulse) <= 1e-8
