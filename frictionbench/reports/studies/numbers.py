"""Numbers in sentences, with their uncertainty."""

from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import t as student

from frictionbench.reports.drawing.text import percent

Z = NormalDist().inv_cdf(0.975)


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson 1927)."""
    p, n = successes / trials, trials
    middle = (p + Z**2 / (2 * n)) / (1 + Z**2 / n)
    half = Z / (1 + Z**2 / n) * np.sqrt(p * (1 - p) / n + Z**2 / (4 * n**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def share(successes: int, trials: int) -> str:
    """A share with its 95 % interval: 6 of 150 (4 %, 95 % interval 1.8 to 8.5 %)."""
    low, high = (f"{100 * end:.{0 if end > 0.0995 else 1}f}" for end in wilson(int(successes), int(trials)))
    return f"{successes} of {trials} ({percent(successes / trials)}, 95 % interval {low} to {high} %)"


class Slope(NamedTuple):
    """The slope of log y over log x with half the width of its 95 % interval."""

    value: float
    half: float

    def __str__(self) -> str:
        return f"{self.value:.2f} ± {self.half:.2f}"


def order(x: ArrayLike, y: ArrayLike) -> Slope:
    """The order by least squares: y ~ x^slope; at least three points of positive x and y."""
    a, b = np.log(np.asarray(x, dtype=float)), np.log(np.asarray(y, dtype=float))
    centred = a - a.mean()
    slope = float(centred @ b / (centred @ centred))
    left = b - b.mean() - slope * centred
    error = np.sqrt(left @ left / (len(a) - 2) / (centred @ centred))
    return Slope(slope, float(student.ppf(0.975, len(a) - 2) * error))


def listing(items: Sequence[str], last: str = "and") -> str:
    """a, b and c."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else "none"
