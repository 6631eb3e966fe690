"""Comparison of two runs, as a gate for CI: verdicts first, deterministic work counters next, times last.

Verdicts and work are comparable across machines and raise an alert by themselves. Times raise an alert only if processes of
both versions ran alternately (results.times). `confirm` updates a comparison with repeated runs of the cells with alerts.
Exit codes: 0 nothing worse, 1 a regression, 2 unusable input, which includes two runs without a common cell.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.results import baseline as baselines, changes
from frictionbench.results.cells import UNKNOWN, Cells, read, rounded
from frictionbench.results.changes import GONE, Change, Flip, Growth
from frictionbench.results.conventions import RankBy
from frictionbench.results.files import ResultsError
from frictionbench.results.times import Pair, times

UNTIMED = "the two runs were made apart. `--confirm --code` runs both versions alternately on this machine"
OTHER_CONTENT = (
    "the version of --code loads {} with another content than the baseline was made with, or only one of the two loads it. "
    "Give as --code an environment with the baseline's, or for an executable or a library a checkout in which it is built; "
    "if the change is meant, accept the run as the baseline."
)
MOST_NAMES = 5  # names in a note
LIMIT_ROUNDING = 1e-5  # relative: limits in a baseline have six digits
MAJORITY, FLAKY = 0.5, 0.25  # shares of the repeats above which a change is confirmed; FLAKY for verdicts independent of load


class Limits(NamedTuple):
    """slowdown: the largest ratio of times that is not a regression, above their repeatability. times: whether times are
    compared. rank_by: which parts of them."""

    slowdown: float = 1.10
    times: bool = True
    rank_by: RankBy = RankBy.BODIES


@dataclass(frozen=True)
class Comparison:
    """The differences of `current` from `baseline`. unusable: the reason why the runs cannot be compared, or empty.

    same, new: numbers of cells. changes: see results.changes and results.times. untimed: why times were not compared. sources:
    see results.cells.
    """

    baseline: Path
    current: Path
    unusable: str = ""
    same: int = 0
    new: int = 0
    changes: tuple[Change, ...] = ()
    notes: tuple[str, ...] = ()
    untimed: str = ""
    sources: dict[str, str] = field(default_factory=dict)

    def of(self, kind: str) -> list[Any]:
        """The changes of one of changes.KINDS."""
        return [change for change in self.changes if change.kind == kind]

    @property
    def worse(self) -> list[Change]:
        """The changes for the worse, including lost cells and new cells that fail."""
        return [change for change in self.changes if change.worse]

    @property
    def better(self) -> list[Change]:
        return [change for change in self.changes if not change.worse and (isinstance(change, Flip) or change.better)]

    @property
    def counts(self) -> dict[str, int]:
        """The numbers of worse and better changes, and of unchanged, new, gone and skipped cells."""
        lost = [flip.after for flip in self.of("gone")]
        gone, skipped = lost.count(GONE), lost.count(Verdict.SKIPPED)
        counts = {"worse": len(self.worse) - len(lost), "better": len(self.better), "same": self.same, "new": self.new}
        return counts | {"gone": gone, "skipped": skipped}

    @property
    def exit_code(self) -> int:
        """0 nothing worse, 1 a regression, 2 unusable input."""
        return 2 if self.unusable else 1 if self.worse else 0


def compare(baseline: Path, current: Path, limits: Limits = Limits()) -> Comparison:  # noqa: B008  # Limits is immutable
    """Compare two runs, either of which may be a baseline.

    Input that cannot be compared is reported in `unusable`, not raised.
    """
    try:
        old, new = read(baseline, limits.rank_by), read(current, limits.rank_by)
    except ResultsError as error:
        return Comparison(baseline, current, unusable=str(error))
    if unusable := _unusable(old, new):
        return Comparison(baseline, current, unusable=unusable)
    common = old.measured.index.intersection(new.measured.index)
    alike = bool(old.machine) and old.machine == new.machine
    found, timeouts = _differences(old.table, new.table, alike, limits)
    timed = times([(old.table, new.table)], limits.slowdown) if alike and limits.times else []
    return Comparison(
        baseline,
        current,
        same=len(common) - sum(change.kind == "flips" for change in found),
        new=len(new.measured.index.difference(old.measured.index)),
        changes=(*found, *timed),
        notes=tuple(_notes(old, new, timeouts)),
        untimed="" if alike or not limits.times else UNTIMED,
        sources=new.sources,
    )


def _unusable(old: Cells, new: Cells) -> str:
    """Return why the runs cannot be compared, or an empty text."""
    for side in (old, new):
        if not side.finished:
            return f"{side.path}: the run is not finished; run the same command again to resume it"
    for name in ("suite", "tolerances"):
        if getattr(old, name) != getattr(new, name):
            return f"the runs differ in their {name}"
    limits = pd.concat([side.measured["limit"] for side in (old, new)], axis=1, join="inner", keys=["before", "after"])
    if limits.empty:
        return "no cell was measured in both runs"
    longer = limits[limits["after"] > (1 + LIMIT_ROUNDING) * limits["before"]]
    for _, (before, after) in longer.head(1).iterrows():
        return f"{new.path}: has a longer time limit, {after:g} s in place of {before:g} s, which a slower solver needs"
    return ""


def _differences(
    before: pd.DataFrame, after: pd.DataFrame, alike: bool, limits: Limits, excused: bool = True
) -> tuple[list[Change], int]:
    """Return the changes except those of times, and the number of changed timeouts that the machine's speed may explain. If
    `excused`, these do not count as changes."""
    ran = [cells[measured(cells)] for cells in (before, after)]
    common = ran[0].index.intersection(ran[1].index)
    old, new = before.loc[common], after.loc[common]
    by_speed = changes.explained_by_speed(old, new, alike) & excused
    old, new = old[~by_speed], new[~by_speed]
    cells = *changes.flips(old, new), *changes.gone(before, after), *changes.added(before, after)
    return [*cells, *changes.work(old, new), *(changes.untimed(old, new) if limits.times else ())], int(by_speed.sum())


def _notes(old: Cells, new: Cells, timeouts: int) -> Iterator[str]:
    if timeouts:
        yield f"Not counted as changes: {timeouts} cells whose timeout the speed of the machine may explain."
    if old.code and new.code and old.code != new.code:
        yield f"Code: {old.code} (baseline), {new.code} (current)."
    elif old.made and old.made == new.made:
        yield "The baseline is this very run, which cannot be worse than itself."


def other_loads(recorded: Cells, before: Cells, alone: bool = True) -> dict[str, list[str]]:
    """Return by variant the names of files that the baseline's code now loads with another content than when the baseline was
    made or, if `alone`, that only one of the two loaded. Its results then do not show what the baseline's version does here.

    The suite's own libraries, whose versions are recorded, may be loaded in one run and not in the other. An unknown content is
    another one.
    """
    names_by_variant: dict[str, list[str]] = {}
    for variant in before.table["variant"].unique():
        known, then = recorded.loaded.get(variant, {}), before.loaded.get(variant, {})
        other = {name for name in known.keys() | then.keys() if known.get(name) != then.get(name) or known[name] == UNKNOWN}
        both = known.keys() & then.keys()
        names = [name for name in other if name in both or (alone and "." not in (known | then)[name])]
        names_by_variant |= {variant: sorted(names)} if names else {}
    return names_by_variant


def confirm(
    comparison: Comparison, pairs: Sequence[Pair], both: bool, limits: Limits, others: Mapping[str, Sequence[str]] | None = None
) -> Comparison:
    """Return the comparison with only the alerts that remain after their cells were run again.

    pairs: for each of the alternating runs, the cells of the baseline's code and of the current code. If the baseline's code is
    not available, `both` is false and its recorded cells are used. An alert remains if it occurs in more than MAJORITY of the
    pairs, or if its solver was not run again or is in `others` (other_loads). For a verdict other than a timeout, the share of
    pairs in which it is worse, minus the share in which it is better, must exceed FLAKY instead, and so must that in which a
    cell, a counter or times are gone. Such a change is an alert even if the first two runs did not show it. Times are judged by
    their confidence intervals.
    """
    votes: Counter[tuple[str, str]] = Counter()
    seen: dict[tuple[str, str], Change] = {}
    record = read(comparison.baseline).table
    for ran, after in pairs:
        before = pd.concat([ran, record[~record.index.isin(ran.index)]])  # cells that the old code lacks
        found, _ = _differences(before, after, both, limits, excused=not both)
        alerts = {_name(change): change for change in found if change.worse}
        votes.update(alerts.keys())
        votes.subtract(_name(change) for change in found if change.kind == "flips" and not change.worse)
        seen |= alerts
    others = others or {}
    repeated = {variant for _, after in pairs for variant in after["variant"]} - others.keys()

    def recurs(change: Change) -> bool:
        least = FLAKY if _is_loss(change) and change.after != Verdict.TIMEOUT else MAJORITY
        return votes[_name(change)] > least * len(pairs)

    known = [change for change in comparison.changes if change.kind != "times"]
    dismissed = [change for change in known if change.worse and change.variant in repeated and not recurs(change)]
    names = set(map(_name, known))
    fresh = [change for name, change in seen.items() if both and name not in names and _is_loss(change) and recurs(change)]
    remaining = [*(change for change in known if change not in dismissed), *fresh]
    why = "in most repeats both versions give the same result" if both else "most repeats give the result of the baseline"
    notes = [f"Not confirmed, {why}: {variant}, {name}." for variant, name in sorted(set(map(_name, dismissed)))]
    for variant, files in others.items():
        notes.append(f"{variant}: nothing is dismissed: {OTHER_CONTENT.format(', '.join(files[:MOST_NAMES]))}")
    timed = {time.variant: time for time in (times(pairs, limits.slowdown) if both and limits.times else [])}
    differing, still = (sum(change.kind in ("flips", "gone") for change in each) for each in (known, remaining))
    return replace(
        comparison,
        same=comparison.same + differing - still,
        changes=(*remaining, *({time.variant: time for time in comparison.of("times")} | timed).values()),
        untimed="" if timed else "no cell was timed in both versions" if both and limits.times else comparison.untimed,
        notes=(*comparison.notes, *notes),
    )


def _is_loss(change: Change) -> bool:
    """Return whether a change is one of a verdict, or of a counter or times that are gone, and not of their size."""
    return isinstance(change, Flip) or (isinstance(change, Growth) and change.after is None)


def _name(change: Change) -> tuple[str, str]:
    return change.variant, change.name


def accept(folder: Path, path: Path) -> tuple[Comparison | None, str]:
    """Write the run in folder as the baseline at path. Return its comparison with the previous one, if any, and a summary.

    Errors: ResultsError if the run is not finished or has no cell to compare, or if path is a file that is not a baseline or
    one that the run cannot be compared with.
    """
    run, before = read(folder), None
    if unusable := compare(folder, folder, Limits(times=False)).unusable:
        raise ResultsError(f"{folder}: cannot be a baseline: {unusable}")
    if path.exists():
        baselines.read(path)  # refuses to overwrite a file that is not a baseline
        before = compare(path, folder, Limits(times=False))
        if before.unusable:
            raise ResultsError(f"{path}: {before.unusable}; delete the file to accept a run that cannot be compared with it")
    tolerances = " ".join(f"{tol:g}" for tol in run.tolerances)
    facts = {"suite": run.suite, "tolerances": tolerances, "code": run.code, "made": run.made}
    for variant, loaded in run.loaded.items():
        facts[f"{baselines.LOADED}{variant}"] = "; ".join(f"{name} {digest}" for name, digest in sorted(loaded.items()))
    baselines.write(path, facts, _lines(run))
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(run.table["verdict"]).most_common())
    summary = f"accepted: {path}, {len(run.table)} cells: {verdicts}"
    if (run.table["verdict"] == Verdict.TIMEOUT).any():
        summary += "\ntimeouts may be the machine's doing: `frictionbench run --retake` repeats them"
    return before, summary


def _lines(run: Cells) -> list[tuple[str, ...]]:
    table = run.table.assign(
        tol=[f"{tol:g}" for tol in run.table["tol"]],
        residual=[rounded(value, 2) for value in run.table["residual"]],
        seconds=[rounded(value, 1) for value in run.table["seconds"]],
        limit=[f"{limit:g}" for limit in run.table["limit"]],
    )
    return [(*row[1:], row[0]) for row in table[list(baselines.COLUMNS)].itertuples()]
