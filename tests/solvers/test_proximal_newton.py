"""Proximal Newton in space: problems on which interior points stagnate are solved, and its last digits take a few steps."""

import pytest

from frictionbench.problems.catalogue import make_instance
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, solve
from frictionbench.solvers.interior.system import build_system


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
    assert (answer.status, answer.work["factorisations"] <= 5) == (Status.SOLVED, True)


def test_joints_leave_the_matrix_sparse_and_are_held_from_a_start() -> None:
    problem = make_instance("rod_chain", links=30)
    assert build_system(problem).fronts.start[-1] < problem.q.size**2 / 5
    answer = solve(problem, "proximal_newton")
    near = solve(problem, "proximal_newton", start=answer.impulse * (1 + 1e-4))
    assert answer.status is near.status is Status.SOLVED
    assert near.work["factorisations"] <= answer.work["factorisations"] / 2
