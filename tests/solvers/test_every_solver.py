"""Requirements on every solver: solved problems, reproducible counters, correct status, unmodified input."""

import sys
from pathlib import Path

import numpy as np
import pytest

from frictionbench import solvers
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.copies import duplicate
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import relaxation_residual, residual, residual_floor
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Answer, Status, available, find, solve
from tests.helpers.friction_problems import block, nothing, spatial, with_joints

TOL = 1e-6
PLANAR = {
    "nothing": nothing(),
    "sliding": block(speed=1.0),
    "sticking": block(speed=0.0),
    "frictionless": block(friction=0.0),
    "biased": block(friction_bias=[0.05]),
    "jointed": with_joints(random_problem(3, contacts=4, bodies=3), joints=np.random.default_rng(3).standard_normal((2, 9))),
    "stack": scene("stack", blocks=3, push=1.0).problem(),
    "rod": scene("painleve_rod").problem(),
    "random": random_problem(7, contacts=6),
    "delassus": FrictionProblem.from_delassus(np.diag([2.0, 1.0]), [-1.0, 1.0], [0.5], 2),
}
SOLVERS = sorted(
    name for name, info in available().items() if not info.needs or name in ("clarabel", "osqp", "proxsuite")
)  # ours


def own_residual(name: str, problem: FrictionProblem, answer: Answer) -> float:
    """The residual of the model that the solver is for."""
    info, _ = find(name)
    if info.model == "relaxation":
        return relaxation_residual(problem, answer.impulse)
    if info.model == "lcp" and problem.dimension == 3:
        return problem.lcp().residual(answer.z)
    return residual(problem, answer.impulse)


def test_solver_facts() -> None:
    modules = {info.make.__module__ for info in available().values()}  # also of plug-ins that other tests loaded
    defining = {Path(sys.modules[name].__file__) for name in modules if name.startswith("frictionbench.")}
    methods = set(Path(solvers.__file__).parent.glob("*.py")) - {Path(solvers.__file__)}
    machinery = {f"{name}.py" for name in ("balanced", "clock", "executable", "interface", "loops", "many", "needs", "plugins")}
    assert {path.name for path in methods - defining} == machinery
    for info in available().values():
        assert info.summary.endswith((".", ")"))
        assert info.model in ("coulomb", "lcp", "relaxation", "regularised")
        assert info.missing is None or info.needs


@pytest.mark.parametrize("problem", PLANAR.values(), ids=PLANAR.keys())
@pytest.mark.parametrize("name", SOLVERS)
def test_a_planar_problem_is_solved(name, problem) -> None:
    info, _ = find(name)
    if 2 not in info.dimension:
        with pytest.raises(InputError, match="dimension"):
            solve(problem, name, tol=TOL)
        return
    before = problem.hash
    first, second = (solve(duplicate(problem), name, tol=TOL) for _ in range(2))
    assert problem.fresh().hash == before
    assert first.impulse.shape == (problem.contacts, 2)
    assert first.status is Status.SOLVED, "each of these has a solution, within reach of every method here"
    assert first.work == second.work
    assert np.array_equal(first.impulse, second.impulse)
    assert all(isinstance(count, int) and count >= 0 for count in first.work.values())
    assert own_residual(name, problem, first) <= TOL


@pytest.mark.parametrize("name", [name for name in SOLVERS if 3 in find(name)[0].dimension])
def test_a_spatial_problem_is_solved(name) -> None:
    problem = spatial(1, contacts=3)
    answer = solve(problem, name, tol=TOL)
    assert answer.impulse.shape == (3, 3)
    assert answer.status is Status.SOLVED
    assert own_residual(name, problem, answer) <= TOL


@pytest.mark.parametrize("name", [name for name in SOLVERS if find(name)[0].warm_start and 2 in find(name)[0].dimension])
def test_warm_start_is_harmless(name) -> None:
    problem = PLANAR["stack"]
    right = solve(problem, "lemke").impulse
    for start in (right, right[::-1].copy(), np.zeros_like(right)):
        answer = solve(problem, name, tol=TOL, start=start)
        assert answer.status is Status.SOLVED
        assert own_residual(name, problem, answer) <= TOL
    assert solve(problem, "hybrid", tol=TOL, start=right).status is Status.SOLVED


@pytest.mark.parametrize("name", ["interior_point", "nsgs", "hybrid"])
def test_work_limit_status(name) -> None:
    answer = solve(scene("stack", blocks=20, push=1.0).problem(), name, tol=1e-10, limit=1)
    assert answer.status is not Status.SOLVED or name == "hybrid"


@pytest.mark.parametrize("limit", [None, 20])
def test_portfolio_continues_after_gauss_seidel(limit) -> None:
    answer = solve(spatial(103, contacts=64, nv=192, friction=3), "hybrid", limit=limit)
    assert answer.status is Status.SOLVED
    assert answer.detail == "answered by interior_point"
    assert answer.work["nsgs sweeps"] <= (limit or 30)


@pytest.mark.parametrize("push", [0.0, 1.0])
def test_an_answer_that_rounding_cannot_tell_from_others_is_not_claimed(push) -> None:
    """Under heavy blocks what the lightest feels is known to 1e-16 times the ratio of their masses."""
    for blocks in (2, 5, 8):
        problem = scene("stack", blocks=blocks, push=push, mass_ratio=1e10).problem()
        answer = solve(problem, "hybrid", tol=1e-9)
        assert answer.status is not Status.SOLVED or residual_floor(problem, answer.impulse) <= 1e-9
