"""Friction problems: validation of fields, agreement of the forms, hash and residual."""

import pickle
from copy import copy, deepcopy

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import sparse
from scipy.linalg import invpascal, pascal
from scipy.sparse.linalg import splu

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.forms.cone import project_cone
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded.native import load, save
from frictionbench.problems.residual import fclib_error, relaxation_residual, residual
from frictionbench.solvers import solve
from tests.helpers.friction_problems import block, contacts_of, known_by_W, nothing, spatial

H = 0.1 / 9.81  # a block of 2 kg falls at .1 m/s in that time


def test_no_contact() -> None:
    problem = nothing()
    assert problem.lcp().size == 0
    assert problem.W.shape == (0, 0)
    assert residual(problem, np.zeros((0, 2))) == 0
    assert np.array_equal(problem.velocity(np.zeros((0, 2))), [1.0, 2.0, 3.0])
    assert problem.qp().G.shape[0] == problem.cone().G.shape[0] == 0


def test_inputs_are_copied_and_read_only() -> None:
    friction = np.array([0.5])
    problem = block().replace(friction=friction)
    friction[0] = 9
    assert problem.friction[0] == 0.5
    for array in (problem.friction, problem.mass.data, problem.W.data):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def jointed(seed: int, redundant: bool) -> FrictionProblem:
    base = random_problem(seed, contacts=6, bodies=3)
    random = np.random.default_rng(seed)
    F = random.standard_normal((2, 9))
    if redundant:
        F = np.vstack([F, F[0] + F[1]])
    target = F @ random.standard_normal(9)
    names = ("mass", "normal", "tangent", "friction", "free_velocity", "bias")
    return FrictionProblem(**{name: getattr(base, name) for name in names}, joints=F, joint_bias=target)


