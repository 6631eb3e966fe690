"""Verification of answers: near misses, rounding floors and energy defects."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.harness.contract.check import in_units, permuted
from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual, residual, residual_floor
from frictionbench.problems.subproblems import side_by_side
from frictionbench.problems.verify import NEAR_MISS, verify
from frictionbench.solvers import Answer, Status, solve
from tests.helpers.friction_problems import block, contacts_of, known_by_W, spatial

LEMKE, RELAXATION = "lcp", "relaxation"


def claim(impulse, status=Status.SOLVED):
    return Answer(np.asarray(impulse, dtype=float), status)


def off_by(problem, size):
    """Impulses whose residual is `size`: the answer with the last contact's normal impulse raised."""
    r = solve(problem, "lemke", tol=1e-14).impulse
    low, high = 0.0, 1.0
    for _ in range(200):
        middle = (low + high) / 2
        moved = r + middle * np.eye(problem.dimension)[0] * (np.arange(problem.contacts) == problem.contacts - 1)[:, None]
        low, high = (middle, high) if residual(problem, moved) < size else (low, middle)
    return moved


@pytest.mark.parametrize(
    ("excess", "status", "verdict"),
    [
        (0.5, Status.SOLVED, "solved"),
        (0.5, Status.STALLED, "solved"),
        (1.000001, Status.SOLVED, "near_miss"),
        (9.5, Status.SOLVED, "near_miss"),
        (120.0, Status.SOLVED, "wrong"),
        (1.5, Status.STALLED, "unsolved"),
    ],
)
def test_claim_within_a_factor_of_ten_is_near_miss(excess, status, verdict):
    problem = random_problem(3, contacts=4, friction=0.3)
    finding = verify(problem, claim(off_by(problem, excess * 1e-4), status), LEMKE, 1e-4)
    assert finding.residual == pytest.approx(excess * 1e-4, rel=1e-7)
    assert finding.verdict == verdict
    if status is Status.SOLVED and excess > 1:
        told = f"{excess * 1e-4:.2g}, {excess:g} times that" if excess > 1.05 else "above it by 0.0001 %"
        assert finding.reason == f"claimed solved within 0.0001; the residual is {told}"


def test_relaxation_verdict_uses_model_residual():
    problem = random_problem(3, contacts=4, friction=1.0)
    moved = solve(problem, "relaxation_ip", tol=1e-12).impulse * (1 + 2e-5)
    tol = relaxation_residual(problem, moved) / 3
    assert NEAR_MISS * tol < residual(problem, moved)
    finding = verify(problem, claim(moved), RELAXATION, tol)
    assert finding.verdict == "near_miss"
    assert "of its model" in finding.reason
    assert verify(problem, claim(moved), RELAXATION, 4 * tol).verdict == "relaxed"


@pytest.mark.parametrize(
    ("share", "verdict", "said"),
    [
        (1e-6, "relaxed", "verified with contacts regularised by 1e-06 of W's diagonal"),
        (2e-6, "wrong", "softness of 2e-06 of W's diagonal is above the 1e-06 allowed: verified without it"),
        (-0.5, "wrong", "numbers of at least 0: verified without it"),
        (np.nan, "wrong", "numbers of at least 0: verified without it"),
    ],
)
def test_regularised_contacts(share, verdict, said):
    """r (1 + share) = r_hard solves the block's problem with R = share s, whatever share is."""
    problem = block(speed=0.0, friction=0.0)
    answer = claim(solve(problem, "lemke", tol=1e-14).impulse / (1 + np.nan_to_num(share, nan=1.0)))
    answer.softness = np.full((1, 2), share * problem.scale[0])
    finding = verify(problem, answer, "regularised", 5e-8)
    assert finding.verdict == verdict
    assert said in finding.reason
    assert verify(problem, answer, RELAXATION, 5e-8).verdict == "wrong", "a hard model's answer may not be soft"


def opposed() -> FrictionProblem:
    """A body between two walls that press it from both sides; equal impulses cancel."""
    return contacts_of([[0.0, 1.0], [0.0, -1.0]], [[1.0, 0.0], [1.0, 0.0]], 0.5, [1.0, -1.0])


def test_large_impulses_are_unjudgeable():
    problem, garbage = opposed().replace(free_velocity=[1.0, 0.0]), [[1e17, 3e16], [1e17, -3e16]]
    finding = verify(problem, claim(garbage), LEMKE, 1e-8)
    assert finding.residual <= 1e-8  # by rounding alone: the energy it makes says otherwise
    assert finding.floor > 1
    assert finding.verdict == "unjudgeable"
    assert "rounding alone" in finding.reason
    assert abs(finding.energy_defect) > 1e15
    assert verify(problem, claim(garbage, Status.STALLED), LEMKE, 1e-8).verdict == "unsolved"


