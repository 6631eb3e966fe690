"""The convex relaxation by outside libraries: they agree, solve it, and show its known errors."""

import numpy as np
import pytest

from frictionbench.problems import InputError
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, find, solve
from tests.helpers.friction_problems import block, spatial, with_joints

ROUND = ["clarabel", *(["scs"] if find("scs")[0].missing is None else [])]
PLANAR = [*ROUND, "proxsuite", "osqp"]


@pytest.mark.parametrize("spec", PLANAR)
@pytest.mark.parametrize("tol", [1e-4, 1e-7])
def test_tolerance_is_met(spec, tol) -> None:
    problems = [
        scene("stack", blocks=n, push=push, mass_ratio=ratio).problem() for n, push, ratio in ((1, 0, 1), (8, 0.3, 100))
    ]
    for problem in problems + [random_problem(seed, contacts=10) for seed in range(6)]:
        answer = solve(problem, spec, tol=tol)
        assert answer.status is Status.SOLVED
        assert relaxation_residual(problem, answer.impulse) <= tol


@pytest.mark.parametrize("spec", ROUND)
@pytest.mark.parametrize("seed", range(4))
def test_round_cones(spec, seed) -> None:
    problem = spatial(seed, friction_bias=seed % 2 == 1, joints=seed % 3)
    answer = solve(problem, spec, tol=1e-6)
    assert answer.status is Status.SOLVED
    assert relaxation_residual(problem, answer.impulse) <= 1e-6


@pytest.mark.parametrize("spec", PLANAR)
def test_all_find_the_same_velocity(spec) -> None:
    problem = with_joints(random_problem(3, contacts=10, bodies=6), np.eye(1, 18), np.linspace(0, 0.5, 10))
    assert problem.friction_bias.any()
    reference = solve(problem, "clarabel", tol=1e-9)
    answer = solve(problem, spec, tol=1e-6)  # proxqp takes it for infeasible where more is asked
    assert relaxation_residual(problem, answer.impulse) <= 1e-6
    assert problem.velocity(answer.impulse) == pytest.approx(problem.velocity(reference.impulse), abs=1e-5)


@pytest.mark.parametrize("spec", PLANAR)
def test_a_sliding_block_hops(spec) -> None:
    m, h, mu, v, g = 2.0, 0.01, 0.6, 1.0, 9.81
    problem = block(speed=v, friction=mu, mass=m, h=h)
    answer = solve(problem, spec, tol=1e-10)
    assert answer.impulse[0, 0] == pytest.approx(m * (g * h + mu * v) / (1 + mu**2), rel=1e-6)
    u_n, u_t = problem.contact_velocity(answer.impulse)[0]
    assert u_t == pytest.approx((v - mu * g * h) / (1 + mu**2), rel=1e-6)
    assert u_n == pytest.approx(mu * u_t, rel=1e-6)
    assert residual(problem, answer.impulse) > 0.1  # the model's error, not the solver's


@pytest.mark.parametrize("spec", PLANAR)
@pytest.mark.parametrize(
    "problem", [block(speed=1.0, friction=0.0), block(speed=0.01), scene("stack", blocks=4, push=0.0).problem()]
)
def test_exact_without_sliding_or_friction(spec, problem) -> None:
    assert residual(problem, solve(problem, spec).impulse) <= 1e-8


@pytest.mark.parametrize("spec", PLANAR)
def test_friction_bias(spec) -> None:
    # The contact opens: the bias alone brakes the block.
    problem = block(speed=1.0, h=-0.01, friction=0.0, friction_bias=[0.3])
    answer = solve(problem, spec, tol=1e-9)
    assert answer.impulse[0] == pytest.approx([0.0, -0.3], abs=1e-7)


@pytest.mark.parametrize("spec", PLANAR)
def test_failed_library_status(spec) -> None:
    answer = solve(scene("stack", blocks=8, push=0.3).problem(), spec, limit=1)
    assert answer.status is Status.FAILED
    assert answer.detail
    assert answer.impulse.shape == (16, 2)


@pytest.mark.parametrize("spec", ["ccp"])
def test_unknown_backend(spec) -> None:
    with pytest.raises(InputError, match=r"it has .*backend=highs"):
        find(f"{spec}[backend=gurobi]")


def test_libraries_print_nothing(capfd) -> None:
    problem = scene("stack", blocks=3, push=0.3).problem()
    for spec in PLANAR:
        solve(problem, spec)
        solve(problem, spec, limit=1)
    assert capfd.readouterr().out == ""
