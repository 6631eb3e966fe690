"""The differences between two runs, cell by cell and solver by solver.

flips      cells measured in both runs with different verdicts, ordered as in problems.verdicts
gone       cells measured before and not now: those that were skipped, for whatever reason, and those without a row
added      cells measured now and not before that fail
work       deterministic counters that changed, summed per solver over the cells that both runs solved; of simulations and
           batches also what failed in them, over all cells whose verdict is not worse
untimed    cells, per solver, that had times and have none
times      per solver, over the same cells: see results.times
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import ACCEPTED, RANK, Verdict, measured
from frictionbench.results.cells import FAILURES, parse_counts

GONE, NEW = "gone", "new"  # in place of the verdict of a cell that one of the runs does not have
GROWTH = 1.05  # largest ratio of a sum of work that is no regression: it grows by effects of rounding
MARGIN = 2.0  # a time within this factor of the limit may exceed it on another day, by noise alone
PACE = 10.0  # largest ratio of the speeds of two machines that is attributed to the machines


@dataclass(frozen=True)
class Flip:
    """A cell whose verdict changed, or that only one of the runs measured."""

    variant: str
    key: str
    table: str
    scene: str
    step: str
    tol: float
    before: str
    after: str
    residual_before: float
    residual_after: float
    reason: str

    @property
    def name(self) -> str:
        return f"{self.scene} {f'step {self.step}' if self.step else self.table} to {self.tol:g} ({self.key})"

    @property
    def worse(self) -> bool:
        return self.before == NEW or self.after in (GONE, Verdict.SKIPPED) or RANK[self.after] > RANK[self.before]


@dataclass(frozen=True)
class Growth:
    """A change in the sum of a counter over a solver's cells. limit: the largest ratio that does not count as growth.

    before, after: None in a run whose cells do not have the counter, or have something there that is no count.
    """

    variant: str
    counter: str
    before: int | None
    after: int | None
    cells: int
    limit: float

    @property
    def name(self) -> str:
        return self.counter

    @property
    def ratio(self) -> float:
        return self.after / self.before if self.before and self.after is not None else np.inf

    @property
    def worse(self) -> bool:
        """Whether the sum has grown, or the counter is gone."""
        return self.before is not None and (self.after is None or self.after > self.limit * self.before)

    @property
    def better(self) -> bool:
        return self.before is not None and self.after is not None and self.before > self.limit * self.after


@dataclass(frozen=True)
class Time:
    """The times of one solver in two codes.

    before, after: time per cell, s, the median over n pairs of processes of the geometric mean over the cells. ratio: after /
    before, with the confidence interval (low, high) and the p-value p. limit: the largest ratio that is not a slowdown.
    """

    variant: str
    before: float
    after: float
    ratio: float
    low: float
    high: float
    p: float
    n: int
    cells: int
    limit: float
    name: ClassVar[str] = "time"

    @property
    def worse(self) -> bool:
        """Whether the whole interval is above the limit."""
        return self.low > self.limit

    @property
    def better(self) -> bool:
        return self.high < 1 / self.limit

    @property
    def significant(self) -> bool:
        """Whether the interval excludes 1."""
        return not self.low <= 1 <= self.high


Change = Flip | Growth | Time  # each has a name, which identifies it among those of its solver, and is worse or not


def flips(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """The cells whose verdict changed, the largest deteriorations first. Both tables have the same cells."""
    decline = (after["verdict"].map(RANK) - before["verdict"].map(RANK)).sort_values(ascending=False, kind="stable")
    for key in decline.index[decline != 0]:
        yield _flip(before.loc[key], after.loc[key])


def gone(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """The cells that were measured before and not now."""
    for key in before[measured(before)].index.difference(after[measured(after)].index, sort=False):
        yield _flip(before.loc[key], after.loc[key] if key in after.index else None)


def added(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """The cells that are measured now and were not before, and fail."""
    failing = after[measured(after) & ~after["verdict"].isin(ACCEPTED)]
    for key in failing.index.difference(before[measured(before)].index, sort=False):
        yield _flip(None, failing.loc[key])


def _flip(before: pd.Series | None, after: pd.Series | None) -> Flip:
    row = before if after is None else after
    assert row is not None  # one of the runs has it
    cell = row["variant"], str(row.name), row["table"], row["scene"], row["step"], row["tol"]
    was = (NEW, np.nan) if before is None else (before["verdict"], before["residual"])
    now = (GONE, np.nan, "") if after is None else (after["verdict"], after["residual"], after["reason"])
    return Flip(*cell, was[0], now[0], was[1], *now[1:])


def explained_by_speed(before: pd.DataFrame, after: pd.DataFrame, alike: bool) -> pd.Series:
    """Which cells became a timeout, or no longer are one and do better, as the speed of the machine alone may explain.

    It may if the time in the other run, scaled to the speed of this one, is within MARGIN of the larger of the two limits;
    where that time is not known nothing is explained. Between unlike machines the ratio of speeds is estimated from the other
    cells, up to PACE; between equal machines (alike) it is one. The tables have equal cells.
    """
    late = (after["verdict"] == Verdict.TIMEOUT) & (before["verdict"] != Verdict.TIMEOUT)
    early = (before["verdict"] == Verdict.TIMEOUT) & (after["verdict"].map(RANK) < RANK[Verdict.TIMEOUT])
    ratio = (after["seconds"] / before["seconds"]).dropna()
    slower = 1.0 if alike or ratio.empty else float(np.clip(ratio.quantile(0.9), 1.0, PACE))
    faster = 1.0 if alike or ratio.empty else float(np.clip(1 / ratio.quantile(0.1), 1.0, PACE))
    taken = (slower * before["seconds"]).where(late, faster * after["seconds"])
    return (late | early) & (MARGIN * taken >= np.maximum(before["limit"], after["limit"]))


def work(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Growth]:
    """The counters whose sum over a solver's cells changed, or that only one run has. The tables have equal cells.

    Of what failed, where it grew in some cells, only these are summed: less in others makes up for nothing."""
    same = after[after["verdict"].map(RANK) <= before["verdict"].map(RANK)]
    for variant, keys in same.groupby(same["variant"]).groups.items():
        counts = [_counts(before.loc[key], after.loc[key]) for key in keys]
        for name in sorted({name for pair in counts for side in pair for name in side}):
            pairs = [(old.get(name), new.get(name)) for old, new in counts if name in old or name in new]
            both = [(old, new) for old, new in pairs if old is not None and new is not None]
            both = [pair for pair in both if name in FAILURES and pair[1] > pair[0]] or both
            lost, fresh = [old for old, new in pairs if new is None], [new for old, new in pairs if old is None]
            sums = sum(old for old, _ in both), sum(new for _, new in both)
            if sums[0] != sums[1]:
                yield Growth(str(variant), name, *sums, len(both), 1.0 if name in FAILURES else GROWTH)
            if lost:
                yield Growth(str(variant), name, sum(filter(None, lost)), None, len(lost), GROWTH)
            if fresh and name not in FAILURES:
                yield Growth(str(variant), name, None, sum(filter(None, fresh)), len(fresh), GROWTH)


def _counts(before: pd.Series, after: pd.Series) -> tuple[dict[str, int], dict[str, int]]:
    """The counters of a cell before and after; of one that is not solved with the same verdict what failed in it alone."""
    old, new = parse_counts(before["work"]), parse_counts(after["work"])
    equal = before["verdict"] == after["verdict"]
    if equal and after["verdict"] in ACCEPTED:
        return old, new
    names = (old.keys() | new.keys() if equal else old.keys() & new.keys()) & set(FAILURES)
    return {name: old[name] for name in names & old.keys()}, {name: new[name] for name in names & new.keys()}


def untimed(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Growth]:
    """The cells of each solver, solved in both runs, whose times are gone: their speed is not known any more."""
    same = equally_solved(before, after)
    lost = same[before.loc[same.index, "seconds"].notna() & same["seconds"].isna()]
    for variant, keys in lost.groupby(lost["variant"]).groups.items():
        yield Growth(str(variant), "timed cells", len(keys), None, len(keys), 1.0)


def equally_solved(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """The cells that both tables solve with the same verdict: only there are work and time comparable."""
    return after[(after["verdict"] == before["verdict"]) & after["verdict"].isin(ACCEPTED)]
