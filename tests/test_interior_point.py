"""Interior point methods on the friction LCP and on its convex relaxation."""

from pathlib import Path

import numpy as np
import pytest
from scipy import sparse

from problems import FrictionProblem
from problems.random_problem import random_problem
from problems.residual import relaxation_residual, residual
from problems.scenes import scene
from solvers import Status, solve
from solvers.contact_newton import direction, evaluate, linearise, new_point, new_work, start_point
from solvers.contact_system import prepare
from solvers.predictor_corrector import longest
from tests.friction_problems import block, nothing

METHODS = ("interior_point", "interior_point[shortcut=false]")
DATA = Path(__file__).parent / "data"


def changed(problem, **fields):
    names = ["mass", "normal", "tangent", "friction", "free_velocity", "bias", "friction_bias", "joints", "joint_bias"]
    return FrictionProblem(**{name: getattr(problem, name) for name in names} | fields)


def assert_solved(problem, spec, tol=1e-8, at_most=2000) -> None:
    answer = solve(problem, spec, tol=tol)
    measure = relaxation_residual if spec == "relaxation_ip" else residual
    assert answer.status is Status.SOLVED
    assert measure(problem, answer.impulse) <= tol
    assert answer.work["factorisations"] <= at_most
    assert len(answer.history) == answer.work["iterations"]


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("seed", range(40))
def test_random_problems(seed, spec) -> None:
    assert_solved(random_problem(seed, 1 + seed), spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("friction", [0.05, 0.5, 2.0])
@pytest.mark.parametrize(("name", "size"), [("stack", {"blocks": 50}), ("pyramid", {"rows": 8})])
def test_stacks_and_pyramids_with_exact_ties(name, size, friction, spec) -> None:
    assert_solved(scene(name, friction=friction, **size).problem(), spec, tol=1e-9)


def test_a_tall_stack_takes_few_iterations() -> None:
    assert_solved(scene("stack", blocks=400).problem(), "interior_point", at_most=30)


@pytest.mark.parametrize("seed", [19, 30, 76, 115, 190, 195, 222, 285, 286, 294])
def test_traps_of_the_predictor_corrector_are_left_along_the_path(seed) -> None:
    """Where x s stops at a fold of the central path, with the residual at 1e-2 to 1e-3."""
    assert_solved(random_problem(seed, 1 + seed % 50), "interior_point")


@pytest.mark.parametrize("seed", [3235, 3247, 3426, 4443, 4496, 4722, 5770])
def test_folds_of_the_path_that_ten_restarts_did_not_avoid(seed) -> None:
    assert_solved(random_problem(seed, 1 + seed % 50), "interior_point[shortcut=false]")


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("ratio", [1e-6, 1e3, 1e6])
def test_mass_ratios(ratio, spec) -> None:
    problem = random_problem(8, 20, mass_ratio=max(ratio, 1 / ratio))
    assert_solved(changed(problem, mass=problem.mass * min(ratio, 1.0)), spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_special_cases(spec) -> None:
    pyramid = scene("pyramid", rows=4).problem()
    mixed = pyramid.friction.copy()
    mixed[::2] = 0
    for problem in (
        nothing(),
        block(),
        changed(pyramid, friction=np.zeros(pyramid.contacts)),
        changed(pyramid, friction=mixed),
        changed(pyramid, friction=mixed, friction_bias=np.full(pyramid.contacts, 0.01)),
        changed(pyramid, friction=np.full(pyramid.contacts, 1e-9)),
        changed(pyramid, friction=np.full(pyramid.contacts, 50.0)),
        changed(pyramid, free_velocity=np.zeros(len(pyramid.free_velocity)), bias=np.zeros(pyramid.contacts)),
        changed(pyramid, bias=np.full(pyramid.contacts, 1e3)),
    ):
        assert_solved(problem, spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_joints_of_any_rank(spec) -> None:
    pyramid = scene("pyramid", rows=4).problem()
    rows = np.zeros((4, len(pyramid.free_velocity)))
    rows[0, [0, 3]] = 1, -1
    rows[1] = rows[0]
    rows[2, 4] = 1
    rows[3] = rows[0] + rows[2]
    assert_solved(changed(pyramid, joints=rows, joint_bias=np.zeros(4)), spec)
    assert_solved(changed(pyramid, joints=rows[[0, 2]], joint_bias=[0.1, -0.2]), spec)


@pytest.mark.parametrize("spec", METHODS)
def test_a_delassus_matrix_that_is_not_symmetric_is_solved_as_given(spec) -> None:
    known = random_problem(5, 10)
    W = known.W.toarray()
    W += 1e-7 * np.abs(W).max() * np.random.default_rng(0).standard_normal(W.shape)
    assert_solved(FrictionProblem.from_delassus(W, known.q, known.friction, 2), spec, tol=1e-10)


def test_a_mass_matrix_that_is_dense() -> None:
    pyramid = scene("pyramid", rows=4).problem()
    root = np.random.default_rng(0).standard_normal(pyramid.mass.shape)
    assert_solved(changed(pyramid, mass=root @ root.T + np.eye(len(root))), "interior_point")


def test_the_answer_does_not_depend_on_units() -> None:
    problem = random_problem(7, 12)
    heavy = changed(problem, mass=problem.mass * 1e9)
    slow = changed(problem, free_velocity=problem.free_velocity * 1e-6, bias=problem.bias * 1e-6)
    expected = solve(problem, "interior_point", tol=1e-11)
    for other, factor in ((heavy, 1e9), (slow, 1e-6)):
        velocity = other.velocity(solve(other, "interior_point", tol=1e-11).impulse)
        unit = 1.0 if other is heavy else factor
        assert np.allclose(velocity / unit, problem.velocity(expected.impulse), rtol=0, atol=1e-8)


def test_an_impossible_tolerance_is_not_claimed() -> None:
    answer = solve(random_problem(1, 30), "interior_point", tol=1e-300)
    assert answer.status in (Status.STALLED, Status.WORK_LIMIT)
    assert residual(random_problem(1, 30), answer.impulse) < 1e-12


def test_rounding_below_the_tolerance_is_not_claimed_away() -> None:
    """A jam in which internal impulses may grow to 1e8, where rounding hides a residual of 7e-8."""
    assert_solved(random_problem(414, 15, mass_ratio=1e4), "interior_point")


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_the_limit_bounds_the_factorisations(spec) -> None:
    answer = solve(scene("stack", blocks=50).problem(), spec, limit=3)
    assert answer.status is Status.WORK_LIMIT
    assert answer.work["factorisations"] <= 3


def test_relaxation_and_coulomb_differ_where_a_block_slides() -> None:
    """AP: a sliding block keeps to the ground; the relaxation lifts it by mu u_t (FACTS, relaxation artefact)."""
    problem = block(speed=1.0, friction=0.5)
    exact = problem.contact_velocity(solve(problem, "interior_point", tol=1e-12).impulse)
    relaxed = problem.contact_velocity(solve(problem, "relaxation_ip", tol=1e-12).impulse)
    assert exact[0] == pytest.approx([0.0, 1 - 0.5 * 0.0981], abs=1e-10)
    assert relaxed[0, 0] == pytest.approx(0.5 * relaxed[0, 1], abs=1e-10)


@pytest.mark.parametrize("relaxed", [False, True])
@pytest.mark.parametrize(("joints", "accuracy"), [(0, 1e-9), (2, 1e-5)])
def test_a_full_newton_step_meets_its_target_and_removes_the_defect(joints, accuracy, relaxed) -> None:
    """Also with friction biases and a frictionless contact; joints are soft, so they are met in two or three steps."""
    known = random_problem(3, 8, bodies=9)
    friction = known.friction.copy()
    friction[0] = 0
    rows = np.random.default_rng(2).standard_normal((joints, len(known.free_velocity)))
    problem = changed(known, friction=friction, friction_bias=np.arange(8.0), joints=rows, joint_bias=np.ones(joints))
    system = prepare(problem, relaxed)
    point, step, defect, work = start_point(system, 2.0, 1.0), new_point(system), new_point(system), new_work(system)
    random = np.random.default_rng(1)
    point.x[:] *= random.uniform(0.5, 2, point.x.shape)
    point.s[:] *= random.uniform(0.5, 2, point.s.shape)
    target = random.standard_normal(point.x.shape)
    evaluate(system, point, defect, work)
    linearise(system, point, work)
    direction(system, point, target, defect, step, work)
    used = np.arange(4) < system.pairs[:, None]
    met = point.x * step.s + point.s * step.x
    assert np.allclose(met[used], target[used], rtol=0, atol=1e-9)
    for unknown, change in zip(point, step, strict=True):
        unknown[:] += change
    evaluate(system, point, defect, work)
    assert np.abs(defect.x).max() < accuracy
    assert np.abs(defect.joint).max(initial=0) < accuracy


def test_the_residual_inside_is_the_residual_of_the_project() -> None:
    for seed in range(20):
        problem = changed(random_problem(seed, 6), friction_bias=np.abs(np.sin(np.arange(6.0))))
        for relaxed, measure in ((False, residual), (True, relaxation_residual)):
            system = prepare(problem, relaxed)
            point, work = start_point(system, 1.0, 1.0), new_work(system)
            point.x[:] = np.random.default_rng(seed).uniform(0, 3, point.x.shape)
            inside = evaluate(system, point, new_point(system), work)
            assert inside == pytest.approx(measure(problem, work.impulse * system.impulse), rel=1e-10)


def test_the_longest_step_stops_at_the_first_zero() -> None:
    system = prepare(random_problem(0, 3))
    point, step = start_point(system, 1.0, 1.0), new_point(system)
    assert longest(system, point, step, 1.0) == 1.0
    step.x[1, 2] = -4 * point.x[1, 2]
    step.s[0, 1] = -2 * point.s[0, 1]
    assert longest(system, point, step, 1.0) == pytest.approx(0.25)


def from_lcp(M, q) -> FrictionProblem:
    """The friction problem of a friction LCP in (c, beta, lambda)."""
    nc = len(q) // 4
    owner = M[nc : 3 * nc, 3 * nc :].argmax(axis=1)
    tangent = nc + np.array([np.flatnonzero(owner == i)[0] for i in range(nc)])
    rows = np.column_stack([np.arange(nc), tangent]).ravel()
    return FrictionProblem.from_delassus(M[np.ix_(rows, rows)], q[rows], M[3 * nc :, :nc].diagonal(), 2)


@pytest.mark.parametrize("spec", METHODS)
@pytest.mark.parametrize(("name", "instances"), [("bar", 11), ("blocks", 4)])
def test_recorded_steps_on_which_lemke_ends_on_a_false_ray(name, instances, spec) -> None:
    with np.load(DATA / f"false_rays_{name}.npz") as data:
        for k in range(instances):
            assert_solved(from_lcp(data[f"M{k}"], data[f"q{k}"]), spec)


@pytest.mark.parametrize("spec", METHODS)
def test_recorded_step_near_a_jam(spec) -> None:
    with np.load(DATA / "near_jam.npz") as data:
        N, T, mu = data["N"].T, data["T"].T, np.full(len(data["b"]), data["mu"])
        v, b = data["vfree"], data["b"]
        assert_solved(FrictionProblem(mass=data["M"], normal=N, tangent=T, friction=mu, free_velocity=v, bias=b), spec)


def test_sparse_joints_keep_a_chain_sparse() -> None:
    nv = 40
    rows = sparse.diags_array([np.ones(nv - 1), -np.ones(nv - 1)], offsets=[0, 1], shape=(nv - 1, nv))
    normal = sparse.csr_array(([1.0], ([0], [0])), shape=(1, nv))
    tangent = sparse.csr_array(([1.0], ([0], [nv - 1])), shape=(1, nv))
    problem = FrictionProblem(
        mass=np.eye(nv), normal=normal, tangent=tangent, friction=[0.3], free_velocity=-np.ones(nv), bias=[0.0], joints=rows
    )
    assert prepare(problem).fronts.start[-1] < 16 * nv
    assert_solved(problem, "interior_point")
