"""Two runs compared, as a gate for CI: verdicts first, deterministic work counters next, times last.

Verdicts and work compare across machines, and alert by themselves. Times alert only where processes of both codes ran in turn
(results.times): two runs have one process each, of which nothing can be said but that it is worth a look. `confirm` takes what
the alerting cells did when they ran again. Exit codes: 0 nothing worse, 1 a regression, 2 unusable input; a gate must not pass
having measured nothing.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from frictionbench.results import benchmarks, changes
from frictionbench.results.cells import Cells, read
from frictionbench.results.changes import Finding, Flip, Growth
from frictionbench.results.store import ResultsError
from frictionbench.results.times import Pair, Time, times
from frictionbench.results.verdicts import Verdict


class Limits(NamedTuple):
    """Ratios of time and work up to which nothing is worse; the chance of error of an interval; whether times count."""

    slowdown: float = 1.10
    growth: float = 1.05
    alpha: float = 0.05
    times: bool = True


@dataclass(frozen=True)
class Comparison:
    """What differs in `current` from `baseline`, or why that cannot be said."""

    baseline: Path
    current: Path
    unusable: str = ""
    same: int = 0
    new: int = 0
    skipped: int = 0
    flips: tuple[Flip, ...] = ()
    gone: tuple[Flip, ...] = ()
    work: tuple[Growth, ...] = ()
    times: tuple[Time, ...] = ()
    notes: tuple[str, ...] = ()
    untimed: str = ""  # why times were not compared
    alpha: float = Limits().alpha
    benchmarks: bool = False
    sources: dict[str, str] = field(default_factory=dict)  # see results.cells

    @property
    def findings(self) -> tuple[Finding, ...]:
        return (*self.flips, *self.gone, *self.work, *self.times)

    @property
    def worse(self) -> list[Finding]:
        """What is worse, or gone, and not acknowledged."""
        return [found for found in self.findings if found.worse and not found.known]

    @property
    def better(self) -> list[Finding]:
        return [*(flip for flip in self.flips if not flip.worse), *(one for one in (*self.work, *self.times) if one.better)]

    @property
    def counts(self) -> dict[str, int]:
        """How much of each: findings that are worse and better; cells that are the same, new, gone and skipped."""
        lost = sum(not flip.known for flip in self.gone)
        told = {"worse": len(self.worse) - lost, "better": len(self.better), "same": self.same, "new": self.new}
        known = sum(found.worse and bool(found.known) for found in self.findings)
        return told | {"gone": lost, "skipped": self.skipped} | ({"known": known} if known else {})

    @property
    def exit_code(self) -> int:
        """0 nothing worse, 1 a regression, 2 unusable input."""
        return 2 if self.unusable else 1 if self.worse else 0


def compare(baseline: Path, current: Path, limits: Limits = Limits()) -> Comparison:  # noqa: B008  # it is a value
    """Compare two runs, either of which may be a baseline's text, or two results of pytest-benchmark.

    Input that cannot be used is told of, not raised.
    """
    try:
        (old, *more_old), (new, *more_new) = _processes(baseline), _processes(current)
    except ResultsError as error:
        return Comparison(baseline, current, unusable=str(error))
    for name in ("suite", "tolerances"):
        if getattr(old, name) != getattr(new, name):
            return Comparison(baseline, current, unusable=f"the runs differ in their {name}")
    common = old.measured.index.intersection(new.measured.index)
    if common.empty:
        return Comparison(baseline, current, unusable="no cell was measured in both runs")
    alike = bool(old.machine) and old.machine == new.machine
    if benchmarks.are(current) and not alike:
        return Comparison(baseline, current, unusable="times of two machines do not compare")
    flips, gone, work, clocked = _differences(old.table, new.table, alike, limits)
    pairs = zip([old, *more_old], [new, *more_new], strict=False)
    timed = times([(a.table, b.table) for a, b in pairs], limits.slowdown, limits.alpha) if alike and limits.times else []
    return Comparison(
        baseline,
        current,
        same=len(common) - len(flips),
        new=len(new.measured.index.difference(old.measured.index)),
        skipped=len(old.measured.index.difference(common)) - len(gone),
        flips=flips,
        gone=gone,
        work=work,
        times=tuple(timed),
        notes=tuple(_notes(old, new, clocked)),
        untimed="" if alike or not limits.times else "the machines differ" if old.machine else "a baseline's text keeps none",
        alpha=limits.alpha,
        benchmarks=benchmarks.are(current),
        sources=new.sources,
    )


def _processes(path: Path) -> list[Cells]:
    return benchmarks.read(path) if benchmarks.are(path) else [read(path)]


def _differences(
    before: pd.DataFrame, after: pd.DataFrame, alike: bool, limits: Limits
) -> tuple[tuple[Flip, ...], tuple[Flip, ...], tuple[Growth, ...], int]:
    """Flips, what is gone, work, and how many timeouts only the machine's pace explains."""
    ran = [cells[cells["verdict"] != Verdict.SKIPPED] for cells in (before, after)]
    common = ran[0].index.intersection(ran[1].index)
    old, new = before.loc[common], after.loc[common]
    clocked = changes.by_the_clock(old, new, alike)
    flips = tuple(changes.flips(old[~clocked], new[~clocked]))
    return flips, tuple(changes.gone(before, after)), tuple(changes.work(old, new, limits.growth)), int(clocked.sum())


