"""Lemke's method: pivot counts from the literature, friction problems with exact ties, and rays."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual_with_floor
from frictionbench.problems.scenes import scene
from frictionbench.solvers.interface import Status, solve
from tests.helpers.lcps import assert_solved, murty_family


def boxes(contacts, centres, mu, push=0.0, jitter=0.0):
    """Unit boxes on each other; contacts: (upper, lower or -1, x, y), all with vertical normals. One step under gravity."""
    random = np.random.default_rng(0)
    nb, nc = len(centres), len(contacts)
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
        mass=sparse.diags_array(np.tile([1, 1, 1 / 6], nb)),
        normal=normal,
        tangent=tangent,
        friction=np.full(nc, mu),
        free_velocity=velocity.ravel(),
        bias=np.zeros(nc),
    )


def stack(n, mu, **how):
    """n boxes with two contacts an interface: hyperstatic."""
    contacts = [(i, i - 1, x, float(i)) for i in range(n) for x in (-0.5, 0.5)]
    return boxes(contacts, [(0, i + 0.5) for i in range(n)], mu, **how)


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


def test_takes_two_to_the_n_pivots_on_murtys_family():
    lcp = LCP(*murty_family(10)[:2])
    assert solve(lcp, "lemke[restarts=0]").work["pivots"] == 2**10


def test_ties_in_every_row_at_the_start():
    """Fathi 1979: M = L L' with Murty's L, symmetric positive definite, q = -1."""
    L = murty_family(16)[0]
    lcp = LCP(L @ L.T, -np.ones(16))
    assert lcp.residual(solve(lcp, "lemke[restarts=0]").z) <= 1e-11


@pytest.mark.parametrize("mu", [0.05, 10.0])
def test_stacks_with_near_ties(mu):
    """Contacts displaced by 1e-9: bases that differ by as little, and are conditioned like 1e9."""
    problem = stack(50, mu, jitter=1e-9)
    assert_solved(problem, "lemke", 1e-9)


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


def test_path_is_unit_invariant():
    lcp = random_problem(11, 20).lcp()
    first, second = solve(LCP(lcp.M, lcp.q), "lemke"), solve(LCP(lcp.M / 1024, lcp.q * 64), "lemke")
    assert first.work == second.work
    np.testing.assert_allclose(second.z, first.z * 65536, rtol=1e-12, atol=1e-12)


def test_large_pyramid_pivot_count():
    """Perturbations of equal differences between neighbours once made the path through this one cycle."""
    problem = pyramid(14, push=1.0)
    assert assert_solved(problem, "lemke").work["restarts"] == 0


def test_resting_stack_pivot_count():
    """A resting stack of 50 boxes takes one pivot a contact and one for z0; round-off in the last basis once cost 49 more."""
    problem = stack(50, 0.05)
    assert assert_solved(problem, "lemke").work["pivots"] == problem.contacts + 1


@pytest.mark.parametrize("problem", [stack(20, 0.5, push=1.0, jitter=0.01), random_problem(7, 30)])
def test_warm_start_from_the_answer_saves_pivots(problem):
    cold = solve(problem, "lemke")
    warm = assert_solved(problem, "lemke", start=cold.impulse)
    assert warm.work["pivots"] < cold.work["pivots"] / 2


def test_arbitrary_warm_start():
    problem = stack(10, 0.5, push=1.0)
    start = np.random.default_rng(0).standard_normal((20, 2))
    assert_solved(problem, "lemke", start=start)


def test_ray_of_the_tableau_that_is_none() -> None:
    """The tableau ends at a ray that its certificate does not confirm: the path that is followed instead has its own basis."""
    problem = random_problem(4, contacts=10, friction=10 ** np.random.default_rng(4).uniform(-3, 6))
    answer = solve(problem, "lemke", tol=1e-10)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)
    found, floor = residual_with_floor(problem, answer.impulse)
    assert found <= max(1e-10, floor)
