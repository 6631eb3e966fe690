"""What differs between two runs, cell by cell and solver by solver.

    verdict    of a cell measured in both runs: solved > relaxed > missed > unjudgeable > unsolved > timeout > crashed > wrong;
               a timeout against another is one between like machines only
    missing    a cell measured before and not now, unless its solver was skipped with a reason
    work       each deterministic counter, summed per variant over the cells that both runs solved
    time       form, setup and solve: the geometric mean per variant of the ratio of the cells' medians, and significant

The significance is that of van Elteren's test (1960): Mann and Whitney's statistic of each cell's raw repeats, weighted and
added up over the cells. It needs no model of the noise, and a cell with a single repeat still counts for what it is.
"""

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import rankdata

from results.schema import CRASHED, MISSED, RELAXED, SKIPPED, SOLVED, TIMEOUT, UNJUDGEABLE, UNSOLVED, WRONG

Array = NDArray[np.float64]
RANK = {verdict: i for i, verdict in enumerate((SOLVED, RELAXED, MISSED, UNJUDGEABLE, UNSOLVED, TIMEOUT, CRASHED, WRONG))}
GROWTH = 1.10  # of work
SLOWDOWN = 1.25
SIGNIFICANT = 2.326  # standard deviations: one in a hundred by chance


class Change(NamedTuple):
    """One difference: its kind, whether it is for the worse, the cell's key or "", the variant, and what it is."""

    kind: str
    worse: bool
    key: str
    variant: str
    what: str


def measured(cells: pd.DataFrame) -> pd.DataFrame:
    """The cells that were run."""
    return cells[cells["verdict"] != SKIPPED]


def verdicts(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Change]:
    """Cells, the same in both tables, whose verdict changed; worst falls first."""
    rank_before, rank_after = before["verdict"].map(RANK), after["verdict"].map(RANK)
    fall = (rank_after - rank_before).sort_values(ascending=False, kind="stable")
    for key in fall.index[fall != 0]:
        what = f"{before['verdict'][key]} → {after['verdict'][key]}"
        yield Change("verdict", bool(fall[key] > 0), key, after["variant"][key], what)


def by_the_clock(before: pd.DataFrame, after: pd.DataFrame) -> pd.Series:
    """Of cells, the same in both tables, which are at another verdict for a timeout: between unlike machines no change."""
    return (before["verdict"] != after["verdict"]) & ((before["verdict"] == TIMEOUT) | (after["verdict"] == TIMEOUT))


def missing(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Change]:
    """Cells measured before that are not measured now, for no reason given."""
    explained = (after["verdict"] == SKIPPED) & (after["reason"] != "")
    excused = set(after.index[explained])
    absent_solvers = set(after["variant"][explained]) - set(measured(after)["variant"])
    for key, variant in measured(before)["variant"].drop(measured(after).index, errors="ignore").items():
        if key not in excused and not (key not in after.index and variant in absent_solvers):
            yield Change("missing", True, key, variant, f"was {before['verdict'][key]}")


def work(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Change]:
    """Counters whose sum over a variant's cells, the same in both tables, grew or shrank by more than a tenth."""
    for variant, keys in _settled(before, after).groupby(after["variant"]).groups.items():
        sums: tuple[Counter[str], Counter[str]] = Counter(), Counter()
        for key in keys:
            counts = [_counts(cells["work"][key]) for cells in (before, after)]
            for name in counts[0].keys() & counts[1].keys():
                sums[0][name] += counts[0][name]
                sums[1][name] += counts[1][name]
        for name in sorted(sums[0]):
            old, new = sums[0][name], sums[1][name]
            if new > GROWTH * old or old > GROWTH * new:
                ratio = f" (×{new / old:.2f})" if old else ""
                yield Change("work", new > old, "", str(variant), f"{name}: {old} → {new}{ratio}, {len(keys)} cells")


def times(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Change]:
    """Variants slower or faster by more than a quarter, beyond chance, over their cells, the same in both tables."""
    for variant, keys in _settled(before, after).groupby(after["variant"]).groups.items():
        pairs = [(before["repeats"][key], after["repeats"][key]) for key in keys]
        pairs = [(old, new) for old, new in pairs if len(old) and len(new)]
        if not pairs:
            continue
        ratio = float(np.exp(np.mean([np.log(np.median(new) / np.median(old)) for old, new in pairs])))
        score = van_elteren(pairs)
        if max(ratio, 1 / ratio) > SLOWDOWN and score * np.sign(ratio - 1) > SIGNIFICANT:
            what = f"×{ratio:.2f} in time, {len(pairs)} cells, {abs(score):.1f} standard deviations"
            yield Change("time", ratio > 1, "", str(variant), what)


def van_elteren(pairs: Iterable[tuple[Array, Array]]) -> float:
    """How many standard deviations the second samples lie above the first, over all pairs of samples together."""
    excess = variance = 0.0
    for old, new in pairs:
        n, m = len(old), len(new)
        ranks = rankdata(np.concatenate([old, new]))[n:]
        weight = 1 / (n + m + 1)
        excess += weight * (ranks.sum() - m * (n + m + 1) / 2)
        variance += weight**2 * n * m * (n + m + 1) / 12
    return float(excess / np.sqrt(variance)) if variance else 0.0


def _settled(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """The cells with the same good verdict in both tables: only there is more work the price of the same answer."""
    return after[(after["verdict"] == before["verdict"]) & after["verdict"].isin([SOLVED, RELAXED])]


def _counts(text: str) -> dict[str, int]:
    try:
        counts: Any = json.loads(text or "{}")
    except (ValueError, RecursionError):
        return {}
    if not isinstance(counts, dict):
        return {}
    return {name: count for name, count in counts.items() if type(count) is int and count >= 0}