def _notes(old: Cells, new: Cells, clocked: int) -> Iterator[str]:
    if clocked:
        yield f"Timeouts that the machine's pace may explain, at other verdicts, are no change: {clocked} cells."
    if old.code and new.code and old.code != new.code:
        yield f"Code {old.code} before, {new.code} now."


def suspects(comparison: Comparison, limits: Limits) -> list[Time]:
    """Solvers that look slower by half of what the limit allows, and of which nothing is sure yet."""
    return [time for time in comparison.times if not time.worse and time.n == 1 and time.ratio > (1 + limits.slowdown) / 2]


def confirm(comparison: Comparison, pairs: Sequence[Pair], both: bool, limits: Limits) -> Comparison:
    """What is left of the alerts when their cells ran again.

    pairs: of the runs in turn, the cells of the baseline's code and of the current one's; the baseline's own where that code
    is not at hand, and both is false. An alert stands that stands in more than half of the pairs; times have their intervals.
    """
    votes: Counter[tuple[str, str]] = Counter()
    record = read(comparison.baseline).table
    for ran, after in pairs:
        before = pd.concat([ran, record[~record.index.isin(ran.index)]])  # what that code does not have any more is on record
        flips, gone, work, _ = _differences(before, after, both, limits)
        votes.update({_name(found) for found in (*flips, *gone, *work) if found.worse})
    alerts = [found for found in (*comparison.flips, *comparison.gone, *comparison.work) if found.worse]
    fallen = {_name(found) for found in alerts if 2 * votes[_name(found)] <= len(pairs)}
    why = "both codes do the same here" if both else "its cells ran again"
    notes = [f"Not confirmed, {why}: {variant}, {name}." for variant, name in sorted(fallen)]
    timed = {time.variant: time for time in (times(pairs, limits.slowdown, limits.alpha) if both and limits.times else [])}
    return replace(
        comparison,
        same=comparison.same + sum(_name(flip) in fallen for flip in comparison.flips),
        flips=tuple(flip for flip in comparison.flips if _name(flip) not in fallen),
        gone=tuple(flip for flip in comparison.gone if _name(flip) not in fallen),
        work=tuple(growth for growth in comparison.work if _name(growth) not in fallen),
        times=tuple(({time.variant: time for time in comparison.times} | timed).values()),
        untimed="" if timed else comparison.untimed,
        notes=(*comparison.notes, *notes),
    )


def _name(found: Finding) -> tuple[str, str]:
    return found.variant, found.name
