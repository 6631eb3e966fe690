"""Lemke's method: pivot counts from the literature, friction problems with exact ties, and rays."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual, residual_with_floor
from frictionbench.problems.scenes import scene
from frictionbench.solvers.interface import Status, solve
from tests.helpers.paths import DATA

FALSE_RAYS = [(name, i) for name, count in (("bar", 11), ("blocks", 4)) for i in range(count)]


def murty(n):
    """Murty 1988, chapter 6: Lemke's method with d = 1 takes 2^n pivots to z = 2^n e_1."""
    return LCP(2 * np.tril(np.ones((n, n)), -1) + np.eye(n), -np.cumsum(2.0 ** np.arange(n, 0, -1)))


def fathi(n):
    """Fathi 1979: M = L L' with Murty's L, symmetric positive definite, q = -1, where every row ties at the start."""
    L = 2 * np.tril(np.ones((n, n)), -1) + np.eye(n)
    return LCP(L @ L.T, -np.ones(n))


def boxes(contacts, centres, mu, mass=None, push=0.0, jitter=0.0):
    """Unit boxes on each other; contacts: (upper, lower or -1, x, y), all with vertical normals. One step under gravity."""
    random = np.random.default_rng(0)
    nb, nc = len(centres), len(contacts)
    mass = np.ones(nb) if mass is None else mass
    normal, tangent = np.zeros((nc, 3 * nb)), np.zeros((nc, 3 * nb))
    for k, (upper, lower, *at) in enumerate(contacts):
        point = np.array(at) + jitter * random.standard_normal(2)
        for body, sign in ((upper, 1.0), (lower, -1.0)):
            if body >= 0:
                x, y = point - centres[body]
                normal[k, 3 * body : 3 * body + 3] = sign * np.array([0, 1, x])
                tangent[k, 3 * body : 3 * body + 3] = sign * np.array([1, 0, -y])
    velocity = np.zeros((nb, 3))
    velocity[:, 0], velocity[:, 1] = push * np.linspace(0, 1, nb), -0.0981
    return FrictionProblem(
        mass=sparse.diags_array(np.column_stack([mass, mass, mass / 6]).ravel()),
        normal=normal,
        tangent=tangent,
        friction=np.full(nc, mu),
        free_velocity=velocity.ravel(),
        bias=np.zeros(nc),
    )


def stack(n, mu=0.5, ratio=1.0, **how):
    """n boxes with two contacts an interface, the top one `ratio` times as heavy as the lowest: hyperstatic, all ties exact."""
    contacts = [(i, i - 1, x, float(i)) for i in range(n) for x in (-0.5, 0.5)]
    return boxes(contacts, [(0, i + 0.5) for i in range(n)], mu, np.geomspace(1, ratio, n), **how)


def pyramid(rows, mu=0.5, **how):
    """Rows of boxes, every box on two halves."""
    at = [(r, c) for r in range(rows) for c in range(rows - r)]
    box = {rc: i for i, rc in enumerate(at)}
    contacts = []
    for (r, c), i in box.items():
        x = 1.1 * c + 0.55 * r
        below = [(-1, (-0.5, 0.5))] if r == 0 else [(box[r - 1, c], (-0.5, -0.05)), (box[r - 1, c + 1], (0.05, 0.5))]
        contacts += [(i, lower, x + dx, float(r)) for lower, sides in below for dx in sides]
    return boxes(contacts, [(1.1 * c + 0.55 * r, r + 0.5) for r, c in at], mu, **how)


def assert_solved(problem, answer, tol=1e-11):
    assert answer.status in (Status.SOLVED, Status.ROUNDING)  # of extreme masses and near jams
    if isinstance(problem, LCP):
        assert problem.residual(answer.z) <= tol
    else:
        assert residual(problem, answer.impulse) <= tol


CLASSICS = {
    "kostreva cycles without a rule for ties": ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1], [1 / 3, 1 / 3, 1 / 3]),
    "murty 2.8": ([[1, -1, -1, -1], [-1, 1, -1, -1], [1, 1, 2, 0], [1, 1, 0, 2]], [3, 5, -9, -5], [2, 1, 3, 1]),
    "zero blocks": ([[0, 0, -1, -1], [0, 0, 1, -2], [1, -1, 2, -2], [1, 2, -2, 4]], [2, 2, -2, -6], [2.8, 0, 0.8, 1.2]),
    "cottle pang stone 4.4.7": ([[0, -1, 2], [2, 0, -2], [-1, 1, 0]], [-3, 6, -1], [0, 1, 3]),
    "handbook 10.2.9, l = 10": (
        [[11, 0, 10, -1], [0, 11, 10, -1], [10, 10, 21, -1], [1, 1, 1, 0]],
        [50, 50, 10, -6],
        [2, 2, 2, 92],
    ),
}


