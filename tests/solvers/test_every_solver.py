"""Requirements on every solver: the contract of `check-solver`, and problems that each of them solves."""

import sys
from pathlib import Path

import numpy as np
import pytest

from frictionbench import solvers
from frictionbench.harness.contract.check import CHECKS, Subject
from frictionbench.harness.contract.checks import inapplicable
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual_floor
from frictionbench.solvers import Status, available, find, solve
from tests.helpers.friction_problems import block, contacts_of, known_by_W, nothing, own_residual, spatial, with_joints

TOL = 1e-6
OURS = sorted(spec for info in available().values() if not info.needs for spec in info.specs)
OUTSIDE = ["clarabel", "clarabel[settings=tuned]", "osqp", "proxsuite"]  # which every installation for tests has
LIMIT, DRY = 2, 3  # rows of joints, after two ordinary contacts


def rows_of_joints(dimension: int, *rows: int) -> FrictionProblem:
    """These of two contacts, a limit and dry friction, on six velocities.

    A limit has no tangent: T = 0, mu = 0. Dry friction has no normal: N = 0, mu = 0, a bias > 0 and the friction bias h loss.
    """
    random, nv, chosen = np.random.default_rng(dimension), 6, list(rows or range(4))
    normal, tangent = random.standard_normal((4, nv)), random.standard_normal((4, dimension - 1, nv))
    tangent[LIMIT] = normal[DRY] = tangent[DRY, 1:] = 0.0
    return FrictionProblem(
        mass=np.diag(1 + random.random(nv)),
        normal=normal[chosen],
        tangent=tangent[chosen].reshape(-1, nv),
        friction=np.array([0.4, 0.3, 0.0, 0.0])[chosen],
        free_velocity=random.standard_normal(nv) - 3 * normal[chosen].sum(axis=0),
        bias=np.array([0.0, 0.0, 0.0, 1.0])[chosen],
        friction_bias=np.array([0.0, 0.0, 0.0, 0.02])[chosen],
        dimension=dimension,
    )


PROBLEMS = {
    "nothing": nothing(),
    "nothing in space": nothing(3),
    "sliding": block(speed=1.0),
    "sticking": block(speed=0.0),
    "frictionless": block(friction=0.0),
    "biased": block(friction_bias=[0.05]),
    "biased and opening": block(h=-0.01, friction=0.0, friction_bias=[0.3]),
    "jointed": with_joints(random_problem(3, contacts=4, bodies=3), joints=np.random.default_rng(3).standard_normal((2, 9))),
    "stack": scene("stack", blocks=3, push=1.0).problem(),
    "rod": scene("painleve_rod").problem(),
    "random": random_problem(7, contacts=6),
    "delassus": FrictionProblem.from_delassus(np.diag([2.0, 1.0]), [-1.0, 1.0], [0.5], 2),
    "immovable": FrictionProblem.from_delassus(
        np.kron([[0, 0], [0, 1]], [[1.0, 0.2], [0.2, 1.0]]), [0.5, 1, -1, 0.3], [0.5, 0.5], 2
    ),
    "space": spatial(1, contacts=3),
    "biased and jointed in space": spatial(2, contacts=4, nv=24, friction=0.3, friction_bias=True, joints=2),
    **{f"limit and dry friction, {d}": rows_of_joints(d) for d in (2, 3)},
    **{f"limit, {d}": rows_of_joints(d, LIMIT) for d in (2, 3)},
    **{f"dry friction, {d}": rows_of_joints(d, DRY) for d in (2, 3)},
}


def test_solver_facts() -> None:
    modules = {info.make.__module__ for info in available().values()}  # also of plug-ins that other tests loaded
    defining = {Path(sys.modules[name].__file__) for name in modules if name.startswith("frictionbench.")}
    methods = set(Path(solvers.__file__).parent.glob("*.py")) - {Path(solvers.__file__)}
    machinery = {f"{name}.py" for name in ("balanced", "clock", "executable", "interface", "many", "needs", "plugins")}
    assert {path.name for path in methods - defining} == machinery
    for info in available().values():
        assert info.summary.endswith((".", ")"))
        assert info.model in ("coulomb", "lcp", "relaxation", "regularised")
        assert info.missing is None or info.needs


