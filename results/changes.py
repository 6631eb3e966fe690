"""The differences between two runs, cell by cell and solver by solver.

flips      cells measured in both runs with different verdicts, ordered as in results.verdicts
gone       cells measured before and not now, unless their solver was skipped with a reason
work       deterministic counters that changed, summed per solver over the cells that both runs solved
times      per solver, over the same cells: see results.times
"""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from frictionbench.results.cells import parse_counts
from frictionbench.results.verdicts import ACCEPTED, RANK, Verdict, measured

GONE = "gone"
MARGIN = 2.0  # a time within this factor of the limit may exceed it on another day, by noise alone
PACE = 10.0  # largest ratio of the speeds of two machines that is attributed to the machines


@dataclass(frozen=True)
class Change(ABC):
    """A change in the results of one solver. known: the reason why it is acknowledged, or empty."""

    variant: str
    known: str = field(default="", kw_only=True)

    @property
    @abstractmethod
    def name(self) -> str:
        """What changed, as text that identifies it among the solver's changes."""

    @property
    @abstractmethod
    def worse(self) -> bool: ...

    @property
    @abstractmethod
    def better(self) -> bool: ...


@dataclass(frozen=True)
class Flip(Change):
    """A cell whose verdict changed, or that is gone."""

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
class Growth(Change):
    """A change in the sum of a counter over a solver's cells. limit: the largest ratio that does not count as growth."""

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
    """The cells whose verdict changed, the largest deteriorations first. Both tables have the same cells."""
    decline = (after["verdict"].map(RANK) - before["verdict"].map(RANK)).sort_values(ascending=False, kind="stable")
    for key in decline.index[decline != 0]:
        yield _flip(before.loc[key], after.loc[key])


def gone(before: pd.DataFrame, after: pd.DataFrame) -> Iterator[Flip]:
    """The cells that were measured before and not now, without a reason."""
    ran = after[measured(after)]
    explained = after[(after["verdict"] == Verdict.SKIPPED) & (after["reason"] != "")]
    absent_solvers = set(explained["variant"]) - set(ran["variant"])
    accounted = before.index.isin(ran.index) | before.index.isin(explained.index)
    for key, row in before[measured(before) & ~accounted].iterrows():
        if key in after.index or row["variant"] not in absent_solvers:
            yield _flip(row, None)


def _flip(before: pd.Series, after: pd.Series | None) -> Flip:
    cell = str(before.name), before["table"], before["scene"], before["step"], before["tol"]
    if after is None:
        return Flip(before["variant"], *cell, before["verdict"], GONE, before["residual"], np.nan, "")
    residuals = before["residual"], after["residual"]
    return Flip(after["variant"], *cell, before["verdict"], after["verdict"], *residuals, after["reason"])


def explained_by_speed(before: pd.DataFrame, after: pd.DataFrame, alike: bool) -> pd.Series:
    """Which cells changed from or to a timeout that the speed of the machine alone may explain. The tables have equal cells.

    It may if the time in the other run, scaled to the speed of this one, is within MARGIN of the limit. Between different
    machines the ratio of speeds is estimated from the other cells, up to PACE, and a cell without a time, such as one that
    crashed, is explained too; between equal machines (alike) the ratio is one.
    """
    late, early = after["verdict"] == Verdict.TIMEOUT, before["verdict"] == Verdict.TIMEOUT
    ratio = (after["seconds"] / before["seconds"]).dropna()
    slower = 1.0 if alike or ratio.empty else float(np.clip(ratio.quantile(0.9), 1.0, PACE))
    faster = 1.0 if alike or ratio.empty else float(np.clip(1 / ratio.quantile(0.1), 1.0, PACE))
    taken = (slower * before["seconds"]).where(late, faster * after["seconds"])
    near = MARGIN * taken >= after["limit"].where(late, before["limit"])
    return (late != early) & (near | (taken.isna() & (not alike)))


def work(before: pd.DataFrame, after: pd.DataFrame, limit: float) -> Iterator[Growth]:
    """The counters whose sum over a solver's cells changed. Both tables have the same cells."""
    same = equally_solved(before, after)
    for variant, keys in same.groupby(same["variant"]).groups.items():
        sums: tuple[Counter[str], Counter[str]] = Counter(), Counter()
        for key in keys:
            counts = [parse_counts(cells["work"][key]) for cells in (before, after)]
            for name in counts[0].keys() & counts[1].keys():
                sums[0][name] += counts[0][name]
                sums[1][name] += counts[1][name]
        for name in sorted(sums[0]):
            if sums[0][name] != sums[1][name]:
                yield Growth(str(variant), name, sums[0][name], sums[1][name], len(keys), limit)


def equally_solved(before: pd.DataFrame, after: pd.DataFrame) -> pd.DataFrame:
    """The cells that both tables solve with the same verdict: only there are work and time comparable."""
    return after[(after["verdict"] == before["verdict"]) & after["verdict"].isin(ACCEPTED)]