@pytest.mark.parametrize("name", CLASSICS)
def test_finds_the_solution_of_the_literature(name):
    M, q, z = CLASSICS[name]
    lcp = LCP(M, q)
    answer = solve(lcp, "lemke")
    assert_solved(lcp, answer)
    np.testing.assert_allclose(answer.z, z, atol=1e-12)


def test_takes_two_to_the_n_pivots_on_murtys_family():
    answer = solve(murty(10), "lemke[restarts=0]")
    assert answer.work["pivots"] == 2**10
    np.testing.assert_allclose(answer.z, 2.0**10 * np.eye(10)[0])
    limited = solve(murty(10), "lemke", limit=100)
    assert limited.status is Status.WORK_LIMIT
    assert limited.work["pivots"] == 100


def test_ties_in_every_row_at_the_start():
    lcp = fathi(16)
    assert_solved(lcp, solve(lcp, "lemke[restarts=0]"))


@pytest.mark.parametrize(
    ("M", "q"),
    [
        ([[-1, 0, -3], [1, -2, -5], [-2, -1, -2]], [-3, -2, -1]),  # Murty 1988, 2.9
        ([[2, -1], [0, -2]], [-1, -2]),
        ([[0]], [-1]),
    ],
)
def test_reports_a_ray_where_there_is_no_solution(M, q):
    assert solve(LCP(M, q), "lemke").status is Status.RAY


def test_bimatrix_game_ends_on_ray():
    """Floudas and Pardalos, 10.2.4: M >= 0 with a zero diagonal. There are solutions, but no path to one from z = 0."""
    A, B, none = np.array([[10, 20], [30, 15]]), np.array([[10, 20], [30, 15]]), np.zeros((2, 2))
    lcp = LCP(np.block([[none, A], [B, none]]), -np.ones(4))
    assert lcp.residual(np.array([0.1, 0, 0.1, 0])) == 0
    assert solve(lcp, "lemke").status is Status.RAY
    assert solve(lcp, "lemke[restarts=0]").work["pivots"] == 1


def test_jam_overlap_rays():
    """A particle between two walls, b = (-.1, -.1) and (-.1, +.1)."""

    def between_walls(bias):
        return FrictionProblem(
            mass=np.eye(2),
            normal=[[1, 0], [-1, 0]],
            tangent=[[0, 1], [0, 1]],
            friction=[0.5, 0.5],
            free_velocity=[0, 1],
            bias=bias,
        )

    assert solve(between_walls([-0.1, -0.1]), "lemke").status is Status.RAY
    assert_solved(between_walls([-0.1, 0.1]), solve(between_walls([-0.1, 0.1]), "lemke"))


@pytest.mark.parametrize(("name", "i"), FALSE_RAYS)
def test_false_rays_of_a_plain_tableau(name, i):
    """Steps of a long bar on posts and of three blocks on which a plain dense tableau ended on a ray through round-off."""
    data = np.load(DATA / f"false_rays_{name}.npz")
    lcp = LCP(data[f"M{i}"], data[f"q{i}"])
    assert_solved(lcp, solve(lcp, "lemke[restarts=0]"))


@pytest.mark.parametrize("mu", [0.0, 0.5, 10.0])
@pytest.mark.parametrize("how", [{}, {"push": 1.0}, {"push": 1.0, "jitter": 0.01}])
def test_stacks_and_pyramids(mu, how):
    for problem in (stack(1, mu, **how), stack(10, mu, **how), pyramid(6, mu, **how), stack(50, mu, **how)):
        assert_solved(problem, solve(problem, "lemke"))


@pytest.mark.parametrize("mu", [0.05, 10.0])
def test_stacks_with_near_ties(mu):
    """Contacts displaced by 1e-9: bases that differ by as little, and are conditioned like 1e9."""
    problem = stack(50, mu, jitter=1e-9)
    assert_solved(problem, solve(problem, "lemke"), 1e-9)


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
def test_mass_ratios(ratio):
    """Impulses have sixteen digits, so that what a light body feels under heavy ones is known to 1e-16 times the ratio."""
    for n, mu in ((2, 0.05), (5, 2.0), (20, 0.5)):
        problem = stack(n, mu, ratio)
        assert_solved(problem, solve(problem, "lemke"), max(1e-10, 1e-14 * ratio))


