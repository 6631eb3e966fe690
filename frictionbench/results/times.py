"""Comparison of the times of two versions of the code over pairs of processes, one of each version, that ran alternately.

A process is one sample. A pair gives one number per solver, the mean over its cells of log(after / before). From n pairs follow
the ratio, as the Hodges-Lehmann estimate (1963) of the centre, its exact confidence interval by Wilcoxon's signed ranks (1945),
and p, the p-value of the two-sided test of no change. One pair gives no information on variation: its interval is (0, inf).

A disturbed cell (results.cells) is left out of its pair, because its time depends more on the machine than on the code. A cell
that is disturbed in every process of the later version, but in few of the earlier, counts: the code itself causes it, for
example by a child process that competes for its core. So does one that is much slower in every pair, such as a long simulation,
which on a busy machine always waits for its core.
"""

from collections.abc import Sequence
from functools import reduce
from itertools import combinations_with_replacement

import numpy as np
import pandas as pd

from frictionbench.results.changes import Time, equally_solved

Pair = tuple[pd.DataFrame, pd.DataFrame]  # the cells of two processes
ALPHA = 0.05  # error probability of the intervals
MUCH_SLOWER = 2.0  # ratio of times that waiting alone does not cause in each pair
FEW_DISTURBED = 0.25  # largest share of disturbed processes of the earlier version in that case


def times(pairs: Sequence[Pair], limit: float) -> list[Time]:
    """Return the times of each solver over the cells that both processes of a pair solved with the same verdict. Disturbed
    cells are used only for solvers that have no others."""
    compared = []
    logs = _logs(pairs, len(pairs))
    for variant in sorted({name for log in logs for name in log["variant"]}):
        of_variant = [log[log["variant"] == variant] for log in logs]
        of_variant = [log for log in of_variant if len(log)]
        before, after = (float(np.exp(np.median([log[side].mean() for log in of_variant]))) for side in ("before", "after"))
        shifts = np.array([(log["after"] - log["before"]).mean() for log in of_variant])
        compared.append(Time(variant, before, after, *estimate(shifts), len(of_variant), max(map(len, of_variant)), limit))
    return compared


def may_be_slower(pairs: Sequence[Pair], most: int, limit: float) -> bool:
    """Return whether some solver's interval over `most` pairs can still lie above the limit, however slow the pairs to come."""
    logs = pd.concat([log.assign(pair=k) for k, log in enumerate(_logs(pairs, most))])
    shifts = (logs["after"] - logs["before"]).groupby([logs["variant"], logs["pair"]]).mean()
    for _, of_variant in shifts.groupby("variant"):
        to_come = np.full(most - len(of_variant), np.inf)
        if estimate(np.concatenate([of_variant, to_come]))[1] > limit:
            return True
    return False


def _logs(pairs: Sequence[Pair], most: int) -> list[pd.DataFrame]:
    """Return for each pair the variants and the logarithms of both times of the cells that count if, in the pairs up to `most`
    that are still to come, the earlier version is disturbed nowhere."""
    earlier, later = (pd.concat([pair[side]["disturbed"].astype(float) for pair in pairs], axis=1) for side in (0, 1))
    seldom = earlier.sum(axis=1).reindex(later.index) <= FEW_DISTURBED * most
    self_disturbed = later.index[(later.mean(axis=1) == 1) & seldom]
    ratios = pd.concat([after["seconds"] / before["seconds"] for before, after in pairs], axis=1)
    kept = self_disturbed.union(ratios.index[ratios.min(axis=1, skipna=False) > MUCH_SLOWER])
    tables = []
    for pair in pairs:
        common = pair[0].index.intersection(pair[1].index)
        before, after = (cells.loc[common] for cells in pair)
        same = equally_solved(before, after)
        table = pd.DataFrame({"variant": same["variant"]})
        for side, cells in (("before", before), ("after", after)):
            table[side] = np.log(cells["seconds"].loc[same.index])
        disturbed = (before["disturbed"] | after["disturbed"]).loc[same.index]
        table["undisturbed"] = ~disturbed | same.index.isin(kept)
        table = table.dropna()
        tables.append(table[table["undisturbed"] | ~table.groupby("variant")["undisturbed"].transform("any")])
    return tables


def estimate(shifts: np.ndarray) -> tuple[float, float, float, float]:
    """Return the ratio, its interval at confidence 1 - ALPHA and the p-value, from the logarithms of n independent ratios."""
    means = np.sort([(a + b) / 2 for a, b in combinations_with_replacement(shifts, 2)])
    # The probabilities of the rank sums 0 ... n (n + 1) / 2 of the positive ones: coefficients of the product of 1 + x^rank.
    factors = (np.concatenate([[1.0], np.zeros(rank - 1), [1.0]]) for rank in range(1, len(shifts) + 1))
    chances = np.cumsum(reduce(np.convolve, factors, np.ones(1)) / 2.0 ** len(shifts))
    left = int(np.sum(chances <= ALPHA / 2))  # number of rank sums outside the interval at each end
    low, high = (means[left - 1], means[-left]) if left else (-np.inf, np.inf)
    lower = min(int(np.sum(means < 0)), int(np.sum(means > 0)))
    p = min(1.0, 2 * float(chances[lower])) if left else np.nan
    return float(np.exp(np.median(means))), float(np.exp(low)), float(np.exp(high)), p
