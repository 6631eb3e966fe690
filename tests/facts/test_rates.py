"""Linear rates of the splitting methods at one contact, W = [[a, b], [b, g]]."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, anitescu_hart, solve


def contact(a, b, g, mu, q) -> FrictionProblem:
    return FrictionProblem.from_delassus([[a, b], [b, g]], q, [mu], 2)


@pytest.mark.parametrize(
    ("spec", "a", "b", "g", "mu", "q", "mode", "rate"),
    [
        ("staggered", 1, 0.9, 1, 5.0, [-1, -0.2], "s", 0.9**2),  # b^2/(a g)
        ("staggered", 2, -1.5, 1.3, 5.0, [-1, 0.2], "s", 1.5**2 / 2.6),
        ("staggered", 1, 0.97, 1, 0.75, [-1, 3], "r", 0.75 * 0.97),  # mu |b|/a
        ("staggered", 1, -0.5, 2, 0.8, [-1, 3], "r", 0.8 * 0.5),
        ("anitescu_hart", 1, 0, 1, 0.9, [-1, 10], "r", 0.9**2 / (1 + 0.9**2)),  # below 1 for every mu
        ("anitescu_hart", 1, 0, 1, 1.5, [-1, 10], "r", 1.5**2 / (1 + 1.5**2)),
        ("anitescu_hart", 1, -0.3, 1, 0.6, [-1, 3], "r", 0.6 * 0.9 / (1 + 2 * 0.6 * 0.3 + 0.6**2)),
    ],
)
def test_rate(spec, a, b, g, mu, q, mode, rate, monkeypatch) -> None:
    """Of the second half of the iterations; of Anitescu and Hart's |mu (mu g - b)|/(a - 2 mu b + mu^2 g)."""
    monkeypatch.setattr(anitescu_hart, "INNER", 1e-3)
    problem = contact(a, b, g, mu, q)
    assert [piece.mode for piece in census(problem).pieces] == [mode]
    answer = solve(problem, spec, tol=1e-12)
    assert residual(problem, answer.impulse) <= 1e-12
    history = np.array(answer.history)
    first, last = len(history) // 2, len(history) - 3
    assert (history[last] / history[first]) ** (1 / (last - first)) == pytest.approx(rate, rel=0.02)


def test_anitescu_hart_cycle() -> None:
    problem = contact(1, 0.97, 1, 0.75, [-1, 2])
    assert solve(problem, "anitescu_hart").status is Status.STALLED
    assert residual(problem, solve(problem, "staggered").impulse) <= 1e-8
