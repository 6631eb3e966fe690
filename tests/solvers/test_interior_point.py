"""Interior point methods on the friction LCP and on its convex relaxation."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances.cubes import cubes
from frictionbench.problems.instances.graphs import local_graph
from frictionbench.problems.instances.random_bodies import random_bodies
from frictionbench.problems.instances.recorded_step import recorded_step
from frictionbench.problems.instances.spheres import sphere_pyramid
from frictionbench.problems.packed import pack
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import contact_residuals, relaxation_residual, residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, interior_point, solve
from frictionbench.solvers.interface import find
from frictionbench.solvers.interior.central_path import new_path, trace
from frictionbench.solvers.interior.newton import new_work
from frictionbench.solvers.interior.phases import run
from frictionbench.solvers.interior.point import Point, centred_point, start_point
from frictionbench.solvers.interior.predictor_corrector import nothing_yet
from frictionbench.solvers.interior.system import build_system, space_of
from tests.helpers.friction_problems import block, nothing, spatial
from tests.helpers.kernels import (
    add_products,
    direction,
    evaluate_point,
    linearise,
    longest,
    longest_in_cone,
    new_point,
    to_geodesics,
)
from tests.helpers.paths import DATA

METHODS = ("interior_point", "interior_point[shortcut=false]")


def assert_solved(problem, spec, tol=1e-8, at_most=2000) -> None:
    answer = solve(problem, spec, tol=tol)
    measure = relaxation_residual if spec == "relaxation_ip" else residual
    assert answer.status in (Status.SOLVED, Status.ROUNDING)  # of extreme masses and near jams
    assert measure(problem, answer.impulse) <= tol
    assert answer.work["factorisations"] <= at_most
    assert len(answer.history) == answer.work["iterations"]


@pytest.mark.parametrize("push", [0.0, 1.0])
def test_a_stack_that_lifts_off_takes_no_iterations(push: float) -> None:
    """The lowest contacts neither close nor open, where the iteration converges linearly only."""
    problem = scene("stack", blocks=5, push=push, fall=-1.0).problem()
    answer, packed = solve(problem, "interior_point"), find("interior_point")[1].solve_many(pack([problem]), 1e-8, None)
    assert answer.status is packed.status[0] is Status.SOLVED
    assert answer.work["iterations"] == packed.work["iterations"][0] == 0
    assert not answer.impulse.any()
    assert not packed.impulse.any()


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("seed", range(0, 40, 4))
def test_random_problems(seed, spec) -> None:
    assert_solved(random_problem(seed, 1 + seed), spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("friction", [0.05, 0.5, 2.0])
@pytest.mark.parametrize(("name", "size"), [("stack", {"blocks": 50}), ("pyramid", {"rows": 8})])
def test_stacks_and_pyramids_with_exact_ties(name, size, friction, spec) -> None:
    assert_solved(scene(name, friction=friction, **size).problem(), spec, tol=1e-9)


SPATIAL = [(contacts, nv, friction) for contacts, nv in ((1, 6), (8, 18), (20, 60)) for friction in (0.1, 3.0)]


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize(("contacts", "nv", "friction"), SPATIAL)
def test_spatial_problems(contacts, nv, friction, spec) -> None:
    for seed in range(3):
        assert_solved(spatial(seed, contacts=contacts, nv=nv, friction=friction), spec)
        biased = spatial(seed, contacts=contacts, nv=nv, friction=friction, friction_bias=True, joints=seed % 3)
        assert_solved(biased, spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("push", [0.0, 1.0])
@pytest.mark.parametrize("friction", [0.0, 0.05])
def test_spatial_stacks_with_exact_ties(friction, push, spec) -> None:
    assert_solved(cubes(30, friction=friction, push=push), spec, tol=1e-9)
    assert_solved(cubes(10, friction=friction, push=push, mass_ratio=1e4), spec)


@pytest.mark.parametrize(
    ("contacts", "nv", "friction", "seed"), [(1, 6, 0.1, 23), (2, 6, 3, 14), (12, 18, 1, 0), (12, 18, 3, 21), (20, 60, 3, 12)]
)
def test_spatial_stagnation_is_resolved_by_path(contacts, nv, friction, seed) -> None:
    """Where the predictor-corrector stops; the three in the middle from other starts, too."""
    assert_solved(spatial(seed, contacts=contacts, nv=nv, friction=friction), "interior_point")


def test_relaxation_restart() -> None:
    """One contact: its y and z commute at the start and lose it on the way; the products' vector part then stops every step."""
    assert_solved(spatial(13, contacts=1, nv=6, friction=1), "relaxation_ip")


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_spatial_special_cases(spec) -> None:
    known = spatial(4, contacts=6, nv=24)
    mixed = known.friction * [0, 1, 0, 1, 1, 0]
    for problem in (
        nothing(3),
        known.replace(friction=np.zeros(6)),
        known.replace(friction=mixed),
        known.replace(friction=mixed, friction_bias=np.full(6, 0.1)),
        known.replace(friction=np.full(6, 1e-9)),
        known.replace(friction=np.full(6, 50.0)),
        known.replace(free_velocity=np.zeros(24)),
        known.replace(bias=np.full(6, 1e3)),
        known.replace(mass=known.mass * 1e9),
        known.replace(mass=np.diag(np.tile([1.0, 1e6], 12))),
    ):
        assert_solved(problem, spec)


