"""The banded inverse of many joint equations gives what the dense inverse of few gives."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError, mechanics
from frictionbench.problems.forms import banded
from frictionbench.problems.instances.rod_chain import rod_chain
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve


def _loops() -> FrictionProblem:
    """Two closed loops in space whose hinge equations hold twice and in other units, with a foot that the joints lock."""
    problem = rod_chain(links=6)
    F = np.vstack([problem.joints.toarray(), 1e3 * problem.joints.toarray()[:7], np.eye(36)[:6], np.eye(36)[2:5]])
    return problem.replace(joints=F, joint_bias=np.concatenate([np.zeros(22), 0.01 * np.ones(6), 0.01 * np.ones(3)]))


PROBLEMS = {
    "planar chain": lambda: scene("chain", links=40, ripple=1.0, fall=1.0, mass_ratio=1e4).problem(),
    "chain in space": lambda: rod_chain(links=12, mass_ratio=100.0),
    "redundant and locked": _loops,
}


def _both(name: str, monkeypatch: pytest.MonkeyPatch) -> list[FrictionProblem]:
    """The problem with a dense inverse of the joints' equations, and with a banded one."""
    made = []
    for few in (10_000, 0):
        monkeypatch.setattr(mechanics, "FEW", few)
        made.append(PROBLEMS[name]())
    return made


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_inverses_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    few, many = _both(name, monkeypatch)
    assert few.hash == many.hash
    r = np.random.default_rng(0).uniform(0.0, 1.0, (few.contacts, few.dimension))
    W = few.W.toarray()
    assert many.W.toarray() == pytest.approx(W, abs=1e-9 * np.abs(W).max())
    size = few.velocity_size(r).max()
    assert many.contact_velocity(r) == pytest.approx(few.contact_velocity(r), abs=1e-12 * size)
    assert many.scale == pytest.approx(few.scale, rel=1e-7)
    assert many.units == pytest.approx(few.units, rel=1e-9)


@pytest.mark.parametrize("name", PROBLEMS)
def test_size_of_terms_covers_the_velocity_of_the_joints(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The estimate of |X| from a few right sides stays within its number of equations of the exact sum."""
    few, many = _both(name, monkeypatch)
    r = np.random.default_rng(1).uniform(0.0, 1.0, (few.contacts, few.dimension))
    exact, estimate = few.velocity_size(r), many.velocity_size(r)
    assert np.all(estimate >= np.abs(many.contact_velocity(r)) - 1e-9)
    assert np.all(estimate <= 3 * exact)
    assert np.median(exact / estimate) <= np.sqrt(len(few.joint_bias))


def test_a_long_chain_needs_no_dense_matrix() -> None:
    """1500 links; the dense inverse took minutes."""
    problem = rod_chain(links=1500)
    answer = solve(problem, "hybrid")
    assert residual(problem, answer.impulse) <= 1e-8
    assert problem._held.factor.shape[1] < 20


def test_contradictions_among_many_are_named() -> None:
    problem = scene("chain", links=80).problem()
    F = np.vstack([problem.joints.toarray(), problem.joints.toarray()[100]])
    bias = np.zeros(len(F))
    bias[100] = 1e-3
    with pytest.raises(InputError, match=r"^joint_bias: the joint equations contradict each other: rows (100|158) "):
        problem.replace(joints=F, joint_bias=bias)
    bias[158] = 1e-3
    agreed = problem.replace(joints=F, joint_bias=bias)
    v = agreed.velocity(np.zeros((agreed.contacts, 2)))
    assert np.abs(F @ v + bias).max() <= 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_band_factorisation_of_a_singular_matrix(seed: int) -> None:
    """X A X = A with X zero in the rows left out, the entries of X in the band, and c'Xc."""
    random = np.random.default_rng(seed)
    n, b = 30, 4
    B = np.array([[random.standard_normal() if 0 <= i - j <= 2 else 0.0 for j in range(n)] for i in range(n)])
    B[[7, 19]] = B[[6, 17]]
    A = B @ B.T
    rows = [(i, j) for i in range(n) for j in range(n) if A[i, j] != 0]
    start = np.searchsorted([i for i, _ in rows], np.arange(n + 1)).astype(np.int32)
    L = banded.by_band(start, np.array([j for _, j in rows], np.int32), np.array([A[i, j] for i, j in rows]), b)
    banded.factorise(L, 1e-12)
    out = np.flatnonzero(L[:, b] == 0)
    assert out.tolist() == [7, 19]
    kept = np.setdiff1d(np.arange(n), out)
    X = np.zeros((n, n))
    X[np.ix_(kept, kept)] = np.linalg.inv(A[np.ix_(kept, kept)])
    found = banded.inverse_in_band(L)
    scale = np.abs(X).max()
    for i in range(n):
        for k in range(max(0, b - i), b + 1):
            assert found[i, k] == pytest.approx(X[i, i - b + k], abs=1e-9 * scale)