def test_moderate_internal_impulses_are_judged():
    problem, squeeze = opposed(), 1e4 * np.array([[1.0, -0.25], [1.0, -0.25]])
    squeeze[0, 0] += 1.0
    finding = verify(problem, claim(squeeze), LEMKE, 1e-8)
    assert finding.floor < 1e-10
    assert finding.verdict == "wrong"
    assert verify(problem, claim([[4.0, -0.5], [3.0, -0.5]]), LEMKE, 1e-12).verdict == "solved"


def test_floor_includes_friction_times_slip():
    assert residual_floor(block(friction=1e6), np.zeros((1, 2))) > 1e5 * residual_floor(block(friction=0.1), np.zeros((1, 2)))
    stuck = solve(problem := block(friction=1e6), "lemke").impulse
    assert residual_floor(problem, stuck) > 1e-11
    assert verify(problem, claim(stuck), LEMKE, 1e-8).verdict == "solved"
    assert verify(problem, claim(stuck), LEMKE, 1e-12).verdict == "unjudgeable"


def exact_residual(problem, impulse):
    """The residual in extended precision, written down once more."""
    r, exact = impulse.astype(np.longdouble), np.longdouble
    J, inverse = problem.jacobian.toarray().astype(exact), problem.inverse_mass.toarray().astype(exact)
    if problem.joints.shape[0]:
        F = problem.joints.toarray().astype(exact)
        response = inverse @ F.T
        held = response @ np.linalg.inv((F @ response).astype(float)).astype(exact)
    free = problem.free_velocity.astype(exact)

    def velocity(r):
        v = free + inverse @ (J.T @ r.ravel())
        if problem.joints.shape[0]:
            for _ in range(3):  # the inverse is not exact; the projection, repeated, is
                v = v - held @ (F @ v + problem.joint_bias)
        u = (J @ v).reshape(r.shape)
        u[:, 0] += problem.bias
        return u

    u, worst = velocity(r), exact(0)
    for i, (mu, b, s, unit) in enumerate(
        zip(problem.friction, problem.friction_bias, problem.scale, problem.units, strict=True)
    ):
        n = r[i, 0] - (u[i, 0] + exact(mu) * np.sqrt((u[i, 1:] ** 2).sum())) / s
        t = r[i, 1:] - u[i, 1:] / s
        size = np.sqrt((t**2).sum())
        nearest = n if size <= mu * n + b else (n + mu * (size - b)) / (1 + exact(mu) ** 2)
        nearest = max(nearest, exact(0))
        t *= min((mu * nearest + b) / size, exact(1)) if size else 0
        signorini = abs(min(s * r[i, 0], u[i, 0]))
        worst = max(worst, s * np.sqrt((r[i, 0] - nearest) ** 2 + ((r[i, 1:] - t) ** 2).sum()) / unit, signorini / unit)
    return float(worst)


@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("dimension", [2, 3])
def test_rounding_is_below_floor(seed, dimension):
    random = np.random.default_rng(seed)
    friction = 10 ** random.uniform(-3, 6)
    if dimension == 2:
        problem = random_problem(seed, contacts=int(random.integers(1, 12)), friction=friction)
    else:
        problem = spatial(seed, friction=friction, friction_bias=bool(seed % 2))
    answer = solve(problem, "hybrid", tol=1e-10).impulse
    for size in (1.0, 1 + 1e-9, 10 ** random.uniform(0, 14)):
        found, floor = residual(problem, size * answer), residual_floor(problem, size * answer)
        assert abs(found - exact_residual(problem, size * answer)) <= floor


def hiding_places(ratio):
    """A block of 2 kg that falls onto the floor, as contact 0, and beside it what is `ratio` times as fast, by name."""
    light, fast = block(mass=1e-6), in_units(block(), 1.0, ratio)
    floor = side_by_side(block(), fast)
    heavy = sparse.block_diag([floor.mass, 1e15 * np.eye(2)])
    rows = {
        name: sparse.hstack([getattr(floor, name), -np.tile(row, (2, 1))])
        for name, row in (("normal", [0.0, 1.0]), ("tangent", [1.0, 0.0]))
    }
    free = np.concatenate([floor.free_velocity, np.zeros(2)])
    opened = permuted(block(), np.array([0, 0]))
    return {
        "light block": side_by_side(light, fast),
        "many parts": side_by_side(block(), block(), fast, in_units(block(), 1.0, np.sqrt(ratio))),
        "one heavy floor": floor.replace(mass=heavy, free_velocity=free, joints=None, joint_bias=None, **rows),
        "open contact": opened.replace(bias=np.array([opened.bias[0], ratio])),
        "in contact space": known_by_W(side_by_side(light, fast)),
    }


