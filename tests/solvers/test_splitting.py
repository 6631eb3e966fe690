"""The splitting methods: their claims are correct and they converge at the rates known for one contact."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, anitescu_hart, available, find, solve
from frictionbench.solvers.sweeps.stopping import monitor, should_continue
from tests.helpers.friction_problems import block, nothing, spatial, with_joints

COULOMB = ["admm_coulomb", "anitescu_hart", "anitescu_hart[memory=3]", "apgd_coulomb", "nncg", "nsgs", "staggered"]
RELAXED = ["admm", "apgd"]
ALL = COULOMB + RELAXED


def measure(spec, problem, impulse) -> float:
    """The residual of the model that the solver is given."""
    relaxed = available()[spec.partition("[")[0]].model == "relaxation"
    return (relaxation_residual if relaxed else residual)(problem, impulse)


def one_contact(a, b, g, mu, q) -> FrictionProblem:
    return FrictionProblem.from_delassus([[a, b], [b, g]], q, [mu], 2)


@pytest.mark.parametrize("spec", ALL)
@pytest.mark.parametrize(("blocks", "push"), [(1, 0.0), (5, 0.3)])
def test_stacks_are_solved(spec, blocks, push) -> None:
    problem = scene("stack", blocks=blocks, push=push).problem()
    answer = solve(problem, spec)
    assert answer.status is Status.SOLVED
    assert measure(spec, problem, answer.impulse) <= 1e-8


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
            assert measure(spec, problem, answer.impulse) <= 1e-7 * (1 + 1e-6)
    assert solved >= (len(problems) if spec in RELAXED else 0.75 * len(problems))


@pytest.mark.parametrize("spec", RELAXED)
@pytest.mark.parametrize("problem", [random_problem(8, contacts=20), spatial(3, joints=1, friction_bias=True)])
def test_relaxation_velocity_is_unique(spec, problem) -> None:
    reference = solve(problem, "clarabel", tol=1e-9)
    answer = solve(problem, spec, tol=1e-9)
    assert problem.velocity(answer.impulse) == pytest.approx(problem.velocity(reference.impulse), abs=1e-6)


@pytest.mark.parametrize("spec", ALL)
def test_sliding_block_follows_its_model(spec) -> None:
    # A block that goes on sliding: Coulomb's keeps to the ground, the relaxation's lifts off at mu u_t.
    problem = block(speed=1.0, friction=0.6)
    u_n, u_t = problem.contact_velocity(solve(problem, spec, tol=1e-10).impulse)[0]
    assert u_n == pytest.approx(0.6 * u_t if spec in RELAXED else 0.0, abs=1e-8)


@pytest.mark.parametrize("spec", ALL)
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_contact(spec, dimension) -> None:
    answer = solve(nothing(dimension), spec)
    assert answer.status is Status.SOLVED
    assert answer.impulse.shape == (0, dimension)


@pytest.mark.parametrize("spec", ALL)
def test_a_start_at_the_solution_takes_no_work(spec) -> None:
    problem = scene("stack", blocks=2, push=0.3).problem()
    cold = solve(problem, spec)
    warm = solve(problem, spec, start=cold.impulse)
    assert warm.status is Status.SOLVED
    assert next(iter(warm.work.values())) == 0
    assert np.array_equal(warm.impulse, cold.impulse)


@pytest.mark.parametrize("spec", ALL)
def test_work_limit_status(spec) -> None:
    problem = scene("stack", blocks=8, push=0.3).problem()
    answer = solve(problem, spec, limit=3)
    assert answer.status is Status.WORK_LIMIT
    assert next(iter(answer.work.values())) == 3
    assert answer.history[-1] == pytest.approx(measure(spec, problem, answer.impulse), rel=1e-6)


def test_a_residual_that_is_not_finite_is_a_breakdown() -> None:
    watched = monitor(tol=1e-8, limit=10, patience=5)
    assert should_continue(watched, 1.0, 0)
    assert not should_continue(watched, np.nan, 1)
    assert watched.answer(np.zeros((1, 2))).status is Status.BREAKDOWN


@pytest.mark.parametrize("spec", ALL)
def test_velocities_and_impulses_give_the_same_answer(spec) -> None:
    problem = scene("stack", blocks=3, push=0.5).problem()
    by_delassus = FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, 2)
    answer = solve(by_delassus, spec)
    assert answer.status is Status.SOLVED
    assert measure(spec, problem, answer.impulse) <= 1.01e-8


@pytest.mark.parametrize("spec", ALL)
def test_unit_invariance(spec) -> None:
    # By powers of two, so that round-off too is the same.
    problem = scene("stack", blocks=3, push=0.25).problem()
    fields = {name: getattr(problem, name) for name in ("normal", "tangent", "friction", "dimension")}
    units = FrictionProblem(
        mass=problem.mass * 2**20, free_velocity=problem.free_velocity / 2**10, bias=problem.bias / 2**10, **fields
    )
    answers = [solve(form, spec) for form in (problem, units)]
    assert answers[0].work == answers[1].work
    assert answers[1].impulse == pytest.approx(answers[0].impulse * 2**10, rel=1e-12)


@pytest.mark.parametrize("spec", ALL)
def test_immovable_contact(spec) -> None:
    W = np.zeros((4, 4))
    W[2:, 2:] = [[1.0, 0.2], [0.2, 1.0]]
    problem = FrictionProblem.from_delassus(W, [0.5, 1.0, -1.0, 0.3], [0.5, 0.5], 2)
    answer = solve(problem, spec)
    assert answer.status is Status.SOLVED
    assert measure(spec, problem, answer.impulse) <= 1e-8


@pytest.mark.parametrize("spec", ALL)
def test_duplicated_contact(spec) -> None:
    W, q = np.array([[1.0, 0.2], [0.2, 1.0]]), np.array([-1.0, 0.8])
    once = FrictionProblem.from_delassus(W, q, [0.5], 2)
    twice = FrictionProblem.from_delassus(np.tile(W, (2, 2)), np.tile(q, 2), [0.5, 0.5], 2)
    answers = [solve(problem, spec) for problem in (once, twice)]
    assert answers[1].status is Status.SOLVED
    assert answers[1].impulse.sum(axis=0) == pytest.approx(answers[0].impulse[0], abs=1e-6)


@pytest.mark.parametrize("spec", ALL)
def test_joints_and_a_friction_bias(spec) -> None:
    problem = scene("stack", blocks=3, push=0.5).problem()
    joints = np.zeros((1, 9))
    joints[0, [3, 6]] = 1, -1  # the two upper blocks move sideways together
    problem = with_joints(problem, joints, np.full(problem.contacts, 0.01))
    answer = solve(problem, spec)
    assert answer.status is Status.SOLVED
    assert measure(spec, problem, answer.impulse) <= 1e-8
    assert joints @ problem.velocity(answer.impulse) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("a", "b", "g", "mu"), [(1.0, 0.97, 1.0, 0.75), (1.0, -0.5, 2.0, 0.8)])
def test_staggering_rate_of_sliding_contact(a, b, g, mu) -> None:
    problem = one_contact(a, b, g, mu, [-1.0, 3.0])
    history = np.array(solve(problem, "staggered", tol=1e-12).history)
    assert residual(problem, solve(problem, "staggered", tol=1e-12).impulse) <= 1e-12
    rate = (history[-4] / history[-14]) ** 0.1
    assert rate == pytest.approx(mu * abs(b) / a, rel=0.02)


def test_anitescu_hart_rate_of_sliding_contact(monkeypatch) -> None:
    a, b, g, mu = 1.0, -0.3, 1.0, 0.6
    monkeypatch.setattr(anitescu_hart, "INNER", 1e-3)
    problem = one_contact(a, b, g, mu, [-1.0, 3.0])
    history = np.array(solve(problem, "anitescu_hart", tol=1e-9).history)
    expected = abs(mu * (mu * g - b)) / (a - 2 * mu * b + mu**2 * g)
    assert history[4:-1] / history[3:-2] == pytest.approx(expected, rel=0.02)


def test_anitescu_hart_cycle() -> None:
    problem = one_contact(1.0, 0.97, 1.0, 0.75, [-1.0, 2.0])
    plain = solve(problem, "anitescu_hart")
    assert plain.status is Status.STALLED
    assert plain.detail == "a cycle of period two"
    for spec in ("staggered", "anitescu_hart[memory=2]"):
        assert residual(problem, solve(problem, spec).impulse) <= 1e-8


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


def test_negative_memory() -> None:
    with pytest.raises(InputError, match="memory"):
        find("anitescu_hart[memory=-1]")
