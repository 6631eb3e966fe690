"""Nonsmooth Gauss-Seidel and the exact single-contact solves it uses."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual, residual, residual_with_floor
from frictionbench.solvers import Status, solve
from frictionbench.solvers.sweeps.form import contact_form, state, velocity
from frictionbench.solvers.sweeps.gauss_seidel import LIMIT
from frictionbench.solvers.sweeps.laws import defect, planar_contact
from tests.helpers.friction_problems import spatial
from tests.helpers.kernels import spatial_contact


@pytest.mark.parametrize("bias", [0.0, 0.4])
@pytest.mark.parametrize(("d", "most", "tol"), [(2, 4, 1e-10), (3, 1, 1e-9)])
def test_one_contact_is_solved_exactly(d, most, tol, bias) -> None:
    random = np.random.default_rng(d - 2)
    for _ in range(500):
        root = random.standard_normal((d, d))
        mu, q = random.uniform(0, most), random.standard_normal(d)
        problem = FrictionProblem.from_delassus(root @ root.T, q, [mu], d, [bias])
        r = random.standard_normal(d)
        u, W = problem.contact_velocity(r[None])[0], problem.W.toarray()
        if d == 2:
            r[:] = planar_contact(*u, *r, W, mu, bias)
        else:
            spatial_contact(u, r, W, mu, bias)
        assert residual(problem, r[None]) < tol


@pytest.mark.parametrize("bias", [0.0, 0.4])
@pytest.mark.parametrize("rank", [1, 2])
def test_one_contact_whose_block_is_singular_ends_in_its_cone(rank, bias) -> None:
    """A contact's own block of this rank, badly scaled by rows or by columns, and a free velocity that it can stop."""
    random, unsolved = np.random.default_rng(0), 0
    for _ in range(3000):
        root = random.standard_normal((3, rank)) * 10 ** random.uniform(-4, 4, (3, 1) if random.random() < 0.5 else (1, rank))
        W, q = root @ root.T, root @ random.standard_normal(rank)
        r, mu = np.zeros(3), random.choice([0.1, 0.5, 1.0, 3.0])
        spatial_contact(q.copy(), r, W, mu, bias)
        assert np.isfinite(r).all()
        assert r[0] >= 0
        assert np.hypot(r[1], r[2]) <= (mu * r[0] + bias) * (1 + 1e-12)
        if mu * np.hypot(W[0, 1], W[0, 2]) < W[0, 0]:  # otherwise it may jam
            found, floor = residual_with_floor(FrictionProblem.from_delassus(W, q, [mu], 3, [bias]), r[None])
            unsolved += found > max(1e-8, 10 * floor)
    assert not unsolved


def test_a_contact_of_two_directions() -> None:
    """Three directions of which every two determine the third: a determinant that is zero but for rounding."""
    root = 1e-6 * np.array([[-1.0, 1.0], [-8.0, 4.0], [0.0, 7.0]])
    q, r = root @ [3.0, -7.0], np.zeros(3)
    spatial_contact(q.copy(), r, root @ root.T, 0.1, 0.0)
    assert np.hypot(r[1], r[2]) <= 0.1 * r[0] * (1 + 1e-12)


@pytest.mark.parametrize("start", [[0.0, 0.0], [0.1, 0.15], [0.283, 0.394]])
def test_open_solution_is_chosen(start) -> None:
    W, q = np.array([[8 / 5, -6 / 5], [-6 / 5, 17 / 5]]), np.array([1 / 50, -1])
    assert planar_contact(*(W @ start + q), *start, W, 1.5, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("problem", [random_problem(4), spatial(4), spatial(5, joints=2, friction_bias=True)])
def test_packed_form(problem) -> None:
    form, r = contact_form(problem), np.random.default_rng(0).standard_normal((problem.contacts, problem.dimension))
    x, u = np.empty_like(form.rest), np.empty_like(r)
    state(form, r, x)
    velocity(form, x, u)
    assert u == pytest.approx(problem.contact_velocity(r), abs=1e-12)
    dense, d = problem.W.toarray(), problem.dimension
    own = [dense[d * i : d * i + d, d * i : d * i + d] for i in range(problem.contacts)]
    assert form.block == pytest.approx(np.array(own), abs=1e-12)
    assert defect(form, r, u, 1.0) == pytest.approx(residual(problem, r), rel=1e-10)
    assert defect(contact_form(problem, relaxed=True), r, u, 0.0) == pytest.approx(relaxation_residual(problem, r), rel=1e-10)


def test_cycle_is_stalled() -> None:
    answer = solve(random_problem(7, contacts=40), "nsgs")  # mu up to 4; the residual stays at .157
    assert answer.status is Status.STALLED
    assert answer.work["sweeps"] < LIMIT


@pytest.mark.parametrize("spec", ["nsgs", "nncg"])
@pytest.mark.parametrize("slide", [0.0, 1.0, 1e-200])
def test_a_contact_whose_tangents_are_held_by_joints(spec, slide) -> None:
    """No impulse changes its tangential velocity: friction opposes it, or nothing needs friction."""
    motion = {"mass": np.eye(3), "free_velocity": [-1, 0, 0], "joints": np.eye(3)[1:], "joint_bias": [-slide, 0]}
    contact = {"normal": [[1, 0, 0]], "tangent": np.eye(3)[1:], "friction": [0.5], "bias": [0]}
    answer = solve(FrictionProblem(**motion, **contact, dimension=3), spec)
    assert answer.status is Status.SOLVED
    assert answer.impulse == pytest.approx(np.array([[1, -0.5 if slide == 1 else 0, 0]]), abs=1e-12)
