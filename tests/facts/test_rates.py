"""Linear rates of the splitting methods at one contact, W = [[a, b], [b, g]]; those of a sliding one are in test_splitting."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.census import census
from frictionbench.solvers import anitescu_hart, solve, staggered  # noqa: F401  # registers them


def contact(a, b, g, mu, q) -> FrictionProblem:
    return FrictionProblem.from_delassus([[a, b], [b, g]], q, [mu], 2)


def mean_rate(history, first, last) -> float:
    return (history[last] / history[first]) ** (1 / (last - first))


@pytest.mark.parametrize(("a", "b", "g"), [(1, 0.9, 1), (2, -1.5, 1.3)])
def test_staggering_rate_of_sticking_contact(a, b, g) -> None:
    problem = contact(a, b, g, 5.0, [-1, -0.2 * np.sign(b)])
    assert [piece.mode for piece in census(problem).pieces] == ["s"]
    history = solve(problem, "staggered", tol=1e-12).history
    assert mean_rate(history, 2, len(history) - 3) == pytest.approx(b * b / (a * g), rel=0.05)


@pytest.mark.parametrize("mu", [0.5, 0.9, 1.5])
def test_anitescu_hart_rate_of_particle(mu) -> None:
    """... over 1 + mu^2, so for every mu."""
    problem = contact(1, 0, 1, mu, [-1, 10])
    assert [piece.mode for piece in census(problem).pieces] == ["r"]
    history = solve(problem, "anitescu_hart", tol=1e-12).history
    assert mean_rate(history, 1, len(history) - 3) == pytest.approx(mu**2 / (1 + mu**2), rel=0.1)