@pytest.mark.parametrize("ratio", [3e9, 1e11])
def test_heavy_tops_to_the_floor_of_rounding(ratio):
    random = np.random.default_rng(5)
    for n in (2, 4, 7, 18):
        problem = scene(
            "stack", blocks=n, mass_ratio=ratio, friction=random.uniform(0.2, 0.8), push=random.uniform(0.2, 2)
        ).problem()
        answer = solve(problem, "lemke")
        found, floor = residual_with_floor(problem, answer.impulse)
        assert answer.status is Status.ROUNDING
        assert found <= floor < 1e-3


def test_random_problems():
    """Mu to 10, more contacts than freedoms; b >= 0, so that each has a solution to which Lemke's method leads."""
    for seed in range(100):
        contacts = 1 + seed % 50
        for ratio, tol in ((10.0, 1e-11), (1e6, 1e-9)):
            problem = random_problem(seed, contacts=contacts, mass_ratio=ratio)
            assert_solved(problem, solve(problem, "lemke"), tol)


def test_friction_bias():
    """Poisson's decompression: friction is there without a normal impulse of this step."""
    for seed in range(15):
        plain = random_problem(seed, contacts=12)
        bias = np.random.default_rng(seed).random(12)
        given = {name: getattr(plain, name) for name in ("mass", "normal", "tangent", "friction", "free_velocity", "bias")}
        problem = FrictionProblem(**given, friction_bias=bias)
        assert_solved(problem, solve(problem, "lemke"))


def test_spatial_contacts_on_a_polygonal_cone():
    """A particle in space on a floor; the LCP is solved exactly, with the polygon's impulse."""
    problem = FrictionProblem(
        mass=np.eye(3),
        normal=[[0, 0, 1]],
        tangent=[[1, 0, 0], [0, 1, 0]],
        friction=[0.5],
        free_velocity=[3, 1, -1],
        bias=[0],
        dimension=3,
    )
    answer = solve(problem, "lemke")
    assert answer.status is Status.SOLVED
    assert problem.lcp().residual(answer.z) <= 1e-14
    np.testing.assert_allclose(answer.impulse, [[1, -0.5, 0]], atol=1e-14)  # the corner nearest to the sliding direction


def test_no_contact_and_nonnegative_q():
    none = FrictionProblem(
        mass=np.eye(2), normal=np.zeros((0, 2)), tangent=np.zeros((0, 2)), friction=[], free_velocity=[1, 1], bias=[]
    )
    answer = solve(none, "lemke")
    assert answer.status is Status.SOLVED
    assert answer.impulse.shape == (0, 2)
    apart = LCP(np.eye(3), [1, 0, 2])
    answer = solve(apart, "lemke")
    assert answer.work["pivots"] == 0
    assert not answer.z.any()


def test_path_is_unit_invariant():
    lcp = random_problem(11, 20).lcp()
    first, second = solve(LCP(lcp.M, lcp.q), "lemke"), solve(LCP(lcp.M / 1024, lcp.q * 64), "lemke")
    assert first.work == second.work
    np.testing.assert_allclose(second.z, first.z * 65536, rtol=1e-12, atol=1e-12)


def test_large_pyramid_pivot_count():
    """Perturbations of equal differences between neighbours once made the path through this one cycle."""
    problem = pyramid(14, push=1.0)
    answer = solve(problem, "lemke")
    assert_solved(problem, answer)
    assert answer.work["restarts"] == 0


def test_resting_stack_pivot_count():
    """A resting stack of 50 boxes takes one pivot a contact and one for z0; round-off in the last basis once cost 49 more."""
    problem = stack(50, 0.05)
    answer = solve(problem, "lemke")
    assert_solved(problem, answer)
    assert answer.work["pivots"] == problem.contacts + 1


@pytest.mark.parametrize("problem", [stack(20, push=1.0, jitter=0.01), random_problem(7, 30)])
def test_warm_start_from_the_answer_saves_pivots(problem):
    cold = solve(problem, "lemke")
    warm = solve(problem, "lemke", start=cold.impulse)
    assert_solved(problem, warm)
    assert warm.work["pivots"] < cold.work["pivots"] / 2


def test_arbitrary_warm_start():
    problem = stack(10, push=1.0)
    start = np.random.default_rng(0).standard_normal((20, 2))
    assert_solved(problem, solve(problem, "lemke", start=start))


def test_ray_of_the_tableau_that_is_none() -> None:
    """The tableau ends at a ray that its certificate does not confirm: the path that is followed instead has its own basis."""
    problem = random_problem(4, contacts=10, friction=10 ** np.random.default_rng(4).uniform(-3, 6))
    answer = solve(problem, "lemke", tol=1e-10)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)
    found, floor = residual_with_floor(problem, answer.impulse)
    assert found <= max(1e-10, floor)
