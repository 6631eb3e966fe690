"""Properties of the friction LCP's matrix Q, pages 22-25 of Anitescu's talk (1999); z = (c, beta, lambda) in the plane."""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.thresholds import is_p0
from frictionbench.problems.random_problem import random_problem
from tests.helpers.friction_problems import contacts_of


def one_contact(a, b, g, mu) -> FrictionProblem:
    return FrictionProblem.from_delassus([[a, b], [b, g]], [-1, 0], [mu], 2)


def random_contact(seed) -> tuple[float, float, float]:
    root = np.random.default_rng(seed).standard_normal((2, 2))
    W = root @ root.T
    return W[0, 0], W[0, 1], W[1, 1]


def two_corner_block(mu, H=1.0, w=1.0) -> FrictionProblem:
    return contacts_of(
        [[0, 1, -w / 2], [0, 1, w / 2]], [[1, 0, H / 2]] * 2, mu, [0, -1, 0], mass=np.diag([1, 1, (w * w + H * H) / 12])
    )


def is_column_sufficient(Q) -> bool:
    """z o Qz <= 0 only where z o Qz = 0, by linear programming over the signs of z.

    In an orthant {s z >= 0, s Qz <= 0} is a convex cone; a z in it with z_i (Qz)_i < 0 exists iff both |z_i| and |(Qz)_i| can
    be positive there.
    """
    n = len(Q)
    for signs in product([1.0, -1.0], repeat=n):
        S = np.diag(signs)
        for i in range(n):
            reach = [
                linprog(-row, A_ub=S @ Q, b_ub=np.zeros(n), bounds=[(0, 1) if s > 0 else (-1, 0) for s in signs]).fun
                for row in (signs[i] * np.eye(n)[i], -signs[i] * Q[i])
            ]
            if max(reach) < -1e-9:
                return False
    return True


@pytest.mark.parametrize("seed", range(10))
def test_never_row_sufficient(seed) -> None:
    """z = (mu/(2a), 0, 0, -1) at one contact of any problem, zero at the others."""
    problem = random_problem(seed, contacts=1 + seed % 5)
    lcp, nc = problem.lcp(), problem.contacts
    mu, a = problem.friction[0], problem.W.toarray()[0, 0]
    z, want = np.zeros(4 * nc), np.zeros(4 * nc)
    z[0], z[3 * nc] = mu / (2 * a), -1
    want[0] = -(mu**2) / (4 * a)
    assert z * (lcp.M.T @ z) == pytest.approx(want, abs=1e-12)
    assert want[0] < 0


@pytest.mark.parametrize("mu", [0.1, 2.0])
def test_not_column_sufficient_without_pointed_cone(mu) -> None:
    """A particle between two walls: N c = 0 for c = (1, 1), and z = (c, 0, -1) has z o Qz = (0, 0, -mu c)."""
    jam = contacts_of([[1, 0], [-1, 0]], [[0, 1], [0, 1]], mu, [0, 1])
    z = np.array([1, 1, 0, 0, 0, 0, -1, -1.0])
    assert z * (jam.lcp().M @ z) == pytest.approx([0, 0, 0, 0, 0, 0, -mu, -mu])


@pytest.mark.parametrize("factor", [0.2, 0.9, 1.1, 3.0])
@pytest.mark.parametrize("seed", range(3))
def test_one_contact_column_sufficiency(seed, factor) -> None:
    a, b, g = random_contact(seed)
    problem = one_contact(a, b, g, factor * a / abs(b))
    assert is_column_sufficient(problem.lcp().dense) is (factor < 1)
    assert is_p0(problem) is (factor < 1)


@pytest.mark.parametrize("seed", range(8))
def test_determinant_of_one_contact(seed) -> None:
    a, b, g = random_contact(seed)
    for mu in (0.0, 0.3, 5.0):
        assert np.linalg.det(one_contact(a, b, g, mu).lcp().dense) == pytest.approx(4 * (a * g - b * b), rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_the_quadratic_form(seed) -> None:
    """z'Qz = |N c + D beta|^2 in M^-1 + lambda'U c, so Q is copositive."""
    problem = random_problem(seed, contacts=1 + seed % 6)
    nc = problem.contacts
    lcp = problem.lcp()
    z = np.random.default_rng(seed).standard_normal(4 * nc)
    push = problem.jacobian.T @ lcp.impulse(z).ravel()
    want = push @ (problem.inverse_mass @ push) + z[3 * nc :] @ (problem.friction * z[:nc])
    assert z @ (lcp.M @ z) == pytest.approx(want, rel=1e-10)
    positive = np.abs(z)
    assert positive @ (lcp.M @ positive) > 0


def test_copositive_but_not_copositive_plus() -> None:
    """z = (0, 0, 1) >= 0 has z'Qz = 0, and (Q + Q')z = (mu, 0, 0), which is not zero."""
    Q = one_contact(2.0, 0.5, 1.0, 0.3).lcp().dense
    z = np.array([0, 0, 0, 1.0])
    assert z @ Q @ z == 0
    assert (Q + Q.T) @ z == pytest.approx([0.3, 0, 0, 0])


@pytest.mark.parametrize(("H", "w"), [(1.0, 1.0), (2.0, 1.0), (1.0, 3.0)])
@pytest.mark.parametrize("factor", [0.2, 0.97, 1.03, 4.0])
def test_two_corner_block_p0_threshold(H, w, factor) -> None:
    """The threshold is mu H / w = 1."""
    assert is_p0(two_corner_block(factor * w / H, H, w)) is (factor < 1)