@pytest.mark.parametrize("redundant", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_velocity_solves_equations_of_motion(seed, redundant) -> None:
    """Against the bordered system [M F'; F 0], which shares nothing with the elimination."""
    problem = jointed(seed, redundant)
    r = np.random.default_rng(seed + 100).standard_normal((6, 2))
    F, M, J = problem.joints.toarray(), problem.mass.toarray(), problem.jacobian
    K = np.block([[M, F.T], [F, np.zeros((len(F), len(F)))]])
    right = np.concatenate([M @ problem.free_velocity + J.T @ r.ravel(), -problem.joint_bias])
    v = np.linalg.lstsq(K, right, rcond=None)[0][: M.shape[0]]
    assert np.allclose(problem.velocity(r), v, atol=1e-11)
    u = (J @ v).reshape(6, 2) + np.column_stack([problem.bias, np.zeros(6)])
    assert np.allclose(problem.contact_velocity(r), u, atol=1e-11)
    assert np.allclose(problem.W @ r.ravel() + problem.q, u.ravel(), atol=1e-11)
    assert np.allclose(problem.scale, problem.W.diagonal().reshape(-1, 2).mean(axis=1), rtol=1e-9)


def test_coupled_mass_matrix() -> None:
    random = np.random.default_rng(1)
    blocks = [
        a @ a.T + np.eye(len(a)) for a in (random.standard_normal((3, 3)), random.standard_normal((2, 2)), np.ones((1, 1)))
    ]
    order = random.permutation(6)
    mass = sparse.csc_array(sparse.block_diag(blocks).tocsr()[order][:, order])
    problem = contacts_of(np.ones((1, 6)), np.ones((1, 6)), 0.5, np.ones(6), mass=mass)
    assert np.allclose(problem.inverse_mass @ np.arange(6.0), splu(mass).solve(np.arange(6.0)))


def test_ill_conditioned_mass_matrix_is_inverted_to_rounding() -> None:
    mass, scale = pascal(10)[::-1, ::-1], 2.0 ** np.arange(-20, 20, 4)  # reversed: its Cholesky factor is not one of integers
    inverse = contacts_of(np.ones((1, 10)), np.ones((1, 10)), 0.5, np.ones(10), mass=mass * np.outer(scale, scale)).inverse_mass
    assert np.array_equal(inverse.toarray() * np.outer(scale, scale), invpascal(10)[::-1, ::-1])


def test_lcp_matrix_by_hand() -> None:
    problem = random_problem(0, contacts=3, bodies=2)
    lcp = problem.lcp()
    Minv = np.linalg.inv(problem.mass.toarray())
    N, T = problem.normal.toarray().T, problem.tangent.toarray().T
    D = np.stack([T, -T], axis=2).reshape(len(T), -1)
    E, U, Z = np.kron(np.eye(3), [[1.0], [1.0]]), np.diag(problem.friction), np.zeros((3, 3))
    Q = np.block([[N.T @ Minv @ N, N.T @ Minv @ D, Z], [D.T @ Minv @ N, D.T @ Minv @ D, E], [U, -E.T, Z]])
    assert np.allclose(lcp.dense, Q)
    v = problem.free_velocity
    assert np.allclose(lcp.q, np.concatenate([N.T @ v + problem.bias, D.T @ v, np.zeros(3)]))
    assert np.array_equal(lcp.impulse(np.arange(12.0)), [[0, 3 - 4], [1, 5 - 6], [2, 7 - 8]])


def test_residual_of_known_solution() -> None:
    """The stopping block: r_n takes the fall, r_t = -mu r_n, u_t = 1 - .5 * .1 (m = 2)."""
    problem = block(h=H)
    r = np.array([[0.2, -0.1]])
    assert np.allclose(problem.contact_velocity(r), [[0.0, 0.95]])
    assert residual(problem, r) < 1e-16
    assert fclib_error(problem, r) < 1e-16
    assert relaxation_residual(problem, r) > 0.01
    assert residual(problem, np.array([[np.nan, 0.0]])) == np.inf
    assert residual(problem, np.zeros((2, 2))) == np.inf


@pytest.mark.parametrize("speed", [1e-200, 1e200])
def test_fclib_error_of_extreme_velocities(speed: float) -> None:
    """The same as that of velocities of order one, as it is relative to them, without a floating-point warning."""
    given, r = block(h=H), np.array([[0.1, 0.1]])
    fast = FrictionProblem.from_delassus(given.W, given.q * speed, given.friction, 2)
    assert fclib_error(given, r) > 0.01
    assert fclib_error(fast, r * speed) == pytest.approx(fclib_error(given, r), rel=1e-12)
    assert fclib_error(given, np.full((1, 2), 1e308)) == np.inf


def test_friction_bias_widens_the_cone() -> None:
    """With b_f the block may be braked by 1.5 N s more, which stops it."""
    problem = block(h=H, friction_bias=[1.9])
    r = np.array([[0.2, -2.0]])
    assert np.allclose(problem.contact_velocity(r), [[0.0, 0.0]], atol=1e-15)
    assert residual(problem, r) < 1e-15
    assert residual(block(h=H, friction_bias=[1.8]), r) > 1e-3


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6), d=st.sampled_from([2, 3]), mu=st.sampled_from([0.0, 0.3, 5.0]), b=st.sampled_from([0.0, 0.4])
)
def test_cone_projection(seed, d, mu, b) -> None:
    """x - p is normal to the set at p: no point of the set lies nearer in the direction of x."""
    random = np.random.default_rng(seed)
    x = random.standard_normal((1, d)) * 3
    p = project_cone(x, np.array([mu]), np.array([b]))
    assert p[0, 0] >= 0
    assert np.linalg.norm(p[0, 1:]) <= mu * p[0, 0] + b + 1e-12
    n = random.uniform(0, 5, 300)
    t = random.standard_normal((300, d - 1))
    t *= (random.uniform(0, 1, 300) * (mu * n + b) / np.linalg.norm(t, axis=1))[:, None]
    others = np.column_stack([n, t])
    assert np.max((others - p) @ (x - p).ravel()) <= 1e-9


def test_equal_problems_have_equal_hashes_and_files(tmp_path) -> None:
    problem = random_problem(5, contacts=4)
    dense = {name: getattr(problem, name).toarray() for name in ("mass", "normal", "tangent")}
    plain = {name: getattr(problem, name) for name in ("friction", "free_velocity", "bias")}
    assert FrictionProblem(**dense, **plain).hash == problem.hash == problem.fresh().hash
    assert FrictionProblem(**dense, **plain | {"bias": problem.bias + 1e-12}).hash != problem.hash
    save(problem, tmp_path / "p.npz")
    assert load(tmp_path / "p.npz").hash == problem.hash
    known = FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, 2)
    save(known, tmp_path / "w.npz")
    assert load(tmp_path / "w.npz").hash == known.hash
    r = np.random.default_rng(0).random((4, 2))
    assert residual(known, r) == pytest.approx(residual(problem, r), rel=1e-9)


