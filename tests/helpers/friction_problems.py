"""Small problems that several tests share."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.residual import relaxation_residual, residual
from frictionbench.solvers import Status, find, solve


def contacts_of(normal, tangent, friction, free_velocity, mass=None, bias=0.0, **more) -> FrictionProblem:
    """The problem of contacts with these rows; of unit masses unless given. friction, bias: one for all contacts, or each."""
    nc = len(normal)
    return FrictionProblem(
        mass=np.eye(len(free_velocity)) if mass is None else mass,
        normal=normal,
        tangent=tangent,
        friction=np.broadcast_to(friction, nc),
        free_velocity=free_velocity,
        bias=np.broadcast_to(bias, nc),
        dimension=1 + len(tangent) // nc,
        **more,
    )


def block(speed=1.0, friction=0.5, mass=2.0, h=0.01, **more) -> FrictionProblem:
    """A point mass on the ground under gravity, sliding at `speed`."""
    return contacts_of([[0.0, 1.0]], [[1.0, 0.0]], friction, [speed, -9.81 * h], mass=mass * np.eye(2), **more)


def known_by_W(problem) -> FrictionProblem:
    """The problem of which only the Delassus matrix is known."""
    return FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, problem.dimension, problem.friction_bias)


def nothing(dimension=2) -> FrictionProblem:
    """No contact at all."""
    return FrictionProblem(
        mass=np.eye(3),
        normal=np.zeros((0, 3)),
        tangent=np.zeros((0, 3)),
        friction=[],
        free_velocity=[1.0, 2.0, 3.0],
        bias=[],
        dimension=dimension,
    )


def spatial(seed, contacts=5, nv=18, friction=None, friction_bias=False, joints=0) -> FrictionProblem:
    """Random spatial contacts on nv velocities, with a few joints and friction biases if asked for."""
    random = np.random.default_rng(seed)
    rows = random.standard_normal((3 * contacts, nv)) * (random.random((3 * contacts, nv)) < 0.5)
    each = np.arange(3 * contacts).reshape(contacts, 3)
    return FrictionProblem(
        mass=np.diag(10 ** random.random(nv)),
        normal=rows[each[:, 0]],
        tangent=rows[each[:, 1:].ravel()],
        friction=np.full(contacts, random.uniform(0.05, 1) if friction is None else friction),
        free_velocity=random.standard_normal(nv),
        bias=np.zeros(contacts),
        friction_bias=0.3 * random.random(contacts) if friction_bias else None,
        joints=random.standard_normal((joints, nv)),
        dimension=3,
    )


def with_joints(problem, joints, friction_bias=None) -> FrictionProblem:
    """A problem with joints F v = 0 and a friction bias added."""
    return problem.replace(joints=joints, joint_bias=None, friction_bias=friction_bias)


def installed(spec):
    """What is known of a solver, and the solver; the test is skipped if a library is missing."""
    info, solver = find(spec)
    return pytest.skip(info.missing) if info.missing else (info, solver)


def own_residual(spec, problem, answer) -> float:
    """The residual of the model that the solver is for."""
    info, _ = find(spec)
    if info.model in ("relaxation", "regularised"):
        return relaxation_residual(problem, answer.impulse, answer.softness)
    if info.model == "lcp" and problem.dimension == 3:
        return problem.lcp().residual(answer.z)
    return residual(problem, answer.impulse)


def lemke(problem, tol=1e-8) -> np.ndarray:
    """Impulses that solve the problem, by Lemke's method, or in space, where that takes a polygon, by an interior point."""
    answer = solve(problem, "lemke" if problem.dimension == 2 else "interior_point", tol=tol)
    assert answer.status is Status.SOLVED
    assert residual(problem, answer.impulse) <= tol
    return answer.impulse


def assert_solved(problem, spec, tol=1e-8, **how):
    """The answer of a method, which claims and has a residual of its model within the tolerance."""
    answer = solve(problem, spec, tol=tol, **how)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)  # of extreme masses and near jams
    assert own_residual(spec, problem, answer) <= tol
    return answer
