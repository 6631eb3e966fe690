"""Path search: its starts and its basis."""

import numpy as np
from scipy import sparse

from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve
from frictionbench.solvers.pivots.lu_basis import Columns, new_basis
from tests.helpers.friction_problems import assert_solved
from tests.helpers.kernels import (
    basic_z,
    factorise_basis,
    set_complementary_basis,
)


def test_random_problems_of_varied_size() -> None:
    for seed in range(300, 350):
        assert_solved(random_problem(seed, contacts=1 + seed % 25), "path_search[crash=0]")


def test_crash_start_shortens_path() -> None:
    problems = [random_problem(seed, contacts=30) for seed in range(20)]
    pivots = [sum(solve(p, spec).work["pivots"] for p in problems) for spec in ("path_search", "path_search[crash=0]")]
    assert pivots[0] < 0.95 * pivots[1]


def test_small_pivots_of_long_stacks_are_taken_without_new_factors() -> None:
    work = assert_solved(scene("stack", blocks=600, push=1.0).problem(), "path_search").work
    assert work["factorisations"] < work["pivots"] / 60


def random_columns(n, rank, seed=0) -> tuple[Columns, np.ndarray]:
    """The columns of a sparse M with dependent columns, and [M, -I, cover] dense."""
    random = np.random.default_rng(seed)
    M = random.standard_normal((n, rank)) @ (random.standard_normal((rank, n)) * (random.random((rank, n)) < 0.5))
    packed, cover = sparse.csc_array(M), random.standard_normal(n)
    columns = Columns(packed.indptr.astype(np.int64), packed.indices.astype(np.int64), packed.data, cover)
    return columns, np.column_stack([M, -np.eye(n), cover])


def test_dependent_columns_are_left_out() -> None:
    n, rank = 12, 5
    columns, dense = random_columns(n, rank)
    basis = new_basis(n, n * n)
    set_complementary_basis(basis, np.ones(n, bool))
    assert factorise_basis(basis, columns, 1e-9, np.inf) == n - rank
    assert np.linalg.cond(dense[:, basis.head]) < 1e6
    A = np.empty(n, bool)
    basic_z(basis, A)
    assert A.sum() == rank
