"""Path search: LCPs of the literature, exact ties, rank deficiency, status of failures; its basis and its path."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import Status, find, solve
from frictionbench.solvers.pivots.lu_basis import (
    Columns,
    basic_z,
    column,
    factorise_basis,
    ftran,
    new_basis,
    orientation,
    replace_column,
    set_complementary_basis,
)
from frictionbench.solvers.pivots.natural import MARGIN, natural_residual, natural_weight
from frictionbench.solvers.pivots.newton_path import is_ray
from frictionbench.solvers.pivots.scaling import scaling
from tests.helpers.friction_problems import block, nothing, spatial, with_joints
from tests.helpers.paths import DATA

FALSE_RAYS = [(name, i) for name, count in (("bar", 11), ("blocks", 4)) for i in range(count)]
LITERATURE = {
    "Kostreva 1979, where naive ties cycle": ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1], [1 / 3, 1 / 3, 1 / 3]),
    "Murty 1988, example 2.8": (
        [[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]],
        [3, 5, -9, -5],
        [2, 1, 3, 1],
    ),
    "Cottle, Pang and Stone 2009, not copositive": ([[0, -1, 2], [2, 0, -2], [-1, 1, 0]], [-3, 6, -1], [0, 1, 3]),
    "bimatrix game, a ray from every covering vector": (
        [[0, 0, 10, 20], [0, 0, 30, 15], [10, 20, 0, 0], [30, 15, 0, 0]],
        [-1, -1, -1, -1],
        None,
    ),
    "PATHSolver.jl's example": (
        [[0, 0, -1, -1], [0, 0, 1, -2], [1, -1, 2, -2], [1, 2, -2, 4]],
        [2, 2, -2, -6],
        [2.8, 0, 0.8, 1.2],
    ),
    "rank one": ([[1, 1], [1, 1]], [-1, -1], None),
    "Murty's exponential family, n = 5": (
        2 * np.tril(np.ones((5, 5)), -1) + np.eye(5),
        [-32, -48, -56, -60, -62],
        [32, 0, 0, 0, 0],
    ),
}


def assert_solved(problem, spec="path_search") -> dict[str, int]:
    answer = solve(problem, spec)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)  # of extreme masses and near jams
    assert residual(problem, answer.impulse) < 1e-8
    return answer.work


@pytest.mark.parametrize("spec", ["path_search", "path_search[crash=0]", "path_search[proximal=0.01]"])
@pytest.mark.parametrize("name", LITERATURE)
def test_literature(name, spec) -> None:
    M, q, z = LITERATURE[name]
    lcp = LCP(M, q)
    answer = solve(lcp, spec)
    assert answer.status is Status.SOLVED
    assert lcp.residual(answer.z) < 1e-12
    if z is not None:
        assert answer.z == pytest.approx(z, abs=1e-10)


@pytest.mark.parametrize(
    ("M", "q"),
    [([[-1, 0, -3], [1, -2, -5], [-2, -1, -2]], [-3, -2, -1]), ([[2, -1], [0, -2]], [-1, -2])],
    ids=["Murty 1988, example 2.9", "lemkelcp's readme"],
)
def test_without_a_solution_none_is_claimed(M, q) -> None:
    assert solve(LCP(M, q), "path_search").status in (Status.STALLED, Status.RAY)


@pytest.mark.parametrize(("bias", "status"), [((-0.1, -0.1), Status.RAY), ((-0.1, 0.1), Status.SOLVED)])
def test_a_particle_jammed_between_two_walls(bias, status) -> None:
    jam = FrictionProblem(
        mass=np.eye(2),
        normal=[[1, 0], [-1, 0]],
        tangent=[[0, 1], [0, 1]],
        friction=[0.5, 0.5],
        free_velocity=[0, 1],
        bias=bias,
    )
    assert solve(jam, "path_search").status is status


def test_random_problems() -> None:
    work = [assert_solved(random_problem(seed, contacts=1 + seed % 50)) for seed in range(150)]
    assert sum(count["restarts"] for count in work) <= 2


@pytest.mark.parametrize("spec", ["path_search[crash=0]", "path_search[proximal=0.01]"])
def test_random_problems_of_varied_size(spec) -> None:
    work = [assert_solved(random_problem(seed, contacts=1 + seed % 25), spec) for seed in range(300, 350)]
    proximal = sum(count["newton"] > 1 for count in work)
    assert proximal == 0 if "crash" in spec else proximal > 10


@pytest.mark.parametrize("mu", [0.05, 0.5, 10.0])
@pytest.mark.parametrize("push", [0.0, 0.3])
def test_stacks_and_pyramids_with_exact_ties(mu, push) -> None:
    for blocks in (1, 4, 25):
        assert_solved(scene("stack", blocks=blocks, friction=mu, push=push).problem())
    for rows in (2, 6):
        assert_solved(scene("pyramid", rows=rows, friction=mu, push=push).problem())


@pytest.mark.parametrize("ratio", [1e-6, 1e3, 1e6])
def test_extreme_mass_ratios(ratio) -> None:
    for blocks in (2, 10, 25):
        assert_solved(scene("stack", blocks=blocks, mass_ratio=ratio, push=0.1, friction=1.0).problem())


def test_ill_conditioned_last_basis() -> None:
    """Condition 1e10: the exact basic solution is 1e-4 off, the end of the path 1e-10."""
    assert_solved(scene("stack", blocks=25, mass_ratio=1e5, push=0.1, friction=0.5).problem())


def test_path_stopped_by_round_off() -> None:
    """23 contacts on 12 freedoms: t comes to 1 - 1e-14 and stays there while pivots go on in W's null space."""
    assert assert_solved(random_problem(772, contacts=23), "path_search[crash=0]")["restarts"] == 0


