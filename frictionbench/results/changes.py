"""The differences between two runs, cell by cell and solver by solver.

flips      cells measured in both runs with different verdicts, ordered as in problems.verdicts
gone       cells measured before but not now: cells skipped for any reason, and cells without a row
added      cells measured now but not before that fail
work       deterministic counters that changed, summed per solver and kind of cell over those that both runs solved. Failures
           within simulations and batches are summed over all cells whose verdict is not worse
untimed    cells, per solver, that had times before but have none now
times      per solver, over the same cells: see results.times
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import ACCEPTED, RANK, Verdict, measured
from frictionbench.results.cells import FAILURES, parse_counts
from frictionbench.results.conventions import number

KINDS = ("flips", "gone", "added", "work", "times")  # see above; `untimed` is work
GONE, NEW = "gone", "new"  # shown instead of the verdict for a cell that one of the runs lacks
GROWTH = 1.05  # largest ratio of sums of work that is no regression: rounding may change work by as much
TIME_NOISE = 2.0  # a time within this factor of the limit may exceed it on another day by noise alone
PACE = 10.0  # largest ratio of speeds that is attributed to the machines


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
        return f"{self.scene} {f'step {self.step}' if self.step else self.table} to {number(self.tol)} ({self.key})"

    @property
    def kind(self) -> str:
        return "added" if self.before == NEW else "gone" if self.after in (GONE, Verdict.SKIPPED) else "flips"

    @property
    def worse(self) -> bool:
        return self.kind != "flips" or RANK[self.after] > RANK[self.before]


@dataclass(frozen=True)
class Growth:
    """A change in the sum of a counter over a solver's cells. limit: the largest ratio that does not count as growth. before,
    after: None for a run whose cells lack the counter, or have a value that is not a count."""

    variant: str
    name: str
    before: int | None
    after: int | None
    cells: int
    limit: float
    kind: ClassVar[str] = "work"

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
    """The times of one solver in two versions of the code.

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
    kind: ClassVar[str] = "times"

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


Change = Flip | Growth | Time  # each has `name`, which identifies it among the changes of its solver, `kind` and `worse`


def flips(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """Yield the cells whose verdict changed, the largest deteriorations first. Both tables have the same cells."""
    ranks = [table["verdict"].map(RANK).astype(int) for table in (before, after)]  # an empty column of texts maps to texts
    decline = (ranks[1] - ranks[0]).sort_values(ascending=False, kind="stable")
    for key in decline.index[decline != 0]:
        yield _flip(before.loc[key], after.loc[key])


def gone(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """Yield the cells that were measured before but not now."""
    for key in before[measured(before)].index.difference(after[measured(after)].index, sort=False):
        yield _flip(before.loc[key], after.loc[key] if key in after.index else None)


def added(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """Yield the cells that are measured now, were not before, and fail."""
    failing = after[measured(after) & ~after["verdict"].isin(ACCEPTED)]
    for key in failing.index.difference(before[measured(before)].index, sort=False):
        yield _flip(None, failing.loc[key])


def _flip(before: pd.Series | None, after: pd.Series | None) -> Flip:
    row = before if after is None else after
    assert row is not None  # at least one of the runs has the cell
    cell = row["variant"], str(row.name), row["table"], row["scene"], row["step"], row["tol"]
    was = (NEW, np.nan) if before is None else (before["verdict"], before["residual"])
    now = (GONE, np.nan, "") if after is None else (after["verdict"], after["residual"], after["reason"])
    return Flip(*cell, was[0], now[0], was[1], *now[1:])


def explained_by_speed(before: pd.DataFrame, after: pd.DataFrame, alike: bool) -> pd.Series:
    """Return for each cell whether the machine's speed may explain that it became a timeout, or that it improved from one.

    It may if the time in the other run, scaled to the speed of this one, is within a factor TIME_NOISE of the larger of the two
    limits, and not if that time is unknown. Between different machines the ratio of speeds is estimated from all cells with two
    times, and is at most PACE; between equal machines (alike) it is one. The tables have the same cells.
    """
    late = (after["verdict"] == Verdict.TIMEOUT) & (before["verdict"] != Verdict.TIMEOUT)
    early = (before["verdict"] == Verdict.TIMEOUT) & (after["verdict"].map(RANK) < RANK[Verdict.TIMEOUT])
    ratio = (after["seconds"] / before["seconds"]).dropna()
    slower = 1.0 if alike or ratio.empty else float(np.clip(ratio.quantile(0.9), 1.0, PACE))
    faster = 1.0 if alike or ratio.empty else float(np.clip(1 / ratio.quantile(0.1), 1.0, PACE))
    taken = (slower * before["seconds"]).where(late, faster * after["seconds"])
    return (late | early) & (TIME_NOISE * taken >= np.maximum(before["limit"], after["limit"]))


def work(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Growth]:
    """Yield the counters whose sum over a solver's cells changed, or that only one run has. The tables have the same cells.
    Cold and warm solves, simulations and batches have sums of their own, so that no long one hides the others. If a count of
    failures has grown in some cells, only these are summed, so that fewer failures in others do not offset it."""
    same = after[after["verdict"].map(RANK) <= before["verdict"].map(RANK)]
    place = (", " + same["table"]).replace(", solve", "").mask(same["start"] == "warm", ", warm")
    for (variant, where), keys in same.groupby([same["variant"], place]).groups.items():
        counts = [_counts(before.loc[key], after.loc[key]) for key in keys]
        for name in sorted({name for pair in counts for side in pair for name in side}):
            pairs = [(old.get(name), new.get(name)) for old, new in counts if name in old or name in new]
            both = [(old, new) for old, new in pairs if old is not None and new is not None]
            both = [pair for pair in both if name in FAILURES and pair[1] > pair[0]] or both
            lost, fresh = [old for old, new in pairs if new is None], [new for old, new in pairs if old is None]
            sums = sum(old for old, _ in both), sum(new for _, new in both)
            if sums[0] != sums[1]:
                yield Growth(str(variant), name + where, *sums, len(both), 1.0 if name in FAILURES else GROWTH)
            if lost:
                yield Growth(str(variant), name + where, sum(filter(None, lost)), None, len(lost), GROWTH)
            if fresh and name not in FAILURES:
                yield Growth(str(variant), name + where, None, sum(filter(None, fresh)), len(fresh), GROWTH)


def _counts(before: pd.Series, after: pd.Series) -> tuple[dict[str, int], dict[str, int]]:
    """Return the counters of a cell before and after; only FAILURES unless both runs solved it with the same verdict. A
    cell that is stopped or crashes has lost those that it had before."""
    old, new = parse_counts(before["work"]), parse_counts(after["work"])
    equal = before["verdict"] == after["verdict"]
    if equal and after["verdict"] in ACCEPTED:
        return old, new
    names = (old.keys() | new.keys() if equal else old.keys()) & set(FAILURES)
    return {name: old[name] for name in names & old.keys()}, {name: new[name] for name in names & new.keys()}


def untimed(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Growth]:
    """Yield per solver the cells solved in both runs that no longer have times, so that their speed is unknown."""
    same = equally_solved(before, after)
    lost = same[before.loc[same.index, "seconds"].notna() & same["seconds"].isna()]
    for variant, keys in lost.groupby(lost["variant"]).groups.items():
        yield Growth(str(variant), "timed cells", len(keys), None, len(keys), 1.0)


def equally_solved(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """Return the cells that both runs solve with the same verdict. Work and times are comparable only for these."""
    return after[(after["verdict"] == before["verdict"]) & after["verdict"].isin(ACCEPTED)]
