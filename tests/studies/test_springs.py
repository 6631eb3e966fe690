"""Compliant contact tends to the rigid one, and decides where the rigid model says two things."""

from dataclasses import replace

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from studies.springs import comply


@pytest.mark.parametrize("method", ["Radau", "BDF"])
def test_ball_rebounds_with_its_restitution(method: str) -> None:
    made = scene("bouncing_ball", height=0.05, restitution=0.6, duration=0.15, step=0.15)
    end = comply(made, 1e7, method=method, accuracy=1e-7)
    fall = np.sqrt(2 * 0.05 / 9.81)
    assert end.v[-1, 1] == pytest.approx(9.81 * (0.6 * fall - (0.15 - fall)), abs=0.01)


@pytest.mark.parametrize(("share", "lifts"), [(0.5, True), (2.0, False)])
def test_indentation_decides_where_forces_are_two(share: float, lifts: bool) -> None:
    """Painlevé's rod with p < 0 < K: the force -K/p is an unstable equilibrium of the spring."""
    made, k = scene("painleve_rod", spin=4.0, tip_velocity=-3.0, duration=0.002, step=0.002), 1e8
    cos, sin = np.cos(made.q0[2]), np.sin(made.q0[2])
    p, K = 1 + 3 * cos**2 - 4.5 * sin * cos, 16 * sin - 9.81
    made = replace(made, q0=made.q0 - [0, share * -K / p / k, 0])
    end = comply(made, k)
    assert (abs(end.v[-1, 2] - 4.0) > 0.5) is not lifts
    assert end.v[-1, 1] - end.v[-1, 2] * np.cos(end.q[-1, 2]) > 0, "the speed of the tip"