def test_sliding_contact_accuracy() -> None:
    """The cone's boundary: u_t opposes r_t, |r_t| = mu r_n, by hand for a point mass pushed across the ground."""
    problem = FrictionProblem(
        mass=2 * np.eye(3),
        normal=[[0.0, 0, 1]],
        tangent=[[1.0, 0, 0], [0, 1, 0]],
        friction=[0.5],
        free_velocity=[0.3, 0.4, -0.2],
        bias=[0.0],
        dimension=3,
    )
    answer = solve(problem, "interior_point", tol=1e-14)
    assert answer.impulse[0] == pytest.approx([0.4, -0.2 * 0.6, -0.2 * 0.8], abs=1e-13)
    assert problem.velocity(answer.impulse) == pytest.approx([0.3 * 0.8, 0.4 * 0.8, 0.0], abs=1e-13)


@pytest.mark.parametrize("spec", ["interior_point", "relaxation_ip"])
def test_sticking_contact_rounding(spec) -> None:
    """A table on sixteen legs beside a mote that just opens, and is solved when slips are far below the rounding of W r."""
    legs = [(x, y) for x in np.linspace(-1, 1, 4) for y in np.linspace(-1, 1, 4)]
    normal, tangent = np.zeros((17, 9)), np.zeros((34, 9))
    for i, (x, y) in enumerate(legs):
        normal[i, :6] = 0, 0, 1, y, -x, 0
        tangent[2 * i, :6], tangent[2 * i + 1, :6] = (1, 0, 0, 0, 0, -y), (0, 1, 0, 0, 0, x)
    normal[16, 8] = tangent[32, 6] = tangent[33, 7] = 1
    table = FrictionProblem(
        mass=np.diag([1e5] * 6 + [1.0] * 3),
        normal=normal,
        tangent=tangent,
        friction=np.full(17, 0.7),
        free_velocity=[0.1, 0, -1, 0, 0, 0.05, 0, 0, 1e-7],
        bias=np.zeros(17),
        dimension=3,
    )
    known_by_delassus = FrictionProblem.from_delassus(table.W, table.q, table.friction, 3)
    assert_solved(known_by_delassus, spec, tol=1e-10, at_most=40)


def test_a_tall_stack_takes_few_iterations() -> None:
    assert_solved(scene("stack", blocks=400).problem(), "interior_point", at_most=30)
    assert_solved(cubes(400, push=1.0), "interior_point", at_most=25)


@pytest.mark.parametrize("seed", [19, 76, 190, 222, 294])
def test_stagnation_is_resolved_by_path(seed) -> None:
    """Where x s stops at a fold of the central path, with the residual at 1e-2 to 1e-3."""
    assert_solved(random_problem(seed, 1 + seed % 50), "interior_point")


@pytest.mark.parametrize("seed", [3235, 3426, 4496])
def test_folds_of_central_path(seed) -> None:
    assert_solved(random_problem(seed, 1 + seed % 50), "interior_point[shortcut=false]")


def sheared(name, shear, friction, **size) -> FrictionProblem:
    """Bodies upon each other, the faster (shear, 1/s) the higher they are."""
    made = scene(name, friction=friction, **size)
    problem, velocity = made.problem(), made.problem().free_velocity.copy()
    velocity[0::3] += shear * made.q0[1::3]
    return problem.replace(free_velocity=velocity)


@pytest.mark.parametrize("spec", METHODS)
@pytest.mark.parametrize(("friction", "shear"), [(0.7, 1.0), (0.8, 10.0)])
def test_sheared_pyramids_from_gauss_seidel_start(friction, shear, spec) -> None:
    """Without a hint how the boxes are loaded, the central path from any start wound on for thousands of iterations."""
    assert_solved(sheared("pyramid", shear, friction, rows=20), spec, at_most=200)


