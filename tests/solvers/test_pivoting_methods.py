"""What the pivoting methods share: LCPs of the literature, steps on which round-off misleads, and problems without solution."""

import numpy as np
import pytest

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.scenes import scene
from frictionbench.solvers.interface import Status, solve
from tests.helpers.friction_problems import nothing, with_joints
from tests.helpers.lcps import assert_solved, murty_family
from tests.helpers.paths import DATA

LEMKE = ("lemke", "lemke[restarts=0]")
PATH = ("path_search", "path_search[crash=0]", "path_search[proximal=0.01]")
PRINCIPAL = ("dantzig", "murty")
FALSE_RAYS = [(name, i) for name, count in (("bar", 11), ("blocks", 4)) for i in range(count)]


P_MATRICES = {
    "Kostreva 1979, where naive ties cycle": ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1], [1 / 3, 1 / 3, 1 / 3]),
    "Murty's exponential family": murty_family(8),
}
LITERATURE = P_MATRICES | {
    "Murty 1988, example 2.8": ([[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]], [3, 5, -9, -5], [2, 1, 3, 1]),
    "PATHSolver.jl's": ([[0, 0, -1, -1], [0, 0, 1, -2], [1, -1, 2, -2], [1, 2, -2, 4]], [2, 2, -2, -6], [2.8, 0, 0.8, 1.2]),
    "Cottle, Pang and Stone 2009, 4.4.7, not copositive": ([[0, -1, 2], [2, 0, -2], [-1, 1, 0]], [-3, 6, -1], [0, 1, 3]),
    "Floudas and Pardalos 10.2.9, l = 10": (
        [[11, 0, 10, -1], [0, 11, 10, -1], [10, 10, 21, -1], [1, 1, 1, 0]],
        [50, 50, 10, -6],
        [2, 2, 2, 92],
    ),
}
# Floudas and Pardalos, 10.2.4: M >= 0 with a zero diagonal. There are solutions, but a ray from every covering vector.
BIMATRIX = LCP([[0, 0, 10, 20], [0, 0, 30, 15], [10, 20, 0, 0], [30, 15, 0, 0]], [-1, -1, -1, -1])
UNSOLVABLE = {
    "Murty 1988, 2.9": LCP([[-1, 0, -3], [1, -2, -5], [-2, -1, -2]], [-3, -2, -1]),
    "lemkelcp's readme": LCP([[2, -1], [0, -2]], [-1, -2]),
    "zero": LCP([[0]], [-1]),
}


@pytest.mark.parametrize(
    ("spec", "name"),
    [(spec, name) for spec in LEMKE + PATH for name in LITERATURE]
    + [(spec, name) for spec in PRINCIPAL for name in P_MATRICES],
)
def test_finds_the_solution_of_the_literature(spec, name):
    M, q, z = LITERATURE[name]
    lcp = LCP(M, q)
    answer = solve(lcp, spec)
    assert answer.status is Status.SOLVED
    assert lcp.residual(answer.z) < 1e-12
    np.testing.assert_allclose(answer.z, z, atol=1e-10)


@pytest.mark.parametrize("spec", ["lemke[restarts=0]", "path_search"])
@pytest.mark.parametrize(("name", "i"), FALSE_RAYS)
def test_false_rays_of_a_plain_tableau(name, i, spec):
    """Steps of a long bar on posts and of three blocks on which a plain dense tableau ended on a ray through round-off."""
    data = np.load(DATA / f"false_rays_{name}.npz")
    lcp = LCP(data[f"M{i}"], data[f"q{i}"])
    answer = solve(lcp, spec)
    assert answer.status is Status.SOLVED
    assert lcp.residual(answer.z) <= 1e-10


@pytest.mark.parametrize("spec", ["lemke", "path_search", *PRINCIPAL])
@pytest.mark.parametrize("name", UNSOLVABLE)
def test_without_a_solution_none_is_claimed(name, spec):
    status = solve(UNSOLVABLE[name], spec).status
    assert status is Status.RAY if spec == "lemke" else status is not Status.SOLVED


