"""The sparse LU of a sum of element matrices."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems.catalogue import scene
from frictionbench.solvers.sparse_lu.multifrontal import factorise
from tests.helpers.kernels import analyse, determinant_sign, position_in_front, solve_factorised


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
    "one wide front": sparse.csr_array(np.ones((1, 43))),
    "wide fronts": sparse.csr_array(sparse.random_array((60, 120), density=0.15, rng=np.random.default_rng(6))),
    "random": sparse.csr_array(sparse.random_array((30, 25), density=0.1, rng=np.random.default_rng(5))),
}


def analysed(incidence):
    """Fronts and places, for elements that are the nonzeros of the rows."""
    fronts, place, home = analyse(incidence.indptr.astype(np.int64), incidence.indices.astype(np.int64), incidence.shape[1])
    assert len(home) == incidence.shape[0]
    return fronts, place


def factors(incidence, shift=3.0, floor=1e-14):
    """A random unsymmetric matrix of the pattern, in order of elimination, its fronts, factors and interchanges."""
    fronts, place = analysed(incidence)
    order = np.argsort(place)
    touch = (incidence != 0).astype(float)
    graph = sparse.csr_array(touch.T @ touch + sparse.eye_array(len(place)))
    graph.data[:] = np.random.default_rng(0).standard_normal(graph.nnz)
    A = sparse.coo_array((graph + shift * sparse.eye_array(len(place)))[order][:, order])
    storage, swap = np.zeros(fronts.start[-1]), np.zeros(len(order), dtype=np.int64)
    for row, column, value in zip(A.row, A.col, A.data, strict=True):
        f = fronts.owner[min(row, column)]
        width = fronts.first[f + 1] - fronts.first[f]
        storage[fronts.start[f] + position_in_front(fronts, f, row) * width + position_in_front(fronts, f, column)] += value
    return A, fronts, storage, swap, factorise(fronts, storage, swap, floor)


@pytest.mark.parametrize("name", PATTERNS)
def test_solves_what_a_dense_solver_solves(name) -> None:
    A, fronts, storage, swap, replaced = factors(PATTERNS[name])
    b = np.random.default_rng(1).standard_normal(len(swap))
    x = b.copy()
    solve_factorised(fronts, storage, swap, x)
    assert replaced == 0
    assert np.allclose(A @ x, b, rtol=0, atol=1e-9 * np.abs(x).max())


@pytest.mark.parametrize("shift", [0.0, 3.0])
@pytest.mark.parametrize("name", PATTERNS)
def test_determinant_sign(name, shift) -> None:
    A, fronts, storage, swap, _ = factors(PATTERNS[name], shift)
    assert determinant_sign(fronts, storage, swap) == np.linalg.slogdet(A.toarray()).sign


def test_a_pivot_of_zero_is_exchanged_within_its_front() -> None:
    fronts, _ = analysed(sparse.csr_array(np.ones((1, 2))))
    storage, swap, x = np.array([0.0, 2.0, 4.0, 0.0]), np.zeros(2, dtype=np.int64), np.array([6.0, 8.0])
    assert factorise(fronts, storage, swap, 1e-14) == 0
    solve_factorised(fronts, storage, swap, x)
    assert x.tolist() == [2.0, 3.0]


@pytest.mark.parametrize("entry", [0.0, np.nan])
def test_singular_matrix(entry) -> None:
    fronts, _ = analysed(sparse.csr_array([[1.0]]))
    storage, swap, x = np.array([entry]), np.zeros(1, dtype=np.int64), np.array([1.0])
    assert factorise(fronts, storage, swap, 1e-3) == 1
    solve_factorised(fronts, storage, swap, x)
    assert x[0] == pytest.approx(1e3)


@pytest.mark.parametrize(("rows", "entries"), [(8, 4581), (15, 29007), (40, 462933)])
def test_pyramid_fill(rows, entries) -> None:
    """The entries of the fronts with SuperLU's ordering MMD_AT_PLUS_A."""
    fronts, _ = analysed(pattern("pyramid", rows=rows))
    assert fronts.start[-1] < 1.1 * entries