def test_falling_walls_need_no_path() -> None:
    """Their impulses are far from unique: with a delta of 1e-14 to the end rounding stops the predictor-corrector at 1e-8."""
    problem = scene("wall", rows=16, push=0.0, shear=0.2, fall=1.0).problem()
    answer = solve(problem, "interior_point", tol=1e-8)
    assert residual(problem, answer.impulse) <= 1e-8
    assert answer.work["factorisations"] < 60


@pytest.mark.slow
def test_a_pile_of_discs_takes_a_long_path() -> None:
    """Neither semismooth Newton nor a path of 250 factorisations arrives; the quick tests miss the long paths."""
    assert_solved(scene("disc_pile", rows=20).problem(), "interior_point", at_most=4000)


@pytest.mark.slow
def test_walls_of_boxes_take_long_paths() -> None:
    """All paths of this wall take about 1300 factorisations, four a contact: more than the quick tests' shares."""
    assert_solved(recorded_step("wall_8"), "interior_point", at_most=2500)


@pytest.mark.slow
def test_ten_thousand_sheared_boxes() -> None:
    """With a delta of 1e-13 in place of 1e-14 the residual stopped at 2e-7."""
    assert_solved(sheared("stack", 1e-4, 0.8, blocks=10_000), "interior_point", at_most=100)


@pytest.mark.parametrize("problem", [random_problem(5, 30), random_bodies(5, 60, 0.5), scene("stack", blocks=50).problem()])
def test_near_start_saves_iterations(problem) -> None:
    cold = solve(problem, "interior_point")
    assert solve(problem, "interior_point", start=cold.impulse).work["iterations"] <= 2
    noise = np.random.default_rng(0).standard_normal(cold.impulse.shape)
    near = solve(problem, "interior_point", start=cold.impulse * (1 + 1e-5 * noise))
    assert near.status is Status.SOLVED
    assert near.work["iterations"] <= 0.7 * cold.work["iterations"]


