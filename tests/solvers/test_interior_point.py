"""Interior point methods on the friction LCP and on its convex relaxation."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_bodies, random_problem
from frictionbench.problems.packed import pack
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.problems.subproblems import separate, side_by_side
from frictionbench.solvers import Status, interior_point, solve
from frictionbench.solvers.interface import find
from frictionbench.solvers.interior.central_path import new_path, trace
from frictionbench.solvers.interior.phases import run
from frictionbench.solvers.interior.point import start_point
from tests.helpers.friction_problems import spatial


@pytest.mark.parametrize("push", [0.0, 1.0])
def test_a_stack_that_lifts_off_takes_no_iterations(push: float) -> None:
    """The lowest contacts neither close nor open, where the iteration converges linearly only."""
    problem = scene("stack", blocks=5, push=push, fall=-1.0).problem()
    answer, packed = solve(problem, "interior_point"), find("interior_point")[1].solve_many(pack([problem]), 1e-8, None)
    assert answer.status is packed.status[0] is Status.SOLVED
    assert answer.work["iterations"] == packed.work["iterations"][0] == 0
    assert not answer.impulse.any()
    assert not packed.impulse.any()


@pytest.mark.parametrize("problem", [random_problem(5, 30), random_bodies(5, 60, 0.5), scene("stack", blocks=50).problem()])
def test_near_start_saves_iterations(problem) -> None:
    cold = solve(problem, "interior_point")
    assert solve(problem, "interior_point", start=cold.impulse).work["iterations"] <= 2
    noise = np.random.default_rng(0).standard_normal(cold.impulse.shape)
    near = solve(problem, "interior_point", start=cold.impulse * (1 + 1e-5 * noise))
    assert near.status is Status.SOLVED
    assert near.work["iterations"] <= 0.7 * cold.work["iterations"]


def test_unreachable_tolerance_is_not_claimed() -> None:
    answer = solve(random_problem(1, 30), "interior_point", tol=1e-300)
    assert answer.status in (Status.STALLED, Status.WORK_LIMIT)
    assert residual(random_problem(1, 30), answer.impulse) < 1e-12


def test_polishing_in_the_plane(monkeypatch) -> None:
    problem = scene("disc_pile", rows=8, friction=0.5).problem()
    right = solve(problem, "interior_point", tol=1e-12).impulse
    wrong = right * (1 + 1e-8 * np.random.default_rng(0).standard_normal(right.shape))

    def leave(system, space, point, work, best, tol, patience, history):
        best.impulse[:], history[0] = wrong / system.impulse, 1.0
        return 1

    monkeypatch.setattr(interior_point, "predictor_corrector", leave)
    assert 1e-8 < residual(problem, wrong) < 1e-5
    answer = solve(problem, "interior_point")
    assert residual(problem, answer.impulse) <= 1e-8
    assert 0 < answer.work["polishing factorisations"] <= 60
    assert answer.work["factorisations"] == 0


@pytest.mark.parametrize(
    ("start", "status"),
    [((1e-150, 1e160), Status.STALLED), ((1e160, 1e-150), Status.BREAKDOWN), ((1e300, 1e300), Status.BREAKDOWN)],
)
def test_a_path_ends_when_numbers_overflow(start, status) -> None:
    """The first start has a finite residual, but no step; the residuals of the others overflow."""
    problem = random_problem(0, contacts=3)
    prepared = find("interior_point")[1].prepare(problem)
    paths = [(trace, new_path(start_point(prepared[1], *start)), 40)]
    answer = run(prepared, paths, 1e-8, 40, 12, residual)
    assert answer.status is status
    assert len(answer.history) < 10


def test_no_part_is_built_after_the_deadline(monkeypatch) -> None:
    problem = side_by_side(*(random_problem(2, 3) for _ in range(5)))
    parts = separate(problem)
    for name, changed in (("separate", lambda _: parts), ("predictor_corrector", lambda *_: 0), ("is_over", lambda: True)):
        monkeypatch.setattr(interior_point, name, changed)
    assert solve(problem, "interior_point").status is Status.TIME_LIMIT
    assert len(list(parts)) == 4


@pytest.mark.parametrize(("spec", "measure"), [("interior_point", residual), ("relaxation_ip", relaxation_residual)])
def test_claims_with_nearly_dependent_joints(spec, measure) -> None:
    """Small defects of such joints are large ones of contacts: a claim needs the residual of the exact problem."""
    for seed in range(12):
        given = spatial(seed, contacts=4, nv=24, joints=4)
        joints = given.joints.toarray()
        joints[3] = joints[0] + 1e-3 * joints[3]
        problem = given.replace(joints=joints, joint_bias=np.zeros(4))
        answer = solve(problem, spec)
        assert (answer.status is Status.SOLVED) == (measure(problem, answer.impulse) <= 1e-8)
