"""Newton's method on Fischer-Burmeister and min-map equations: guaranteed cases, failures and their status."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, solve
from frictionbench.solvers.merit_newton import SOLVED, equations, iterate, jacobian, new_descent

BOTH = ["fischer_newton", "minmap_newton"]


def contact(random) -> FrictionProblem:
    """One planar contact, W = [[a, b], [b, g]]."""
    root, mu, q = random.standard_normal((2, 2)), random.uniform(0, 4), random.standard_normal(2)
    return FrictionProblem.from_delassus(root @ root.T, q, [mu], 2)


def index(problem) -> float:
    """a - mu |b| of a single contact."""
    W = problem.W.toarray()
    return W[0, 0] - problem.friction[0] * abs(W[0, 1])


@pytest.mark.parametrize("spec", ["fischer_newton", "fischer_newton[regularisation=0]"])
def test_fischer_solves_every_contact_that_is_p0(spec) -> None:
    random = np.random.default_rng(1)
    problems = [p for p in (contact(random) for _ in range(400)) if index(p) >= 0]
    assert len(problems) > 150
    for problem in problems:
        assert solve(problem, spec).status is Status.SOLVED


@pytest.mark.parametrize("a", [1.1, 2.0, 10.0])
def test_line_search_avoids_min_map_cycle(a) -> None:
    M, q = np.array([[1, 0, a], [a, 1, 0], [0, a, 1]]), np.ones(3)
    start = np.array([-1.0, 0, 0])
    descent = new_descent(np.ones((2, 3)), 1e-10, 200, 15, 1e-8)
    end, k = iterate(M, q, start, descent, 0.0, False)
    assert end == SOLVED
    assert descent.history[k] <= 1e-10
    assert descent.best == pytest.approx(np.zeros(3), abs=1e-9)


def solved(spec) -> int:
    """How many random problems are, each of which is claimed and no other."""
    count = 0
    for seed in range(60):
        problem = random_problem(seed, contacts=1 + seed % 30)
        answer = solve(problem, spec)
        assert (answer.status is Status.SOLVED) == (residual(problem, answer.impulse) <= 1e-8)
        count += answer.status is Status.SOLVED
    return count


@pytest.mark.parametrize(("spec", "least"), [("fischer_newton", 54), ("minmap_newton", 48)])
def test_most_random_problems_are_solved(spec, least) -> None:
    assert solved(spec) >= least


def test_regularisation_for_redundant_contacts() -> None:
    assert solved("fischer_newton[regularisation=0]") < solved("fischer_newton") - 15


@pytest.mark.parametrize("spec", BOTH)
def test_history_and_work_count_the_iterations_and_repeat(spec) -> None:
    problem = random_problem(0, contacts=20)
    answer, again = solve(problem, spec), solve(problem, spec)
    assert answer.status is Status.SOLVED
    assert len(answer.history) == answer.work["newton"] + answer.work["gradient"] + 1
    assert min(answer.history) == answer.history[-1] < 1e-8 < answer.history[0]
    assert (answer.work, answer.history) == (again.work, again.history)
    limited = solve(problem, spec, limit=2)
    assert limited.status is Status.WORK_LIMIT
    assert len(limited.history) == 3


def test_fischer_function_accuracy() -> None:
    found = equations(np.array([1.0, 3.0, -2.0, 0.0]), np.array([1e-20, 4.0, 0.0, 0.0]), True)
    assert found == pytest.approx([-1e-20, -2.0, 4.0, 0.0], rel=1e-15, abs=1e-300)


def test_the_gradient_of_the_merit() -> None:
    random, n, h = np.random.default_rng(4), 6, 1e-6
    M, q, y = random.standard_normal((n, n)), random.standard_normal(n), random.standard_normal(n)

    def merit(y):
        return np.sum(equations(y, M @ y + q, True) ** 2) / 2

    phi = equations(y, M @ y + q, True)
    A, B = jacobian(y, M @ y + q, True)
    expected = [(merit(y + h * e) - merit(y - h * e)) / (2 * h) for e in np.eye(n)]
    assert A * phi + (B * phi) @ M == pytest.approx(expected, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("spec", BOTH)
def test_claims_for_contacts_of_unlike_masses(spec) -> None:
    """A negative impulse within the tolerance at a heavy contact moves a light one by more; W is unsymmetric."""
    random, claims = np.random.default_rng(0), 0
    for seed in range(40):
        given = random_problem(seed, contacts=20)
        size, W = np.repeat(10 ** random.uniform(-2, 2, 20), 2), given.W.toarray()
        skew = np.triu(random.standard_normal(W.shape), 1) * 1e-5 * np.sqrt(np.outer(W.diagonal(), W.diagonal()))
        W = (W + skew - skew.T) * np.outer(size, size)
        problem = FrictionProblem.from_delassus(W, given.q * size, given.friction, 2)
        answer = solve(problem, spec)
        claims += answer.status is Status.SOLVED
        assert (answer.status is Status.SOLVED) == (residual(problem, answer.impulse) <= 1e-8)
    assert claims >= 20
