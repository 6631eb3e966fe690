"""The convex relaxation by outside libraries: they agree, solve it, and show its known errors."""

import pytest

from frictionbench.problems import InputError
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import relaxation_residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, find, solve

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
