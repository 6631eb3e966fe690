"""Interior point methods on the friction LCP and on its convex relaxation."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances.random_bodies import random_bodies
from frictionbench.problems.instances.spheres import sphere_pyramid
from frictionbench.problems.packed import pack
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import contact_residuals, residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, interior_point, solve
from frictionbench.solvers.interface import find
from frictionbench.solvers.interior.central_path import new_path, trace
from frictionbench.solvers.interior.newton import new_work
from frictionbench.solvers.interior.point import centred_point, start_point
from frictionbench.solvers.interior.predictor_corrector import nothing_yet
from frictionbench.solvers.interior.system import build_system, space_of
from tests.helpers.friction_problems import spatial
from tests.helpers.kernels import (
    add_products,
    direction,
    evaluate_point,
    linearise,
    longest,
    new_point,
)


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


def with_every_kind_of_contact(dimension, joints=0) -> FrictionProblem:
    """Friction biases, a frictionless contact and joints."""
    known = random_problem(3, 8, bodies=9) if dimension == 2 else spatial(3, contacts=8, nv=27)
    friction, bias = known.friction.copy(), np.arange(8.0)
    friction[:2] = bias[:1] = 0
    friction[7] = 30.0  # of which the cone's defect is smaller by up to sqrt(1 + mu^2) than Signorini's own
    rows = np.random.default_rng(2).standard_normal((joints, 27))
    return known.replace(friction=friction, friction_bias=bias, joints=rows, joint_bias=np.ones(joints))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("relaxed", [False, True])
@pytest.mark.parametrize(("joints", "accuracy"), [(0, 1e-9), (2, 1e-5)])
def test_newton_step_removes_defect(joints, accuracy, relaxed, dimension) -> None:
    """Joints are soft, so they are met in two or three steps."""
    system = build_system(with_every_kind_of_contact(dimension, joints), relaxed)
    space = space_of(system)
    point, step, defect, work = start_point(system, 2.0, 1.0), new_point(system), new_point(system), new_work(system, np.inf)
    random = np.random.default_rng(1)
    for values in (point.x, point.s):
        values[:] = values * random.uniform(0.5, 2, values.shape)
        if dimension == 3:
            values[system.pairs > 1, 1:3] = random.uniform(-0.1, 0.1, (7, 2)) * point.s[system.pairs > 1, 3:]
    rubs = system.pairs[:, None] > 1
    target = np.where(rubs, random.standard_normal(point.x.shape), 0) + np.array([1.0, 0, 0, 0])
    evaluate_point(system, space, point, defect, work)
    linearise(system, space, point, work)
    direction(system, space, point, target, defect, step, work)
    met = np.zeros_like(target)
    for x, partner in ((point.x, step.s), (step.x, point.s)):
        add_products(space, 1.0, x, partner, met)
    if dimension == 3:  # of a product there, x alone makes one half and s the other
        met[:, 1:3] = sum(p.x[:, 1:3] * q.x[:, 3:] + p.s[:, 1:3] * q.s[:, 3:] for p, q in ((point, step), (step, point)))
    assert np.allclose(met, target, rtol=0, atol=1e-9)
    for unknown, change in zip(point, step, strict=True):
        unknown[:] += change
    evaluate_point(system, space, point, defect, work)
    assert np.abs(defect.x).max() < accuracy
    assert np.abs(defect.joint).max(initial=0) < accuracy


@pytest.mark.parametrize("dimension", [2, 3])
def test_internal_residual_equals_residual(dimension) -> None:
    problem = with_every_kind_of_contact(dimension)
    for relaxed in (False, True):
        units = problem.relaxation_units if relaxed else problem.units
        share = units / units.max()  # the system has one unit of velocity
        system = build_system(problem, relaxed)
        space = space_of(system)
        point, work = start_point(system, 1.0, 1.0), new_work(system, np.inf)
        for seed in range(20):
            point.x[:] = (
                np.random.default_rng(seed).uniform(0, 3, point.x.shape) * np.where(system.pairs > 1, 1, [[1], [0], [0], [0]]).T
            )
            inside = evaluate_point(system, space, point, new_point(system), work)
            found = contact_residuals(problem, work.impulse * system.impulse, 0.0 if relaxed else 1.0)
            assert inside == pytest.approx((found * share).max(), rel=1e-10)


@pytest.mark.parametrize("dimension", [2, 3])
def test_centred_point_products(dimension) -> None:
    """x ∘ s = g^2 in units of velocity; and around a solution, as g goes to 0, the solution and no defect."""
    problem = with_every_kind_of_contact(dimension)
    system, r = build_system(problem), solve(problem, "hybrid", tol=1e-13).impulse
    space = space_of(system)
    u = problem.contact_velocity(r)
    for g in (1e-3, 0.3, 10.0):
        point = centred_point(system, space, r, u, g)
        product, one = np.zeros((problem.contacts, 4)), np.full((problem.contacts, 4), g * g)
        one[:, 1:3] *= dimension == 2  # of Lorentz' cone the identity is (1, 0)
        add_products(space, 1.0, point.x, point.s, product)
        one[system.pairs == 1, 1:] = 0
        assert np.allclose(product * system.weight[:, None], one, rtol=1e-9, atol=1e-9 * g * g)
        assert longest(system, space, point, new_point(system), 1.0) == 1.0
    point, defect, work = centred_point(system, space, r, u, 1e-12), new_point(system), new_work(system, np.inf)
    assert evaluate_point(system, space, point, defect, work) < 1e-10
    assert np.abs(defect.x).max() < 1e-10
    assert np.allclose(work.impulse * system.impulse, r, rtol=0, atol=1e-10)


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


@pytest.mark.parametrize("steps", [1, 5, 20, 40])
def test_path_defect_is_proportional(steps) -> None:
    """The defect of a point of the path is that of its start, times the same t for all contacts, corrected or predicted."""
    system = build_system(sphere_pyramid(0, levels=3, friction=0.5))
    path, first, defect, work = _path(system), new_point(system), new_point(system), new_work(system, np.inf)
    evaluate_point(system, True, path.start, first, work)
    best = nothing_yet(*system.offset.shape)
    trace(system, True, path, work, best, 0.0, 12, np.empty(steps))
    evaluate_point(system, True, path.point, defect, work)
    t = np.vdot(defect.x, first.x) / np.vdot(first.x, first.x)
    assert 0 < t < 1
    assert np.allclose(defect.x, t * first.x, rtol=0, atol=1e-11 * abs(first.x).max())


def _path(system):
    return new_path(start_point(system, 1.5, 5.0))