@pytest.mark.parametrize("problem", [random_problem(5, 30), random_bodies(5, 60, 0.5)])
@pytest.mark.parametrize("wrong", [-1.0, 1e12])
def test_far_start_is_harmless(problem, wrong) -> None:
    start = np.full((problem.contacts, problem.dimension), wrong)
    answer = solve(problem, "interior_point", start=start)
    assert answer.status is Status.SOLVED
    assert residual(problem, answer.impulse) <= 1e-8


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
@pytest.mark.parametrize("ratio", [1e-6, 1e3, 1e6])
def test_mass_ratios(ratio, spec) -> None:
    problem = random_problem(8, 20, mass_ratio=max(ratio, 1 / ratio))
    assert_solved(problem.replace(mass=problem.mass * min(ratio, 1.0)), spec)


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_special_cases(spec) -> None:
    pyramid = scene("pyramid", rows=4).problem()
    mixed = pyramid.friction.copy()
    mixed[::2] = 0
    for problem in (
        nothing(),
        block(),
        pyramid.replace(friction=np.zeros(pyramid.contacts)),
        pyramid.replace(friction=mixed),
        pyramid.replace(friction=mixed, friction_bias=np.full(pyramid.contacts, 0.01)),
        pyramid.replace(friction=np.full(pyramid.contacts, 1e-9)),
        pyramid.replace(friction=np.full(pyramid.contacts, 50.0)),
        pyramid.replace(free_velocity=np.zeros(len(pyramid.free_velocity)), bias=np.zeros(pyramid.contacts)),
        pyramid.replace(bias=np.full(pyramid.contacts, 1e3)),
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
    assert_solved(pyramid.replace(joints=rows, joint_bias=np.zeros(4)), spec)
    assert_solved(pyramid.replace(joints=rows[[0, 2]], joint_bias=[0.1, -0.2]), spec)


@pytest.mark.parametrize("spec", METHODS)
def test_unsymmetric_delassus_matrix(spec) -> None:
    known = random_problem(5, 10)
    W = known.W.toarray()
    W += 1e-7 * np.abs(W).max() * np.random.default_rng(0).standard_normal(W.shape)
    assert_solved(FrictionProblem.from_delassus(W, known.q, known.friction, 2), spec, tol=1e-10)


def test_dense_mass_matrix() -> None:
    pyramid = scene("pyramid", rows=4).problem()
    root = np.random.default_rng(0).standard_normal(pyramid.mass.shape)
    assert_solved(pyramid.replace(mass=root @ root.T + np.eye(len(root))), "interior_point")


@pytest.mark.parametrize("seed", [0, 2])
def test_sphere_pyramid_path_direction(seed) -> None:
    """225 contacts of which half slide or open: a path that follows the last tangent goes back to its start."""
    problem = sphere_pyramid(seed, levels=5, friction=0.5)
    answer = solve(problem, "hybrid")
    assert answer.detail == "answered by interior_point"
    assert residual(problem, answer.impulse) <= 1e-8


def test_unit_invariance() -> None:
    problem = random_problem(7, 12)
    heavy = problem.replace(mass=problem.mass * 1e9)
    slow = problem.replace(free_velocity=problem.free_velocity * 1e-6, bias=problem.bias * 1e-6)
    expected = solve(problem, "interior_point", tol=1e-11)
    for other, factor in ((heavy, 1e9), (slow, 1e-6)):
        velocity = other.velocity(solve(other, "interior_point", tol=1e-11).impulse)
        unit = 1.0 if other is heavy else factor
        assert np.allclose(velocity / unit, problem.velocity(expected.impulse), rtol=0, atol=1e-8)


def test_unreachable_tolerance_is_not_claimed() -> None:
    answer = solve(random_problem(1, 30), "interior_point", tol=1e-300)
    assert answer.status in (Status.STALLED, Status.WORK_LIMIT)
    assert residual(random_problem(1, 30), answer.impulse) < 1e-12


def test_hidden_rounding_is_not_claimed() -> None:
    """A jam in which internal impulses may grow to 1e8, where rounding hides a residual of 7e-8."""
    assert_solved(random_problem(414, 15, mass_ratio=1e4), "interior_point")


@pytest.mark.parametrize("spec", [*METHODS, "relaxation_ip"])
def test_limit_bounds_factorisations(spec) -> None:
    answer = solve(scene("stack", blocks=50).problem(), spec, limit=3)
    assert answer.status is Status.WORK_LIMIT
    assert answer.work["factorisations"] <= 3


def test_relaxation_differs_for_sliding_block() -> None:
    """AP: a sliding block keeps to the ground; the relaxation lifts it by mu u_t (FACTS, relaxation artefact)."""
    problem = block(speed=1.0, friction=0.5)
    exact = problem.contact_velocity(solve(problem, "interior_point", tol=1e-12).impulse)
    relaxed = problem.contact_velocity(solve(problem, "relaxation_ip", tol=1e-12).impulse)
    assert exact[0] == pytest.approx([0.0, 1 - 0.5 * 0.0981], abs=1e-10)
    assert relaxed[0, 0] == pytest.approx(0.5 * relaxed[0, 1], abs=1e-10)


def with_every_kind_of_contact(dimension, joints=0) -> FrictionProblem:
    """Friction biases, a frictionless contact and joints."""
    known = random_problem(3, 8, bodies=9) if dimension == 2 else spatial(3, contacts=8, nv=27)
    friction, bias = known.friction.copy(), np.arange(8.0)
    friction[:2] = bias[:1] = 0
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


def test_longest_step_planar() -> None:
    system, space = build_system(random_problem(0, 3)), None
    point, step = start_point(system, 1.0, 1.0), new_point(system)
    assert longest(system, space, point, step, 1.0) == 1.0
    step.x[1, 2] = -4 * point.x[1, 2]
    step.s[0, 1] = -2 * point.s[0, 1]
    assert longest(system, space, point, step, 1.0) == pytest.approx(0.25)


@pytest.mark.parametrize("seed", range(5))
def test_longest_step_spatial(seed) -> None:
    random = np.random.default_rng(seed)
    for _ in range(200):
        a, step = random.standard_normal((2, 3))
        a[0] = np.hypot(a[1], a[2]) * (1 + random.random() ** 4)
        length = longest_in_cone(tuple(a), tuple(step), 10.0)
        end = a + length * step
        inside = end[0] - np.hypot(end[1], end[2])
        assert inside == pytest.approx(0, abs=1e-12) if length < 10 else inside >= 0
        before = a + 0.99 * length * step
        assert before[0] >= np.hypot(before[1], before[2])


def root(a):
    """The square roots of elements a (n, 3) of Lorentz' cone."""
    size = np.hypot(a[:, 1], a[:, 2])
    high, low = np.sqrt(a[:, 0] + size), np.sqrt(a[:, 0] - size)
    along = np.where(size > 0, (high - low) / (2 * np.where(size > 0, size, 1)), 0)
    return np.column_stack([(high + low) / 2, along * a[:, 1], along * a[:, 2]])


def quadratic(a, b):
    """Q(a) b = 2 (a . b) a - det(a) (b_0, -b_t)."""
    det = a[:, 0] ** 2 - a[:, 1] ** 2 - a[:, 2] ** 2
    return 2 * (a * b).sum(axis=1)[:, None] * a - det[:, None] * b * np.array([1, -1, -1])


@pytest.mark.parametrize("dimension", [2, 3])
def test_scaled_step_norm(dimension) -> None:
    system = build_system(with_every_kind_of_contact(dimension, joints=1))
    point, step = start_point(system, 1.0, 2.0), new_point(system)
    random = np.random.default_rng(0)
    rubs = system.pairs > 1
    for values, change in ((point.x, step.x), (point.s, step.s)):
        if dimension == 3:
            values[rubs, 1:3] = random.uniform(-0.3, 0.3, (rubs.sum(), 2)) * point.s[rubs, 3:]
        change[:, 0] = random.standard_normal(8)
        change[rubs, 1:] = random.standard_normal((rubs.sum(), 3))
    w = Point(*map(np.copy, step))
    to_geodesics(system, space_of(system), point, w)
    for values, change, measured in ((point.x, step.x, w.x), (point.s, step.s, w.s)):
        assert np.allclose(values[:, 0] * measured[:, 0], change[:, 0])
        if dimension == 2:
            assert np.allclose(values[rubs] * measured[rubs], change[rubs])
    if dimension == 3:
        y = [np.column_stack([at.s[rubs, 3], at.x[rubs, 1:3]]) for at in (point, step, w)]
        z = [np.column_stack([at.x[rubs, 3], at.s[rubs, 1:3]]) for at in (point, step, w)]
        for values, change, measured in (y, z):
            assert np.allclose(quadratic(root(values), measured), change)


def from_lcp(M, q) -> FrictionProblem:
    """The friction problem of a friction LCP in (c, beta, lambda)."""
    nc = len(q) // 4
    owner = M[nc : 3 * nc, 3 * nc :].argmax(axis=1)
    tangent = nc + np.array([np.flatnonzero(owner == i)[0] for i in range(nc)])
    rows = np.column_stack([np.arange(nc), tangent]).ravel()
    return FrictionProblem.from_delassus(M[np.ix_(rows, rows)], q[rows], M[3 * nc :, :nc].diagonal(), 2)


@pytest.mark.parametrize("spec", METHODS)
@pytest.mark.parametrize(("name", "instances"), [("bar", 11), ("blocks", 4)])
def test_recorded_false_ray_steps(name, instances, spec) -> None:
    with np.load(DATA / f"false_rays_{name}.npz") as data:
        for k in range(instances):
            assert_solved(from_lcp(data[f"M{k}"], data[f"q{k}"]), spec)


@pytest.mark.parametrize("spec", METHODS)
def test_recorded_step_near_a_jam(spec) -> None:
    assert_solved(recorded_step("near_jam"), spec)


def test_chain_joints_are_sparse() -> None:
    nv = 40
    rows = sparse.diags_array([np.ones(nv - 1), -np.ones(nv - 1)], offsets=[0, 1], shape=(nv - 1, nv))
    normal = sparse.csr_array(([1.0], ([0], [0])), shape=(1, nv))
    tangent = sparse.csr_array(([1.0], ([0], [nv - 1])), shape=(1, nv))
    problem = FrictionProblem(
        mass=np.eye(nv), normal=normal, tangent=tangent, friction=[0.3], free_velocity=-np.ones(nv), bias=[0.0], joints=rows
    )
    assert build_system(problem).fronts.start[-1] < 16 * nv
    assert_solved(problem, "interior_point")


def test_what_each_phase_finds_is_polished() -> None:
    """Also where another one came nearer from which polishing failed."""
    problem = sphere_pyramid(0, levels=3, friction=0.5)
    prepared = find("interior_point")[1].prepare(problem)
    right = solve(problem, "interior_point", tol=1e-12).impulse
    nearer, farther = (right * (1 + off * np.random.default_rng(0).standard_normal(right.shape)) for off in (1e-7, 1e-6))

    def leaving(impulse):
        def leave(system, space, point, work, best, tol, patience, history):
            best.impulse[:], history[0] = impulse / system.impulse, 1.0
            return 1

        return leave, new_point(prepared[1]), 10

    def polish(impulse):
        return right if residual(problem, impulse) > 2 * residual(problem, nearer) else impulse

    answer = run(prepared, [leaving(nearer), leaving(farther)], 1e-8, 20, 12, residual, polish)
    assert answer.status is Status.SOLVED
    assert residual(problem, answer.impulse) <= 1e-8
    assert run(prepared, [leaving(nearer), leaving(farther)], 1e-8, 20, 12, residual).impulse == pytest.approx(nearer)


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


def test_path_is_followed_further() -> None:
    """In shares a path takes the same way as at once, to its end."""
    system = build_system(sphere_pyramid(0, levels=3, friction=0.5))
    at_once, in_shares, work = _path(system), _path(system), new_work(system, np.inf)
    best, again = nothing_yet(*system.offset.shape), nothing_yet(*system.offset.shape)
    history = np.empty(12)
    trace(system, True, at_once, work, best, 0.0, 12, history)
    for share in (1, 4, 7):
        trace(system, True, in_shares, work, again, 0.0, 12, history[:share])
    assert np.array_equal(in_shares.point.x, at_once.point.x)
    assert best.factorisations == again.factorisations == 12
    assert not in_shares.ended
    trace(system, True, in_shares, work, again, 1e-4, 12, np.empty(1000))
    assert again.residual <= 1e-4
    assert in_shares.ended


def _path(system):
    return new_path(start_point(system, 1.5, 5.0))


def test_no_start_is_followed_long_before_others() -> None:
    """Paths of this pyramid from nothing and around Gauss-Seidel take more than a thousand, one around the relaxation 141."""
    problem = sphere_pyramid(0, levels=6, friction=0.5)
    answer = solve(problem, "interior_point")
    assert residual(problem, answer.impulse) <= 1e-8
    assert answer.work["factorisations"] < 700


@pytest.mark.parametrize("friction", [0.7, 1.0])
def test_sphere_pyramid_solved_by_relaxation(friction) -> None:
    problem = sphere_pyramid(0, levels=5, friction=friction)
    answer = solve(problem, "interior_point")
    assert residual(problem, answer.impulse) <= 1e-8
    assert answer.work["factorisations"] < 60
    assert 0 < answer.work["relaxation_ip factorisations"] < 40


@pytest.mark.parametrize(
    ("seed", "levels", "friction", "noise"),
    [(0, 4, 0.5, 0.0), (1, 5, 1.0, 0.03), (2, 6, 0.7, 0.03)],
)
def test_sphere_pyramid_solved_by_paths(seed, levels, friction, noise) -> None:
    assert_solved(sphere_pyramid(seed, levels=levels, friction=friction, noise=noise), "interior_point", at_most=5000)


@pytest.mark.parametrize("seed", [0, 19, 38])
def test_unbounded_friction_solved_by_paths(seed) -> None:
    assert_solved(random_bodies(seed, contacts=40, friction=1000.0), "interior_point")


def test_unconnected_parts_are_solved_one_by_one() -> None:
    """Hundreds of parts in some of which the predictor-corrector is trapped: no path solves them all at once."""
    problem = local_graph(seed=1, bodies=5000)
    answer = solve(problem, "interior_point")
    assert answer.status is Status.SOLVED
    assert residual(problem, answer.impulse) <= 1e-8


def test_internal_residual_counts_signorinis_own_defect() -> None:
    """Of a large mu, the cone's defect is smaller by up to sqrt(1 + mu^2)."""
    problem = FrictionProblem(
        mass=np.eye(2), normal=[[1.0, 0.0]], tangent=[[0.0, 1.0]], friction=[30.0], free_velocity=[-0.1, -1.0], bias=[0.0]
    )
    system = build_system(problem)
    point, work = start_point(system, 1.0, 1.0), new_work(system, np.inf)
    for c in (0.0, 0.02, 0.05, 0.09):
        point.x[:] = c, 0.0, 0.0, 1.0
        inside = evaluate_point(system, space_of(system), point, new_point(system), work)
        assert inside == pytest.approx(residual(problem, work.impulse * system.impulse), rel=1e-10)


@pytest.mark.parametrize("seed", [0, 4])
def test_light_spheres_carry_heavy_ones(seed) -> None:
    assert_solved(sphere_pyramid(seed=seed, levels=4, friction=0.5, mass_ratio=1e6), "interior_point", at_most=500)
