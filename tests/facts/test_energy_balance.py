"""The energy balance of one step, an exact identity for every solution."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import residual
from frictionbench.problems.verify import ledger_defect
from tests.helpers.friction_problems import contacts_of


def kinetic(problem, v) -> float:
    return float(v @ (problem.mass @ v)) / 2


def law(problem, impulse) -> float:
    """T(v*) - |H z|^2/2 in M^-1 - b'c - lambda'(mu c + b_f), lambda = |u_t|."""
    free = problem.velocity(np.zeros_like(impulse))
    c, slip = impulse[:, 0], np.abs(problem.contact_velocity(impulse)[:, 1])
    change = problem.velocity(impulse) - free
    return (
        kinetic(problem, free)
        - kinetic(problem, change)
        - problem.bias @ c
        - slip @ (problem.friction * c + problem.friction_bias)
    )


def designed(seed) -> tuple[FrictionProblem, np.ndarray]:
    """A problem made around a solution: every contact open, stuck or sliding at random, bias of either sign, with a joint."""
    random = np.random.default_rng(seed)
    nc, nv = int(random.integers(1, 5)), 9
    root = random.standard_normal((nv, nv))
    M = root @ root.T + np.eye(nv)
    N, T, F = random.standard_normal((nc, nv)), random.standard_normal((nc, nv)), random.standard_normal((1, nv))
    mu, at_hand = random.uniform(0, 2, nc), np.where(random.random(nc) < 0.5, random.random(nc), 0)
    is_open, sticks = random.random(nc) < 0.3, random.random(nc) < 0.4
    v = random.standard_normal(nv)
    held = np.vstack([F, T[sticks]])
    v -= np.linalg.pinv(held) @ held @ v
    u_t = np.where(sticks, 0, T @ v)
    c = np.where(is_open, 0, random.random(nc))
    limit = mu * c + at_hand
    r = np.column_stack([c, np.where(sticks, random.uniform(-1, 1, nc) * limit, -np.sign(u_t) * limit)])
    bias = np.where(is_open, random.random(nc), 0) - N @ v
    push = N.T @ r[:, 0] + T.T @ r[:, 1] + F.T @ random.standard_normal(1)
    problem = contacts_of(N, T, mu, v - np.linalg.solve(M, push), mass=M, bias=bias, friction_bias=at_hand, joints=F)
    return problem, r


@pytest.mark.parametrize("seed", range(15))
def test_energy_balance_of_constructed_solutions(seed) -> None:
    problem, r = designed(seed)
    assert residual(problem, r) <= 1e-12
    size = kinetic(problem, problem.free_velocity) + abs(law(problem, r))
    assert kinetic(problem, problem.velocity(r)) == pytest.approx(law(problem, r), abs=2e-11 * size)
    assert ledger_defect(problem, r) == pytest.approx(0, abs=2e-11 * size)


@pytest.mark.parametrize("seed", range(10))
def test_energy_balance_of_arbitrary_impulses(seed) -> None:
    """ledger_defect is what is wanting, also for an answer that is no solution."""
    problem, r = designed(seed)
    wrong = r * 1.1
    size = kinetic(problem, problem.free_velocity) + abs(law(problem, wrong))
    want = kinetic(problem, problem.velocity(wrong)) - law(problem, wrong)
    assert ledger_defect(problem, wrong) == pytest.approx(want, abs=1e-10 * size)
    assert abs(want) > 1e-6 * size