@pytest.mark.parametrize(("name", "i"), FALSE_RAYS)
def test_false_rays_of_plain_tableau(name, i) -> None:
    data = np.load(DATA / f"false_rays_{name}.npz")
    lcp = LCP(data[f"M{i}"], data[f"q{i}"])
    answer = solve(lcp, "path_search")
    assert answer.status is Status.SOLVED
    assert lcp.residual(answer.z) < 1e-10


def test_edges() -> None:
    for problem in (nothing(), nothing(3), LCP(np.zeros((0, 0)), [])):
        assert solve(problem, "path_search").status is Status.SOLVED
    assert solve(LCP(np.zeros((2, 2)), [0.0, 1.0]), "path_search").z == pytest.approx([0, 0])
    assert_solved(block(friction=0.0))
    separating = solve(random_problem(0, contacts=3, friction=0.0), "path_search")
    assert separating.status is Status.SOLVED


def test_joints_and_a_friction_bias() -> None:
    random = np.random.default_rng(0)
    for seed in range(20):
        problem = random_problem(seed, contacts=12)
        nv = problem.mass.shape[0]
        assert_solved(with_joints(problem, random.standard_normal((min(2, nv - 1), nv)), 0.3 * random.random(12)))


def test_spatial_contacts_are_solved_as_their_polygonal_model() -> None:
    for seed in range(10):
        problem = spatial(seed, friction_bias=True)
        answer = solve(problem, "path_search")
        assert answer.status is Status.SOLVED
        assert problem.lcp().residual(answer.z) < 1e-12


def test_the_limit_bounds_the_pivots() -> None:
    answer = solve(random_problem(7, contacts=40), "path_search", limit=5)
    assert answer.status is Status.WORK_LIMIT
    assert answer.work["pivots"] == 5


def test_work_is_deterministic_and_prepared_is_reusable() -> None:
    _, solver = find("path_search")
    prepared = solver.prepare(random_problem(3, contacts=40))
    first, second = (solver.solve(prepared, 1e-8, None) for _ in range(2))
    assert first.work == second.work
    assert np.array_equal(first.z, second.z)
    assert first.work["crash"] > 0
    assert first.work["newton"] == 1


def test_crash_start_shortens_path() -> None:
    problems = [random_problem(seed, contacts=30) for seed in range(20)]
    pivots = [sum(solve(p, spec).work["pivots"] for p in problems) for spec in ("path_search", "path_search[crash=0]")]
    assert pivots[0] < 0.95 * pivots[1]


def random_columns(n, rank, seed=0) -> tuple[Columns, np.ndarray]:
    """The columns of a sparse M with dependent columns, and [M + prox, -I, cover] dense."""
    random = np.random.default_rng(seed)
    M = random.standard_normal((n, rank)) @ (random.standard_normal((rank, n)) * (random.random((rank, n)) < 0.5))
    packed, prox, cover = sparse.csc_array(M), np.zeros(n), random.standard_normal(n)
    columns = Columns(packed.indptr.astype(np.int64), packed.indices.astype(np.int64), packed.data, prox, cover)
    return columns, np.column_stack([M, -np.eye(n), cover])


