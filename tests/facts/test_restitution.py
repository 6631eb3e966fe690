"""Energy of one impact: Newton's restitution law can raise it, and so can Poisson's without the cone of both phases.

Poisson's law itself never does: test_schemes.
"""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.random_problem import random_problem
from frictionbench.solvers import Status, solve


def impact(base, velocity, bias=0.0) -> FrictionProblem:
    return base.replace(free_velocity=velocity, bias=np.broadcast_to(bias, base.contacts))


def response(problem) -> tuple[Array, Array]:
    """(impulse, velocity after it)."""
    answer = solve(problem, "lemke", tol=1e-11)
    assert answer.status in (Status.SOLVED, Status.ROUNDING)
    return answer.impulse, problem.velocity(answer.impulse)


def newton(base, v, e) -> Array:
    """n'v+ = -e n'v where the contact presses."""
    return response(impact(base, v, bias=np.minimum(e * (base.normal @ v), 0)))[1]


def poisson(base, v, e) -> Array:
    """Decompression returns e c, with friction up to mu c_x in place of Poisson's mu (e c + c_x)."""
    compression, pressed = response(impact(base, v))
    return response(impact(base, pressed + base.inverse_mass @ (base.normal.T @ (e * compression[:, 0]))))[1]


def single(seed) -> tuple[FrictionProblem, Array]:
    """A body that hits the ground with one point."""
    base = random_problem(seed, contacts=1, bodies=1, friction=float(np.random.default_rng(seed).random()))
    v = base.free_velocity
    return base, v if (base.normal @ v)[0] < 0 else -v


def gain(base, before, after) -> float:
    return float(after @ (base.mass @ after) / (before @ (base.mass @ before))) - 1


@pytest.mark.parametrize(("e", "share"), [(0.8, (0.005, 0.05)), (1.0, (0.08, 0.25))])
def test_newton_restitution_can_gain_energy(e, share) -> None:
    """Here in about 2 % and 15 % of 400, up to more than double; where e = 0 in none."""
    gains = np.array([gain(base, v, newton(base, v, e)) for base, v in map(single, range(400))])
    assert share[0] < np.mean(gains > 1e-9) < share[1]
    assert gains.max() > 1.0
    assert max(gain(base, v, newton(base, v, 0.0)) for base, v in map(single, range(100))) <= 1e-9


def test_second_impulse_cone_can_gain_energy() -> None:
    gains = [gain(base, v, poisson(base, v, 0.8)) for base, v in map(single, range(200))]
    assert max(gains) > 0.5
