"""Libraries of the relaxation in closed loop: what they claim is as accurate as their own criteria can tell."""

from functools import cache

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.residual import relaxation_residual
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import simulate
from frictionbench.solvers import Status, solve
from frictionbench.solvers.outside.scaled_program import scaled_program
from tests.helpers.friction_problems import block, installed, spatial

TOL = 1e-8


@cache
def steps() -> list[FrictionProblem]:
    """Every third problem of a motion with impacts, whose contacts are often about to slide or to part."""
    return steps_of("three_blocks", "anitescu_potra", 150)[::3]


def steps_of(name: str, scheme: str, count: int) -> list[FrictionProblem]:
    """The problems of the first steps of a scene's motion."""
    met = []

    def record(problem: FrictionProblem) -> np.ndarray:
        met.append(problem)
        return solve(problem, "hybrid", tol=TOL).impulse

    for _ in simulate(scene(name), record, SCHEMES[scheme], count):
        pass
    return met


@pytest.mark.parametrize(
    "spec",
    [
        *("clarabel", "clarabel[settings=tuned]", "osqp", "scs"),
        *("proxsuite[matrices=sparse,settings=tuned]", "piqp", "piqp[matrices=dense]", "daqp"),
    ],
)
def test_claims_hold_in_closed_loop(spec) -> None:
    installed(spec)
    answers = [solve(problem, spec, tol=TOL) for problem in steps()]
    claimed = np.array([answer.status in (Status.SOLVED, Status.ROUNDING) for answer in answers])
    residuals = np.array([relaxation_residual(p, answer.impulse) for p, answer in zip(steps(), answers, strict=True)])
    assert residuals[claimed].max() <= 10 * TOL
    assert (residuals[claimed] > TOL).mean() <= 0.02


@pytest.mark.parametrize("spec", ["clarabel"])
def test_claims_hold_beside_fast_belts(spec) -> None:
    """The scheme of accelerations moves belts a thousand times as fast as contacts: the change of velocity alone is small."""
    problems = steps_of("two_blocks", "acceleration", 20)
    answers = [solve(problem, spec, tol=TOL) for problem in problems]
    assert sum(answer.status is Status.SOLVED for answer in answers) >= 5
    for problem, answer in zip(problems, answers, strict=True):
        assert relaxation_residual(problem, answer.impulse) <= TOL


def test_a_friction_bias_of_roundings_size_is_no_variable() -> None:
    """Its slack would cost nothing, grow, and hide errors behind the norm of all variables."""
    problem = block(speed=1.0, friction_bias=[1e-18])
    assert len(problem.qp().q) == len(problem.free_velocity)
    assert len(block(speed=1.0, friction_bias=[1e-3]).qp().q) == len(problem.free_velocity) + 1


@pytest.mark.parametrize("d", [2, 3])
def test_a_motion_of_the_bodies_with_the_same_contact_velocities_is_the_same_program(d) -> None:
    problem = random_problem(3, contacts=4, bodies=6) if d == 2 else spatial(3, contacts=3)
    J = np.vstack([problem.normal.toarray(), problem.tangent.toarray()])
    null = np.linalg.svd(J)[2][np.linalg.matrix_rank(J) :]
    moved = problem.replace(free_velocity=problem.free_velocity + 1e3 * null[-1])
    assert np.abs(J @ null[-1]).max() < 1e-12
    one, other = (scaled_program(p, from_free=True) for p in (problem, moved))
    assert not one.q.any()
    assert not other.q.any()
    assert one.h == pytest.approx(other.h, abs=1e-9)