@pytest.mark.parametrize("again", [deepcopy, lambda problem: pickle.loads(pickle.dumps(problem))], ids=["deepcopy", "pickle"])
def test_copies_are_the_same_and_read_only(again) -> None:
    mechanical, by_W = random_problem(3, contacts=4, bodies=2), known_by_W(spatial(0, contacts=4, friction_bias=True))
    mechanical.W, by_W.normal  # noqa: B018  # what was derived belongs to this problem, not to its copies
    for problem in (mechanical, by_W):
        copied = again(problem)
        for array in (copied.friction, copied.q, copied.W.data, copied.W.indices):
            assert not array.flags.writeable
        assert copied.hash == copy(problem).hash == problem.replace().hash == problem.hash
        assert np.array_equal(copied.scale, problem.scale)
    assert np.allclose(by_W.replace(W=2 * by_W.W).normal.toarray(), np.sqrt(2) * by_W.normal.toarray())
    lcp = again(mechanical.lcp())
    assert not any(array.flags.writeable for array in (lcp.q, lcp.M.data, lcp.rows.value))


def test_delassus_problem_velocities() -> None:
    problem = known_by_W(spatial(0, contacts=4, friction_bias=True))
    r = np.random.default_rng(1).standard_normal((4, 3))
    assert np.allclose((problem.jacobian @ problem.jacobian.T).toarray(), problem.W.toarray(), atol=1e-12)
    assert np.allclose((problem.jacobian @ problem.velocity(r) + problem.q).reshape(4, 3), problem.contact_velocity(r))
    rows = np.arange(12) % 3 == 0
    assert np.array_equal(problem.normal.toarray(), problem.jacobian.toarray()[rows])
    assert np.array_equal(problem.tangent.toarray(), problem.jacobian.toarray()[~rows])


def test_W_is_factorised_lazily(monkeypatch) -> None:
    def refuse(*_):
        raise AssertionError("W was taken apart")

    monkeypatch.setattr(np.linalg, "eigh", refuse)
    problem = known_by_W(spatial(0, contacts=60, friction_bias=True))
    for name in ("nsgs", "interior_point", "hybrid", "apgd_coulomb"):
        assert residual(problem, solve(problem, name, tol=1e-6).impulse) <= 1e-6
    with pytest.raises(AssertionError, match="taken apart"):
        problem.jacobian  # noqa: B018


@pytest.mark.parametrize(("negative", "accepted"), [(1e-8, True), (1e-4, False), (1.0, False)])
def test_slight_indefiniteness_is_accepted(negative, accepted) -> None:
    random = np.random.default_rng(0)
    basis = np.linalg.qr(random.standard_normal((300, 300)))[0]
    value = np.sort(random.uniform(0, 1, 300))
    value[0] = -negative
    W = basis * value @ basis.T
    if accepted:
        assert np.array_equal(FrictionProblem.from_delassus(W, np.ones(300), np.ones(100), 3).W.toarray(), W)
    else:
        with pytest.raises(InputError, match=r"^W: not positive semidefinite"):
            FrictionProblem.from_delassus(W, np.ones(300), np.ones(100), 3)


def test_fields_cannot_be_reassigned() -> None:
    for problem in (block(h=H), known_by_W(spatial(0))):
        for name in ("friction", "W", "q", "mass"):
            with pytest.raises(AttributeError):
                setattr(problem, name, None)


def test_one_triangle_of_a_delassus_matrix_is_refused() -> None:
    W = np.array([[1.0, 0.3, 0.1, 0.0], [0.3, 1.0, 0.0, 0.2], [0.1, 0.0, 1.0, 0.0], [0.0, 0.2, 0.0, 1.0]])
    sides = {r"\(0, 1\) is 0.3, but \(1, 0\) is 0": np.triu(W), r"\(1, 0\) is 0.3, but \(0, 1\) is 0": np.tril(W)}
    for entry, side in sides.items():
        with pytest.raises(InputError, match=f"^W: holds one triangle: entry {entry}"):
            FrictionProblem.from_delassus(side, -np.ones(4), [0.5, 0.5], 2)
    assert FrictionProblem.from_delassus(np.diag(np.diag(W)), -np.ones(4), [0.5, 0.5], 2).asymmetry == 0
    rounding = np.diag(np.diag(W)) + 1e-16 * np.triu(W, 1)
    assert FrictionProblem.from_delassus(rounding, -np.ones(4), [0.5, 0.5], 2).asymmetry < 1e-15


def test_asymmetry_of_a_delassus_matrix_is_told() -> None:
    W = np.array([[2.0, 0.5], [0.1, 1.0]])
    problem = FrictionProblem.from_delassus(W, [-1.0, 0.3], [0.5], 2)
    assert problem.asymmetry == pytest.approx(0.2)
    assert problem.summary == "1 contact in the plane, known by W, unsymmetric by 0.2"
    rounded = FrictionProblem.from_delassus([[2.0, 0.5], [0.5 + 1e-7, 1.0]], [-1.0, 0.3], [0.5], 2)
    assert rounded.summary == "1 contact in the plane, known by W"
    assert block(h=H).asymmetry == 0
