"""Times of two codes compared over pairs of processes, one of each, that ran in turn.

Repeats of one process share its memory layout, its core and the minutes in which it ran: they are one sample (results.cells).
A pair gives a solver one number, the mean over its cells of log(after / before); of n pairs the ratio is the Hodges-Lehmann
estimate (1963) of their centre, its interval that of Wilcoxon's signed ranks (1945), exact, and p their two-sided test of no
change. No model of the noise is needed, and a pair that other work on the machine spoiled counts for little. With one pair
nothing can be said: the interval is (0, inf).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import pandas as pd

from frictionbench.results.changes import Finding, settled


@dataclass(frozen=True)
class Time(Finding):
    """A solver's time per cell in seconds, the median of n processes; the ratio with its interval; p; n pairs.

    limit: how large a ratio is still no slowdown.
    """

    before: float
    after: float
    ratio: float
    low: float
    high: float
    p: float
    n: int
    cells: int
    limit: float

    @property
    def worse(self) -> bool:
        """Slower by more than the limit, beyond chance."""
        return self.low > self.limit

    @property
    def better(self) -> bool:
        return self.high < 1 / self.limit

    @property
    def significant(self) -> bool:
        """Whether anything can be said: the interval leaves out 1."""
        return not self.low <= 1 <= self.high

    @property
    def name(self) -> str:
        return "time"


Pair = tuple[pd.DataFrame, pd.DataFrame]  # the cells of two processes


def times(pairs: Sequence[Pair], limit: float, alpha: float) -> list[Time]:
    """Each solver's, over the cells that both processes of a pair answered alike; disturbed ones count where there is nothing
    else."""
    found = []
    logs = [_logs(*pair) for pair in pairs]
    for variant in sorted({name for log in logs for name in log["variant"]}):
        own = [log[log["variant"] == variant] for log in logs]
        own = [log for log in own if len(log)]
        before, after = (float(np.exp(np.median([log[side].mean() for log in own]))) for side in ("before", "after"))
        shifts = np.array([(log["after"] - log["before"]).mean() for log in own])
        found.append(Time(variant, before, after, *estimate(shifts, alpha), len(own), max(map(len, own)), limit))
    return found


def _logs(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    common = before.index.intersection(after.index)
    before, after = before.loc[common], after.loc[common]
    same = settled(before, after)
    table = pd.DataFrame({"variant": same["variant"]})
    for side, cells in (("before", before), ("after", after)):
        table[side] = np.log(cells["seconds"].loc[same.index])
    table["calm"] = ~(before["disturbed"] | after["disturbed"]).loc[same.index]
    table = table.dropna()
    return table[table["calm"] | ~table.groupby("variant")["calm"].transform("any")]


def estimate(shifts: np.ndarray, alpha: float) -> tuple[float, float, float, float]:
    """The ratio, its interval at confidence 1 - alpha, and p, of the logarithms of n independent ratios."""
    means = np.sort([(a + b) / 2 for a, b in combinations_with_replacement(shifts, 2)])
    chances = np.cumsum(signed_ranks(len(shifts)))
    left = int(np.sum(chances <= alpha / 2))  # so many sums of ranks are too improbable, at either end
    low, high = (means[left - 1], means[-left]) if left else (-np.inf, np.inf)
    lower = min(int(np.sum(means < 0)), int(np.sum(means > 0)))
    p = min(1.0, 2 * float(chances[lower])) if left else np.nan
    return float(np.exp(np.median(means))), float(np.exp(low)), float(np.exp(high)), p


def signed_ranks(n: int) -> np.ndarray:
    """The probability of each sum 0 ... n (n + 1) / 2 of the ranks of those of n differences that are above zero."""
    counts = np.ones(1)
    for rank in range(1, n + 1):
        longer = np.zeros(len(counts) + rank)
        longer[: len(counts)] += counts
        longer[rank:] += counts
        counts = longer
    return counts / 2.0**n


def overall(found: Sequence[Time]) -> float:
    """The geometric mean of the solvers' ratios; nan where there are none."""
    return float(np.exp(np.mean([np.log(time.ratio) for time in found]))) if found else np.nan