@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("spec", [*OURS, "nsgs[relaxation=1.3]"])
def test_contract(spec, check) -> None:
    assert inapplicable(check, find(spec)[0]) or list(CHECKS[check].violations(Subject(*find(spec)))) == []


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("spec", [*OURS, *OUTSIDE])
def test_a_problem_is_solved(spec, name) -> None:
    """Each by its bodies and by W alone; rows of joints carry what they can and no more."""
    problem = PROBLEMS[name]
    for form in (problem, known_by_W(problem)) if problem.contacts else (problem,):
        if find(spec)[0].refuses(form):
            continue
        answer = solve(form, spec, tol=TOL)
        if spec == "murty" and (problem.dimension == 3 or name == "immovable") and answer.status is Status.STALLED:
            continue  # sure for P-matrices only, which those of polygons are not
        if spec == "clarabel" and name == "biased and jointed in space" and answer.detail == "AlmostSolved":
            continue  # at the limit of rounding, on some processors
        assert answer.status is Status.SOLVED, "each of these has a solution, within reach of every method here"
        assert own_residual(spec, form, answer) <= TOL
        dry = problem.friction_bias == 0.02
        assert np.abs(answer.impulse[dry, 0]).max(initial=0.0) <= (0.0 if spec in OURS else 1e-9)
        assert answer.impulse[dry, 1].all()
        if "limit" in name:
            assert not answer.impulse[-1 - dry.sum(), 1:].any()


def nearly_locked(seed: int) -> FrictionProblem:
    """Joints hold two normals and a tangent of contacts but for 1e-9 to 1e-6: W has lost digits there, or all."""
    free = random_problem(seed, contacts=4, bodies=2) if seed % 2 else spatial(seed, contacts=4, nv=12)
    random, held = np.random.default_rng(seed), free.jacobian.toarray()[[0, free.dimension, 2 * free.dimension + 1]]
    return with_joints(free, joints=held + 10 ** random.uniform(-9, -6) * random.standard_normal(held.shape))


@pytest.mark.parametrize("spec", OURS)
def test_claims_are_correct(spec) -> None:
    rows = np.eye(3) - np.eye(3, k=-1)  # three points above each other; the second leaves the first and slides at 1e6 m/s
    law = [0.5, 1e6, 0.5], [1e6, -1, 0, 2, 0, 2 - 2e-4]
    problems = [contacts_of(np.kron(rows, [0, 1]), np.kron(rows, [1, 0]), *law), *map(nearly_locked, (12, 18, 23, 54))]
    problems += [random_problem(seed, contacts=(2, 10, 30)[seed % 3]) for seed in range(12)]
    problems += [spatial(seed, contacts=6, friction_bias=seed % 2 == 0, joints=seed % 3) for seed in range(6)]
    answers = [(problem, solve(problem, spec)) for problem in problems if not find(spec)[0].refuses(problem)]
    claimed = [own_residual(spec, *each) for each in answers if each[1].status is Status.SOLVED]
    assert max(claimed) <= 1e-8 * (1 + 1e-6)
    assert spec == "murty" or len(claimed) >= len(answers) / 2


@pytest.mark.parametrize("spec", [*(spec for spec in OURS if find(spec)[0].warm_start), "daqp"])
def test_a_start_at_the_solution_saves_work(spec) -> None:
    if reason := find(spec)[0].missing:
        pytest.skip(reason)
    problem = PROBLEMS["stack" if 2 in find(spec)[0].dimension else "space"]
    cold = solve(problem, spec)
    warm = solve(problem, spec, start=cold.impulse)
    assert warm.status is Status.SOLVED
    assert sum(warm.work.values()) < sum(cold.work.values())


@pytest.mark.parametrize("spec", [spec for spec in OURS if spec != "hybrid"])
def test_work_limit_status(spec) -> None:
    problem = scene("stack", blocks=8, push=0.3).problem() if 2 in find(spec)[0].dimension else spatial(0)
    answer = solve(problem, spec, limit=3)
    assert answer.status is Status.WORK_LIMIT
    assert answer.work.get("pivots", next(iter(answer.work.values()))) <= 3
    if find(spec)[0].family == "splitting":
        assert answer.history[-1] == pytest.approx(own_residual(spec, problem, answer), rel=1e-6)


@pytest.mark.parametrize("limit", [None, 20])
def test_portfolio_continues_after_gauss_seidel(limit) -> None:
    answer = solve(spatial(103, contacts=64, nv=192, friction=3), "hybrid", limit=limit)
    assert answer.status is Status.SOLVED
    assert answer.detail == "answered by interior_point"
    assert answer.work["nsgs sweeps"] <= (limit or 30)


@pytest.mark.parametrize("blocks", [2, *(pytest.param(blocks, marks=pytest.mark.slow) for blocks in (5, 8))])
@pytest.mark.parametrize("push", [1.0, pytest.param(0.0, marks=pytest.mark.slow)])
def test_an_answer_that_rounding_cannot_tell_from_others_is_not_claimed(blocks, push) -> None:
    """Under heavy blocks what the lightest feels is known to 1e-16 times the ratio of their masses."""
    problem = scene("stack", blocks=blocks, push=push, mass_ratio=1e10).problem()
    answer = solve(problem, "hybrid", tol=1e-9)
    assert answer.status is not Status.SOLVED or residual_floor(problem, answer.impulse) <= 1e-9