def test_a_bimatrix_game_ends_on_a_ray_though_there_are_solutions():
    assert solve(BIMATRIX, "lemke").status is Status.RAY
    assert solve(BIMATRIX, "lemke[restarts=0]").work["pivots"] == 1
    for spec in PATH:
        assert BIMATRIX.residual(solve(BIMATRIX, spec).z) < 1e-12


@pytest.mark.parametrize("spec", ["lemke", "path_search", *PRINCIPAL])
def test_a_particle_jammed_between_two_walls(spec):
    for bias, solvable in (((-0.1, -0.1), False), ((-0.1, 0.1), True)):
        walls = {"normal": [[1, 0], [-1, 0]], "tangent": [[0, 1], [0, 1]], "friction": [0.5, 0.5], "free_velocity": [0, 1]}
        status = solve(FrictionProblem(mass=np.eye(2), **walls, bias=bias), spec).status
        if spec in PRINCIPAL:
            assert solvable or status is not Status.SOLVED
        else:
            assert status is (Status.SOLVED if solvable else Status.INFEASIBLE)


@pytest.mark.parametrize("spec", ["lemke", "path_search", *PRINCIPAL])
def test_edge_cases(spec):
    for problem in (nothing(), nothing(3), LCP(np.zeros((0, 0)), [])):
        assert solve(problem, spec).status is Status.SOLVED
    assert solve(LCP(np.zeros((2, 2)), [0.0, 1.0]), spec).z == pytest.approx([0, 0])
    apart = solve(LCP(np.eye(3), [1, 0, 2]), spec)
    assert apart.work["pivots"] == 0
    assert not apart.z.any()
    limited = solve(random_problem(7, contacts=40), spec, limit=5)
    assert limited.status is Status.WORK_LIMIT
    assert limited.work["pivots"] == 5


@pytest.mark.parametrize(("spec", "tol"), [("lemke", 1e-11), ("path_search", 1e-8)])
@pytest.mark.parametrize("mu", [0.0, 0.05, 0.5, 10.0])
def test_stacks_and_pyramids_with_exact_ties(mu, spec, tol):
    for push in (0.0, 0.3, 1.0):
        for blocks in (1, 4, 10, 50):
            assert_solved(scene("stack", blocks=blocks, friction=mu, push=push).problem(), spec, tol)
        for rows in (2, 6):
            assert_solved(scene("pyramid", rows=rows, friction=mu, push=push).problem(), spec, tol)


@pytest.mark.parametrize("spec", ["lemke", "path_search"])
@pytest.mark.parametrize("ratio", [1e-6, 1e3, 1e6])
def test_mass_ratios(ratio, spec):
    """Impulses have sixteen digits, so that what a light body feels under heavy ones is known to 1e-16 times the ratio."""
    for blocks, mu in ((2, 0.05), (5, 2.0), (10, 1.0), (25, 1.0)):
        problem = scene("stack", blocks=blocks, mass_ratio=ratio, push=0.1, friction=mu).problem()
        assert_solved(problem, spec, max(1e-10, 1e-14 * ratio) if spec == "lemke" else 1e-8)


@pytest.mark.parametrize(("spec", "tol"), [("lemke", 1e-11), ("path_search", 1e-8)])
def test_random_problems(spec, tol):
    """Mu to 10, more contacts than freedoms; b >= 0, so that each has a solution to which Lemke's method leads."""
    problems = [random_problem(seed, contacts=1 + seed % 50) for seed in range(100)]
    assert sum(assert_solved(problem, spec, tol).work["restarts"] for problem in problems) <= 2
    for seed in range(100) if spec == "lemke" else ():
        assert_solved(random_problem(seed, contacts=1 + seed % 50, mass_ratio=1e6), spec, 1e-9)


@pytest.mark.parametrize("spec", ["lemke", "path_search"])
def test_joints_and_a_friction_bias(spec):
    """Poisson's decompression: friction is there without a normal impulse of this step."""
    random = np.random.default_rng(0)
    for seed in range(20):
        problem = random_problem(seed, contacts=12)
        nv = problem.mass.shape[0]
        joints = random.standard_normal((min(2, nv - 1) if seed % 2 else 0, nv))
        assert_solved(with_joints(problem, joints, random.random(12)), spec)