def test_small_pivots_of_long_stacks_are_taken_without_new_factors() -> None:
    answer = solve(scene("stack", blocks=600, push=1.0).problem(), "path_search")
    assert answer.status is Status.SOLVED
    assert answer.work["factorisations"] < answer.work["pivots"] / 60


def test_a_basis_solves_and_is_updated() -> None:
    n, random = 20, np.random.default_rng(1)
    columns, dense = random_columns(n, n)
    few = {"update": np.empty((4, n)), "updated": np.zeros(4, np.int64)}
    basis, A = new_basis(n)._replace(**few), random.random(n) < 0.5
    set_complementary_basis(basis, A)
    assert factorise_basis(basis, columns, 1e-12) == 0
    for position, entering in ((3, 2 * n), (5, int(np.flatnonzero(~A)[0])), (7, n + int(np.flatnonzero(A)[0]))):
        d = np.empty(n)
        column(columns, entering, d)
        ftran(basis, columns, d)
        replace_column(basis, position, entering, d)
        y = random.standard_normal(n)
        x = y.copy()
        ftran(basis, columns, x)
        assert dense[:, basis.head] @ x == pytest.approx(y, abs=1e-8)
    assert factorise_basis(basis, columns, 1e-12) == 0
    x = y.copy()
    ftran(basis, columns, x)
    assert dense[:, basis.head] @ x == pytest.approx(y, abs=1e-8)


def test_dependent_columns_are_left_out() -> None:
    n, rank = 12, 5
    columns, dense = random_columns(n, rank)
    basis = new_basis(n)
    set_complementary_basis(basis, np.ones(n, bool))
    assert factorise_basis(basis, columns, 1e-9) == n - rank
    assert np.linalg.cond(dense[:, basis.head]) < 1e6
    A = np.empty(n, bool)
    basic_z(basis, A)
    assert A.sum() == rank


def test_orientation_is_the_sign_of_the_determinant() -> None:
    signs = []
    for seed in range(40):
        n, random = 8, np.random.default_rng(seed)
        columns, dense = random_columns(n, n, seed)
        A = random.random(n) < 0.6
        basis = new_basis(n)
        set_complementary_basis(basis, A)
        if factorise_basis(basis, columns, 1e-9) == 0:
            signs.append((orientation(basis), np.sign(np.linalg.det(dense[np.ix_(A, A)])) if A.any() else 1))
    assert len(signs) > 10
    assert {1, -1} == {sign for sign, _ in signs}
    assert all(sign == expected for sign, expected in signs)


def test_ray_classification() -> None:
    columns, _ = random_columns(6, 6)
    assert not is_ray(columns, np.ones(6))
    assert not is_ray(columns, np.zeros(6))
    sliding = sparse.csc_array(block().lcp().M)
    columns = Columns(sliding.indptr.astype(np.int64), sliding.indices.astype(np.int64), sliding.data, np.zeros(4), np.zeros(4))
    assert is_ray(columns, np.array([0.0, 0.0, 0.0, 1.0]))  # the sliding speed lambda, which copositive-plus would forbid


def test_natural_residual_unit_invariance() -> None:
    """Grams for kilograms change M, z and the LCP's residual by 1000; a millionfold mass ratio drowns no contact."""
    problem = random_problem(4, contacts=8, mass_ratio=1e6)
    small = FrictionProblem.from_delassus(1e-3 * problem.W, problem.q, problem.friction, 2)
    z = np.random.default_rng(0).random(32)
    measured = []
    for same, impulse_unit in ((problem, 1.0), (small, 1e3)):
        lcp = same.lcp()
        scale, unit = scaling(lcp), np.r_[np.full(24, impulse_unit), np.ones(8)]
        y = unit * z / (scale.theta * scale.D)
        w = scale.matrix(lcp.dense) @ y + scale.vector(lcp.q)
        measured.append(natural_residual(natural_weight(same, lcp, scale), y, w))
    assert measured[0] == pytest.approx(measured[1], rel=1e-9)


def test_natural_residual_bounds() -> None:
    random = np.random.default_rng(0)
    for seed in range(60):
        problem = random_problem(seed, contacts=1 + seed % 10, mass_ratio=1e4)
        lcp = problem.lcp()
        scale = scaling(lcp)
        y = np.maximum(solve(lcp, "path_search").z / (scale.theta * scale.D) + 1e-3 * random.standard_normal(lcp.size), 0)
        w = scale.matrix(lcp.dense) @ y + scale.vector(lcp.q)
        exact = residual(problem, lcp.impulse(scale.solution(y)))
        assert exact <= natural_residual(natural_weight(problem, lcp, scale), y, w) / MARGIN
