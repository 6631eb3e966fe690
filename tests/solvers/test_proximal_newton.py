"""Proximal Newton in space: the equations are exact, and problems on which interior points stagnate are solved."""

import numpy as np
import pytest

from frictionbench.problems.instances import make_instance
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, solve
from frictionbench.solvers.interior.newton import new_work
from frictionbench.solvers.interior.system import build_system
from frictionbench.solvers.proximal_newton import new_state
from tests.helpers.friction_problems import spatial
from tests.helpers.kernels import equations, newton_step


@pytest.mark.parametrize("rho", [1e-3, 1.0])
@pytest.mark.parametrize("seed", range(2))
def test_newton_step_to_first_order(seed, rho) -> None:
    """At impulses of every kind: open, sticking and sliding contacts, with a friction bias."""
    problem = spatial(seed, contacts=12, nv=24, friction=0.7, friction_bias=True)
    system, random = build_system(problem), np.random.default_rng(seed)
    work, step = new_work(system, np.inf), np.zeros((12, 3))
    state, ahead = new_state(system), new_state(system)
    anchor = random.standard_normal((12, 3))
    state.r[:] = random.standard_normal((12, 3))
    equations(system, state, anchor, rho, work)
    newton_step(system, state, anchor, rho, step, work)
    h = 1e-7
    ahead.r[:] = state.r + h * step
    equations(system, ahead, anchor, rho, work)
    change = (ahead.F - state.F) / h
    assert np.allclose(change, -state.F, atol=1e-5 * (1 + abs(step).max() ** 2))


@pytest.mark.parametrize("seed", [0, 11])
def test_large_friction(seed) -> None:
    problem = make_instance("random_bodies", seed=seed, friction=1000.0)
    assert solve(problem, "interior_point").work["relaxation_ip factorisations"] > 0  # asked where it is trapped
    assert residual(problem, solve(problem, "proximal_newton").impulse) <= 1e-8


@pytest.mark.parametrize("seed", range(2))
def test_last_digits_take_a_few_steps(seed) -> None:
    """Impulses of a pyramid are not unique: with rho = 1 at first they drift along the solutions in up to 24 steps."""
    problem = make_instance("sphere_pyramid", seed=seed, levels=4)
    near = solve(problem, "interior_point", tol=1e-5).impulse
    answer = solve(problem, "proximal_newton", tol=1e-8, start=near)
    assert answer.status is Status.SOLVED
    assert answer.work["factorisations"] <= 5


def test_joints_leave_the_matrix_sparse_and_are_held_from_a_start() -> None:
    problem = make_instance("rod_chain", links=30)
    system = build_system(problem)
    assert system.fronts.start[-1] < problem.q.size**2 / 5
    answer = solve(problem, "proximal_newton")
    assert answer.status is Status.SOLVED
    near = solve(problem, "proximal_newton", start=answer.impulse * (1 + 1e-4))
    assert near.status is Status.SOLVED
    assert near.work["factorisations"] <= answer.work["factorisations"] / 2
