"""A ball on a plane: final speed 5/7, parabolic path under side spin, and the error of polygonal friction cones."""

import numpy as np
import pytest

from frictionbench.problems.ball import FRICTION as MU
from frictionbench.problems.ball import GRAVITY, RADIUS, SPEED, apart, roll, slide
from frictionbench.solvers import solve


def by(spec):
    return lambda problem: solve(problem, spec, tol=1e-10).impulse


@pytest.mark.parametrize("step", [0.02, 0.005])
def test_ball_rolls_at_five_sevenths(step) -> None:
    end = 2 * SPEED / (7 * MU * GRAVITY)
    path = roll(by("interior_point"), (SPEED, 0.0), friction=MU, step=step, steps=int(end / step) + 5)
    slides = np.linalg.norm(path.slip, axis=1) > 1e-6
    assert path.velocity[-1, 0] == pytest.approx(5 / 7 * SPEED, rel=1e-8)
    assert RADIUS * path.velocity[-1, 4] == pytest.approx(5 / 7 * SPEED, rel=1e-8)
    assert path.time[slides][-1] == pytest.approx(end, abs=step)


def test_side_spin_gives_parabola() -> None:
    coarse, fine = apart(*slide(by("interior_point"), 0.02)), apart(*slide(by("interior_point"), 0.005))
    assert coarse < 0.01
    assert fine == pytest.approx(coarse / 4, rel=0.2)


def test_path_error_decreases_with_facets() -> None:
    cone, _ = slide(by("interior_point"), 0.02)
    four, eight, many = (apart(slide(by(f"lemke[facets={k}]"), 0.02)[0], cone) for k in (4, 8, 64))
    assert four > 2 * eight > 10 * many
    assert many < 2e-3
