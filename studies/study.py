"""The definition of a study, and functions shared by studies: numbers as text with their uncertainty, and curves.

A study is a file in this folder that ends with `STUDY = Study(...)`, with its prose in text/NAME.md. The part above
`def summary` computes: generators of rows, each for a table with its name, whose arguments make it smaller for tests, and plans
of solver runs, which are isolated, verified and stored like any run. The part below reads the tables: `summary` returns the
formatted numbers that the prose quotes, and the panels of its figures.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.util import find_spec
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

from frictionbench.harness.plans.plan import Plan
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import COLOURS, GRID, Look
from frictionbench.reports.drawing.text import percent, plain, residual
from frictionbench.results.files import ResultsError

Z = NormalDist().inv_cdf(0.975)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p")
_DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), "-", "--", "-.")

Array = NDArray[np.float64]
Row = dict[str, Any]
Tables = dict[str, pd.DataFrame]  # by name; the table of solver runs is `solves`


class Summary(NamedTuple):
    """The data of the prose: numbers by name, the panels of each figure, and the looks of lines named in a common legend."""

    numbers: Mapping[str, Any]
    figures: Mapping[str, Sequence[Panel]]
    looks: Mapping[str, Look] = {}


class Study(NamedTuple):
    """rows: a generator for each table. plan: solver runs, if any.

    needs: packages without which `all` leaves the study out.
    """

    rows: Sequence[Callable[..., Iterable[Row]]]
    summary: Callable[[Tables], Summary]
    plan: Callable[[], Plan] | None = None
    needs: Sequence[str] = ()

    def runs(self) -> bool:
        return all(find_spec(package) is not None for package in self.needs)


def require(holds: object, claim: str) -> None:
    """Check a claim of the prose. Errors: ResultsError with the claim if the tables contradict it."""
    if not holds:
        raise ResultsError(f"the tables do not show what the text says: {claim}")


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927)."""
    p, n = successes / trials, trials
    middle = (p + Z**2 / (2 * n)) / (1 + Z**2 / n)
    half = Z / (1 + Z**2 / n) * np.sqrt(p * (1 - p) / n + Z**2 / (4 * n**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def share(successes: int, trials: int) -> str:
    """Format a share with its 95 % interval: 6 of 150 (4 %, 95 % interval 1.8 to 8.5 %)."""
    low, high = (f"{100 * end:.{0 if end > 0.0995 else 1}f}" for end in wilson(int(successes), int(trials)))
    return f"{successes} of {trials} ({percent(successes / trials)}, 95 % interval {low} to {high} %)"


class Slope(NamedTuple):
    """The slope of log y over log x, and those of the halves with smaller and larger x, which agree if it has converged."""

    value: float
    small: float
    large: float

    def __str__(self) -> str:
        return f"{self.value:.2f} ({self.small:.2f}, {self.large:.2f})"


def order(x: ArrayLike, y: ArrayLike) -> Slope:
    """Fit y ~ x^slope by least squares to three or more points with positive x and y. A middle point is in both halves."""
    a, b = np.log(np.asarray(x, dtype=float)), np.log(np.asarray(y, dtype=float))
    ranks, half = np.argsort(a), (len(a) + 1) // 2
    return Slope(*(float(np.polyfit(a[part], b[part], 1)[0]) for part in (ranks, ranks[:half], ranks[-half:])))


def listing(items: Sequence[str], last: str = "and") -> str:
    """Return the items as "a, b and c"."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else "none"


def widest(values: pd.Series) -> float:
    """Return the largest distance between any two of the vectors."""
    vectors = np.array([np.atleast_1d(value) for value in values], dtype=float)
    return float(np.linalg.norm(vectors[:, None] - vectors[None], axis=2).max())


def curve(ax: Axes, k: int, x: ArrayLike, y: ArrayLike, label: str = "", **more: Any) -> None:
    """Plot the k-th curve of a panel."""
    look = {"color": COLOURS[k % 8], "marker": _MARKERS[k % 8], "ls": _DASHES[k % 8], "ms": 3.5} | more
    ax.plot(x, y, label=plain(label) if label else "_", **look)


def finish(ax: Axes, x: str, y: str, logarithmic: str = "", **more: Any) -> None:
    """Add labels, grid and legend. logarithmic: "x", "y", "xy" or empty."""
    ax.set(xlabel=x, ylabel=y, **{f"{axis}scale": "log" for axis in logarithmic}, **more)
    for axis in (getattr(ax, f"{axis}axis") for axis in logarithmic):
        low, high = axis.get_view_interval()
        subs = (1.0,) if high > 90 * low else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=subs, numticks=7))
        write = "{:g}".format if low >= 1e-4 and high < 1e5 else residual  # one notation on an axis
        axis.set_major_formatter(FuncFormatter(lambda value, _, write=write: write(value)))
        axis.set_minor_locator(NullLocator())
    ax.grid(**GRID)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1, 1))  # beside the axes, where it hides no curve
