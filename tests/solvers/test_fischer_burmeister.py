"""Semismooth Newton in the velocities: by itself, and where interior_point needs it."""

import numpy as np
import pytest

from frictionbench.problems.random_problem import random_problem
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers.interior.fischer_burmeister import fischer_burmeister
from frictionbench.solvers.interior.newton import new_work
from frictionbench.solvers.interior.phases import Phased
from frictionbench.solvers.interior.point import start_point
from frictionbench.solvers.interior.predictor_corrector import nothing_yet
from frictionbench.solvers.interior.system import space_of
from tests.helpers.friction_problems import block, nothing, with_joints

TOL = 1e-9


def newton(problem, limit=100):
    """The impulses, the iterations and their history."""
    phased = Phased()
    _, system = phased.setup(phased.form(problem))
    best = nothing_yet(*system.offset.shape)
    history, point = np.full(limit, np.nan), start_point(system, 1.0, 1.0)
    count = fischer_burmeister(
        system, space_of(system), point, new_work(system, np.inf), best, TOL / problem.spread, 0, history
    )
    return best.impulse * system.impulse, count, history


def jointed():
    problem = random_problem(3, contacts=10)
    return with_joints(problem, np.random.default_rng(3).standard_normal((2, len(problem.free_velocity))))


@pytest.mark.parametrize(
    "problem",
    [
        block(),
        block(friction=0.0),
        nothing(),
        random_problem(1, contacts=40),
        random_problem(2, contacts=20, friction=0.0),
        scene("stack", blocks=10, push=1.0).problem(),  # redundant contacts: W is singular
        jointed(),
    ],
    ids=["sliding", "frictionless", "nothing", "random", "frictionless-random", "stack", "joints"],
)
def test_solves(problem) -> None:
    impulse, count, history = newton(problem)
    assert residual(problem, impulse) <= TOL
    assert count < 60
    assert np.isfinite(history[:count]).all()
    assert np.isnan(history[count:]).all()


def test_stops_where_the_history_is_full() -> None:
    problem = random_problem(1, contacts=40)
    impulse, count, history = newton(problem, limit=3)
    assert count == 3
    assert TOL < residual(problem, impulse) <= history.min() * problem.spread
