"""The basis of the pivoting methods, and Dantzig's and Murty's methods in and outside their guaranteed cases."""

import numpy as np

from frictionbench.problems import LCP
from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual
from frictionbench.solvers.dantzig import contact_order
from frictionbench.solvers.interface import Status, solve
from frictionbench.solvers.pivots.inverse_basis import compress
from frictionbench.solvers.pivots.lemke_path import USUAL
from tests.helpers.kernels import entering_column, exchange, follow_lemke_path, lemke_state


def test_compress_keeps_every_entry_of_an_unsymmetric_matrix():
    lcp = random_problem(1, 5).lcp()
    M = compress(lcp.rows, np.ones(lcp.size))
    column, row = np.zeros((2, lcp.size, lcp.size))
    j = np.repeat(np.arange(lcp.size), np.diff(M.start))
    column[M.rows, j] = M.column
    row[j, M.rows] = M.row
    assert np.array_equal(column, lcp.dense)
    assert np.array_equal(row, lcp.dense)


def test_basis_update_after_pivots():
    """Random pivots: z for w, z for z, w for w, w for z; the transformed columns stay those of the basis matrix."""
    random = np.random.default_rng(5)
    n = 12
    M = random.standard_normal((n, n)) * (random.random((n, n)) < 0.6) + np.eye(n)
    d, state = np.ones(n), lemke_state(compress(LCP(M, np.zeros(n)).rows, np.ones(n)), n)
    state.basis.d[:] = d
    is_basic = np.array([True] * n + [False] * (n + 1))  # w, z, z0
    columns = np.hstack([-np.eye(n), M, d[:, None]])  # of  M z + d z0 - w = -q
    kinds = set()
    for _ in range(200):
        free = [i for i in range(n) if not is_basic[i] and not is_basic[n + i]]  # the missing pair, once z0 is basic
        p = free[0] if free else n
        z_enters = p == n or bool(random.random() < 0.5)
        entering_column(state, p, z_enters, 1e-15)
        a, inside, entering = state.a, np.flatnonzero(is_basic), 2 * n if p == n else n + p if z_enters else p
        values = a[np.where(inside < n, inside, inside - n)]
        np.testing.assert_allclose(columns[:, inside] @ values, columns[:, entering], atol=1e-9)
        choices = [i for i in range(n) if abs(a[i]) > 0.1 and (is_basic[i] or is_basic[n + i])]
        if not choices:
            break
        s = int(random.choice(choices))
        leaving = s if is_basic[s] else n + s
        exchange(state, p, z_enters, s, 0.0)
        is_basic[leaving] = False
        is_basic[entering] = True
        kinds.add((z_enters, leaving >= n))
    assert kinds == {(True, False), (True, True), (False, False), (False, True)}


def test_a_path_that_starts_nonnegative_has_no_pivot():
    state = lemke_state(compress(LCP([[1]], [1]).rows, np.ones(1)), 1)
    state.q[:] = state.basis.d[:] = state.x[0] = 1.0
    assert follow_lemke_path(state, 0.0, USUAL, 10, np.inf) == 0
    assert state.work[0] == 0


def test_dantzig_solves_frictionless_contact_of_any_rank():
    for seed in range(60):
        problem = random_problem(seed, contacts=1 + seed % 30, friction=0.0)
        answer = solve(problem, "dantzig")
        assert answer.status is Status.SOLVED
        assert residual(problem, answer.impulse) <= 1e-12


def test_dantzig_takes_the_pairs_contact_by_contact():
    # z = (c1, c2, beta1+, beta1-, beta2+, beta2-, lambda1, lambda2)
    assert contact_order(8, 2).tolist() == [0, 6, 2, 3, 1, 7, 4, 5]
