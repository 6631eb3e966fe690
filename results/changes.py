"""What differs between two runs, cell by cell and solver by solver.

flips      a cell measured in both runs, at another verdict:
           in the order of results.verdicts
gone       a cell measured before and not now, unless its solver was skipped with a reason
work       each deterministic counter, summed per solver over the cells that both runs solved
times      per solver, over the same cells: see results.times
"""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from frictionbench.results.cells import untold
from frictionbench.results.verdicts import RANK, Verdict

GONE = "gone"
MARGIN = 2.0  # by which a time may miss the limit and still be taken for one that a slower machine would not keep
PACE = 10.0  # the largest ratio of two machines' speeds


@dataclass(frozen=True)
class Finding(ABC):
    """Something of a solver that changed. known: the reason for which it is acknowledged."""

    variant: str
    known: str = field(default="", kw_only=True)

    @property
    @abstractmethod
    def name(self) -> str:
        """What changed."""

    @property
    @abstractmethod
    def worse(self) -> bool: ...

    @property
    @abstractmethod
    def better(self) -> bool: ...


@dataclass(frozen=True)
class Flip(Finding):
    """A cell at another verdict, or gone."""

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
        return self.after == GONE or RANK[self.after] > RANK[self.before]

    @property
    def better(self) -> bool:
        return not self.worse


@dataclass(frozen=True)
class Growth(Finding):
    """A counter's sum over a solver's cells, changed. limit: how large a ratio is still no growth."""

    counter: str
    before: int
    after: int
    cells: int
    limit: float

    @property
    def name(self) -> str:
        return self.counter

    @property
    def ratio(self) -> float:
        return self.after / self.before if self.before else np.inf

    @property
    def worse(self) -> bool:
        return self.after > self.limit * self.before

    @property
    def better(self) -> bool:
        return self.before > self.limit * self.after


def flips(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """Cells, the same in both tables, whose verdict changed; the worst falls first."""
    fall = (after["verdict"].map(RANK) - before["verdict"].map(RANK)).sort_values(ascending=False, kind="stable")
    for key in fall.index[fall != 0]:
        yield _flip(before.loc[key], after.loc[key])


def gone(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """Cells measured before that are not measured now, for no reason given."""
    ran = after[after["verdict"] != Verdict.SKIPPED]
    explained = after[(after["verdict"] == Verdict.SKIPPED) & (after["reason"] != "")]
    absent_solvers = set(explained["variant"]) - set(ran["variant"])
    lost = before[(before["verdict"] != Verdict.SKIPPED) & ~before.index.isin(ran.index) & ~before.index.isin(explained.index)]
    for key, row in lost.iterrows():
        if key in after.index or row["variant"] not in absent_solvers:
            yield _flip(row, None)


def _flip(before: pd.Series, after: pd.Series | None) -> Flip:
    place = str(before.name), before["table"], before["scene"], before["step"], before["tol"]
    if after is None:
        return Flip(before["variant"], *place, before["verdict"], GONE, before["residual"], np.nan, "")
    residuals = before["residual"], after["residual"]
    return Flip(after["variant"], *place, before["verdict"], after["verdict"], *residuals, after["reason"])


def by_the_clock(before: pd.DataFrame, after: pd.DataFrame, alike: bool) -> pd.Series:
    """Of cells, the same in both tables, which are at another verdict for a timeout that only the machine's pace explains.

    The time that one run took, at the other's pace, comes within MARGIN of the limit. The pace of an unlike machine is what
    the other cells show, up to PACE. A cell without a time, as one that crashed, is so explained between unlike machines only.
    """
    late, early = after["verdict"] == Verdict.TIMEOUT, before["verdict"] == Verdict.TIMEOUT
    ratio = (after["seconds"] / before["seconds"]).dropna()
    slower = 1.0 if alike or ratio.empty else float(np.clip(ratio.quantile(0.9), 1.0, PACE))
    faster = 1.0 if alike or ratio.empty else float(np.clip(1 / ratio.quantile(0.1), 1.0, PACE))
    taken = (slower * before["seconds"]).where(late, faster * after["seconds"])
    near = MARGIN * taken >= after["limit"].where(late, before["limit"])
    return (late != early) & (near | (taken.isna() & (not alike)))


def work(before: pd.DataFrame, after: pd.DataFrame, limit: float) -> Iterator[Growth]:
    """Counters whose sum over a solver's cells, the same in both tables, changed."""
    same = settled(before, after)
    for variant, keys in same.groupby(same["variant"]).groups.items():
        sums: tuple[Counter[str], Counter[str]] = Counter(), Counter()
        for key in keys:
            counts = [untold(cells["work"][key]) for cells in (before, after)]
            for name in counts[0].keys() & counts[1].keys():
                sums[0][name] += counts[0][name]
                sums[1][name] += counts[1][name]
        for name in sorted(sums[0]):
            if sums[0][name] != sums[1][name]:
                yield Growth(str(variant), name, sums[0][name], sums[1][name], len(keys), limit)


def settled(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """The cells with the same good verdict in both tables: only there is more work or time the price of the same answer."""
    return after[(after["verdict"] == before["verdict"]) & after["verdict"].isin([Verdict.SOLVED, Verdict.RELAXED])]
