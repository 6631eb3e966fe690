"""Path search: its starts, its basis and its measure of the end."""

import numpy as np
import pytest
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve
from frictionbench.solvers.pivots.lu_basis import Columns, new_basis
from frictionbench.solvers.pivots.natural import MARGIN, natural_weight
from frictionbench.solvers.pivots.scaling import scaling
from tests.helpers.friction_problems import assert_solved
from tests.helpers.kernels import (
    basic_z,
    factorise_basis,
    natural_residual,
    set_complementary_basis,
)


@pytest.mark.parametrize("spec", ["path_search[crash=0]", "path_search[proximal=0.01]"])
def test_random_problems_of_varied_size(spec) -> None:
    work = [assert_solved(random_problem(seed, contacts=1 + seed % 25), spec).work for seed in range(300, 350)]
    proximal = sum(count["newton"] > 1 for count in work)
    assert proximal == 0 if "crash" in spec else proximal > 10


def test_crash_start_shortens_path() -> None:
    problems = [random_problem(seed, contacts=30) for seed in range(20)]
    pivots = [sum(solve(p, spec).work["pivots"] for p in problems) for spec in ("path_search", "path_search[crash=0]")]
    assert pivots[0] < 0.95 * pivots[1]


def test_small_pivots_of_long_stacks_are_taken_without_new_factors() -> None:
    work = assert_solved(scene("stack", blocks=600, push=1.0).problem(), "path_search").work
    assert work["factorisations"] < work["pivots"] / 60


def random_columns(n, rank, seed=0) -> tuple[Columns, np.ndarray]:
    """The columns of a sparse M with dependent columns, and [M + prox, -I, cover] dense."""
    random = np.random.default_rng(seed)
    M = random.standard_normal((n, rank)) @ (random.standard_normal((rank, n)) * (random.random((rank, n)) < 0.5))
    packed, prox, cover = sparse.csc_array(M), np.zeros(n), random.standard_normal(n)
    columns = Columns(packed.indptr.astype(np.int64), packed.indices.astype(np.int64), packed.data, prox, cover)
    return columns, np.column_stack([M, -np.eye(n), cover])


def test_dependent_columns_are_left_out() -> None:
    n, rank = 12, 5
    columns, dense = random_columns(n, rank)
    basis = new_basis(n)
    set_complementary_basis(basis, np.ones(n, bool))
    assert factorise_basis(basis, columns, 1e-9, np.inf) == n - rank
    assert np.linalg.cond(dense[:, basis.head]) < 1e6
    A = np.empty(n, bool)
    basic_z(basis, A)
    assert A.sum() == rank


def measured(problem, z) -> float:
    """The natural residual at z (n,)."""
    lcp = problem.lcp()
    scale = scaling(lcp)
    y = z / (scale.theta * scale.D)
    w = scale.matrix(lcp) @ y + scale.vector(lcp.q)
    return natural_residual(natural_weight(problem, lcp, scale), y, w)


def test_natural_residual_is_independent_of_units() -> None:
    """Grams for kilograms change M, z and the LCP's residual by 1000; a millionfold mass ratio drowns no contact."""
    problem = random_problem(4, contacts=8, mass_ratio=1e6)
    small = FrictionProblem.from_delassus(1e-3 * problem.W, problem.q, problem.friction, 2)
    z = np.random.default_rng(0).random(32)
    assert measured(problem, z) == pytest.approx(measured(small, np.r_[np.full(24, 1e3), np.ones(8)] * z), rel=1e-9)


def test_natural_residual_bounds_the_exact_one() -> None:
    random = np.random.default_rng(0)
    for seed in range(60):
        problem = random_problem(seed, contacts=1 + seed % 10, mass_ratio=1e4)
        lcp = problem.lcp()
        size = scaling(lcp).theta * scaling(lcp).D
        z = np.maximum(solve(lcp, "path_search").z + 1e-3 * size * random.standard_normal(lcp.size), 0)
        assert residual(problem, lcp.impulse(z)) <= measured(problem, z) / MARGIN
