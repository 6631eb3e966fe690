"""Violations of the parts of the law by an engine's step, and what is taken from its penetrations."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.measures import judged, penetration, violations
from frictionbench.problems.recorded.native import EngineStep
from tests.helpers.friction_problems import contacts_of

H = 0.01


def ball(*velocity: float, gap: float = 0.0) -> FrictionProblem:
    """A point of 1 kg on a floor of friction 0.5; velocities normal first."""
    rows = np.eye(3)
    return contacts_of(rows[:1], rows[1:], 0.5, velocity, mass=rows, bias=[gap / H])


@pytest.mark.parametrize(
    ("velocity", "impulse", "expected"),
    [
        ((-1.0, 3.0, 0.0), (1.0, -0.5, 0.0), (0, 0, 0, 0)),  # slides, exactly
        ((-1.0, 0.3, 0.0), (1.0, -0.3, 0.0), (0, 0, 0, 0)),  # sticks, exactly
        ((-1.0, 3.0, 0.0), (0.9, -0.45, 0.0), (0.1, 0, 0, 0)),  # still approaches
        ((1.0, 3.0, 0.0), (0.5, -0.25, 0.0), (0.5, 0, 0, 0)),  # pulled down or pushed while open
        ((-1.0, 3.0, 0.0), (1.0, -0.7, 0.0), (0, 0.2, 0, 0)),  # friction of 0.7 in a cone of 0.5
        ((-1.0, 0.3, 0.2), (1.0, -0.24, -0.16), (0, 0, 0, 0.02 * 13**0.5)),  # creeps at 0.07 m/s inside the cone
        ((-1.0, 3e9, 0.0), (1.0, 0.0, -0.5), (0, 0, 0.5, 0.5)),  # friction across the slip
    ],
)
def test_each_law(velocity, impulse, expected) -> None:
    assert np.array(violations(ball(*velocity), np.array([impulse]))).ravel() == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize(
    ("speed", "violated"),
    [(0.0, 0.0), (0.4, 0.0), (1.0, 0.0), (1.2, 0.2), (-0.3, 0.3)],  # m/s out of a penetration of 1 m/s times the step
)
def test_penetration_may_be_left_but_not_deepened(speed, violated) -> None:
    step = EngineStep(ball(-2.0, 0.0, 0.0, gap=-H), [[2.0 + speed, 0.0, 0.0]], step=H)
    assert penetration(step) == pytest.approx(H)
    assert violations(judged(step), step.impulse).signorini == pytest.approx([violated], abs=1e-12)
    unknown = EngineStep(step.problem, step.impulse)
    assert judged(unknown) is step.problem
    assert penetration(unknown) is None
