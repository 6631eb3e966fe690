"""The sparse LU of a sum of element matrices."""

import numpy as np
import pytest
from scipy import sparse

from problems.scenes import scene
from solvers.multifrontal import analyse, factorise, solve


def pattern(name, **parameters):
    problem = scene(name, **parameters).problem()
    return sparse.csr_array(abs(problem.normal) + abs(problem.tangent))


PATTERNS = {
    "one variable": sparse.csr_array([[1.0]]),
    "no elements": sparse.csr_array((0, 4)),
    "an untouched variable": sparse.csr_array([[1.0, 0, 1.0, 0]]),
    "dense": sparse.csr_array(np.ones((1, 7))),
    "arrow": sparse.csr_array(np.column_stack([np.eye(8), np.ones(8)])),
    "stack": pattern("stack", blocks=20),
    "pyramid": pattern("pyramid", rows=6),
    "random": sparse.csr_array(sparse.random_array((30, 25), density=0.1, rng=np.random.default_rng(5))),
}


def factors(incidence, shift=3.0, floor=1e-14):
    """A random unsymmetric matrix of the pattern, in order of elimination, its fronts, factors and interchanges."""
    fronts, order = analyse(incidence)
    touch = (incidence != 0).astype(float)
    graph = sparse.csr_array(touch.T @ touch + sparse.eye_array(fronts.size))
    graph.data[:] = np.random.default_rng(0).standard_normal(graph.nnz)
    A = sparse.coo_array((graph + shift * sparse.eye_array(fronts.size))[order][:, order])
    home = fronts.home(np.minimum(A.row, A.col))
    width = np.diff(fronts.first)[home]
    storage, swap = np.zeros(fronts.start[-1]), np.zeros(fronts.size, dtype=np.int64)
    np.add.at(storage, fronts.start[home] + fronts.place(home, A.row) * width + fronts.place(home, A.col), A.data)
    return A, fronts, storage, swap, factorise(fronts, storage, swap, floor)


@pytest.mark.parametrize("name", PATTERNS)
def test_solves_what_a_dense_solver_solves(name) -> None:
    A, fronts, storage, swap, replaced = factors(PATTERNS[name])
    b = np.random.default_rng(1).standard_normal(fronts.size)
    x = b.copy()
    solve(fronts, storage, swap, x)
    assert replaced == 0
    assert np.allclose(A @ x, b, rtol=0, atol=1e-9 * np.abs(x).max())


def test_no_variable_at_all() -> None:
    fronts, order = analyse(sparse.csr_array((3, 0)))
    assert fronts.size == len(order) == fronts.start[-1] == 0


@pytest.mark.parametrize("name", PATTERNS)
def test_every_variable_is_eliminated_once(name) -> None:
    fronts, order = analyse(PATTERNS[name])
    own = np.concatenate([fronts.variable[a : a + p] for a, p in zip(fronts.first[:-1], fronts.pivots, strict=True)])
    assert np.array_equal(own, np.arange(fronts.size))
    assert np.array_equal(np.sort(order), np.arange(fronts.size))
    assert np.all((fronts.parent == -1) | (fronts.parent > np.arange(len(fronts.parent))))


def test_bodies_are_found_and_a_stack_has_no_fill() -> None:
    fronts, _ = analyse(pattern("stack", blocks=50))
    assert set((fronts.pivots % 3).tolist()) == {0}
    assert np.diff(fronts.first).max() == 6  # a box and the one box left beside it


def test_a_pivot_of_zero_is_exchanged_within_its_front() -> None:
    fronts, _ = analyse(sparse.csr_array(np.ones((1, 2))))
    storage, swap, x = np.array([0.0, 2.0, 4.0, 0.0]), np.zeros(2, dtype=np.int64), np.array([6.0, 8.0])
    assert factorise(fronts, storage, swap, 1e-14) == 0
    solve(fronts, storage, swap, x)
    assert x.tolist() == [2.0, 3.0]


@pytest.mark.parametrize("entry", [0.0, np.nan])
def test_a_singular_matrix_gives_replaced_pivots_and_finite_factors(entry) -> None:
    fronts, _ = analyse(sparse.csr_array([[1.0]]))
    storage, swap, x = np.array([entry]), np.zeros(1, dtype=np.int64), np.array([1.0])
    assert factorise(fronts, storage, swap, 1e-3) == 1
    solve(fronts, storage, swap, x)
    assert x[0] == pytest.approx(1e3)


def test_fill_stays_low_on_a_pyramid() -> None:
    fronts, _ = analyse(pattern("pyramid", rows=25))
    assert fronts.start[-1] < 40 * fronts.size * np.sqrt(fronts.size)