@pytest.mark.parametrize("place", hiding_places(1.0))
@pytest.mark.parametrize("ratio", [1e3, 1e8, 1e12])
def test_no_part_hides_behind_a_faster_one(place, ratio):
    problem = hiding_places(ratio)[place]
    answer = solve(problem, "hybrid", tol=1e-12)
    assert verify(problem, answer, LEMKE, 1e-10).verdict == "solved"
    falling = answer.impulse.copy()
    falling[0] = 0.0
    for tol in (1e-4, 1e-8):
        assert verify(problem, claim(falling), LEMKE, tol).verdict == "wrong"


def test_rounding_errors_of_one_island_do_not_excuse_another():
    jammed, falling = opposed(), block()
    problem = side_by_side(jammed, falling)
    garbage, right = [[1e17, 3e16], [1e17, -3e16]], solve(falling, "lemke").impulse
    assert verify(problem, claim(np.vstack([garbage, right])), LEMKE, 1e-8).verdict == "unjudgeable"
    finding = verify(problem, claim(np.vstack([garbage, 0 * right])), LEMKE, 1e-8)
    assert finding.verdict == "wrong"
    alone = verify(falling, claim(0 * right), LEMKE, 1e-8)
    assert finding.reason == alone.reason != ""  # the residual of the island that decides, not that of the excused one
    assert verify(problem, claim(np.vstack([garbage, 0 * right]), Status.STALLED), LEMKE, 1e-8).verdict == "unsolved"


def test_rounding_errors_across_an_open_contact_do_not_excuse_either_side():
    """The open contact between both parts carries nothing: each has its own unit and its own rounding."""
    apart = side_by_side(opposed(), block())
    normal, tangent = apart.normal.toarray(), apart.tangent.toarray()
    bridged = apart.replace(
        normal=np.vstack([normal, normal[:1] - normal[2:]]),
        tangent=np.vstack([tangent, tangent[:1] - tangent[2:]]),
        friction=np.append(apart.friction, 0.5),
        friction_bias=np.zeros(4),
        bias=np.append(apart.bias, 50.0),
    )
    garbage, right = [[1e17, 3e16], [1e17, -3e16]], solve(block(), "lemke").impulse
    for impulse, verdict in ((right, "unjudgeable"), (0 * right, "wrong")):
        assert verify(bridged, claim(np.vstack([garbage, impulse, [[0.0, 0.0]]])), LEMKE, 1e-8).verdict == verdict


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [1e17, 1e155, 1e200, 1e300, 1.7e308])
def test_huge_impulses_are_wrong(size, dimension):
    """Far from cancellation a residual above the floor is certain, also where both overflow."""
    problem = random_problem(1, contacts=4) if dimension == 2 else spatial(1)
    impulse = size * np.random.default_rng(0).uniform(0.1, 1, (problem.contacts, dimension))
    assert verify(problem, claim(impulse), LEMKE, 1e-8).verdict == "wrong"


def test_answer_as_good_as_rounding_allows_is_unjudgeable():
    problem = block(friction=1e6)
    answer = solve(problem, "lemke", tol=1e-12)
    assert answer.status is Status.ROUNDING
    assert verify(problem, answer, LEMKE, 1e-12).verdict == "unjudgeable"
    assert verify(problem, answer, LEMKE, 1e-8).verdict == "solved"
    assert verify(problem, claim(np.zeros((1, 2)), Status.ROUNDING), LEMKE, 1e-8).verdict == "unsolved"


def test_bare_lcp_verdicts():
    lcp = LCP(np.eye(2), [-1.0, -1.0])
    answer = Answer(np.zeros((0, 0)), Status.SOLVED, z=np.array([1.0, 1.0 + 3e-8]))
    assert verify(lcp, answer, LEMKE, 1e-8).verdict == "near_miss"
    assert verify(lcp, answer, LEMKE, 1e-9).verdict == "wrong"
    assert verify(lcp, answer, LEMKE, 1e-7).verdict == "solved"


def test_a_claim_within_the_rounding_of_an_unsymmetric_matrix_is_not_judged() -> None:
    W, q = np.eye(4) + 0.1, np.array([-1.0, 0.0, -1.0, 0.0])
    sticking = np.linalg.solve(W, -q).reshape(2, 2)  # the answer of a method that reads the lower triangle
    for off, share, verdict in ((3e-7, 1.0, "unjudgeable"), (3e-5, 1.0, "wrong"), (3e-7, 1.001, "wrong")):
        problem = FrictionProblem.from_delassus(W + off * np.triu(np.ones((4, 4)), 1), q, [0.9, 0.9], 2)
        assert verify(problem, Answer(share * sticking, Status.SOLVED), "coulomb", 1e-8).verdict == verdict
