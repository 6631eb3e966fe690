"""Noise of the timings: how much a shared core lengthened times, and whether it decides a winner.

A cell is disturbed if its process waited for its core while it was timed, or had no core of its own. Its recorded time is the
median of its repeats. Its fastest repeat may have been disturbed as well, so that their ratio is a lower bound of the
disturbance. Both rankings are made again with the fastest repeat of each disturbed cell.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from frictionbench.reports.choice import Kind, choices
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run
from frictionbench.results.conventions import RankBy

PARTS = ("form", "setup", "solve")


class Noise(NamedTuple):
    """Of the disturbed cells: their number, the numbers of those for which no core was left and of those that were timed once;
    the ratio of the recorded time to the fastest repeat, its median and its largest value, 1 without repeats; and the kinds of
    problems whose winner by a ranking changes with the fastest repeats, each with a winner and the other one."""

    cells: int
    without_core: int
    once: int
    median: float
    worst: float
    changed: list[str]


def timing_noise(run: Run, ranked: Mapping[RankBy, list[Kind]]) -> Noise | None:
    """The noise of a run; None if no cell was disturbed. ranked: its choices by each ranking."""
    disturbed = run.rows[run.rows["disturbed"].eq(True) & run.rows["solve_time"].notna()]
    if disturbed.empty:
        return None
    repeats = [_repeats(row) for row in disturbed[[f"{part}_times" for part in PARTS]].itertuples(index=False)]
    fastest = np.array([own[:, own.sum(axis=0).argmin()] if own is not None else [np.nan] * 3 for own in repeats])
    recorded = disturbed[[f"{part}_time" for part in PARTS]].fillna(0.0).to_numpy()
    several = np.array([own is not None and own.shape[1] > 1 for own in repeats])
    ratio = (recorded.sum(axis=1) / fastest.sum(axis=1))[several].clip(min=1)
    quiet = run.rows.copy()
    quiet.loc[disturbed.index[several], [f"{part}_time" for part in PARTS]] = fastest[several]
    calm = replace(run, rows=quiet.assign(time=run.rank_by.time(quiet)))
    changed = [told for by, kinds in ranked.items() for told in _changed(by, kinds, choices(calm.ranked_by(by)))]
    levels = (float(np.median(ratio)), float(ratio.max())) if len(ratio) else (1.0, 1.0)
    without_core = int(disturbed["core"].isna().sum())
    return Noise(len(disturbed), without_core, int((~several).sum()), *levels, changed)


def sentence(found: Noise, cells: int) -> str:
    """The noise in words; without what has changed. cells: how many were run."""
    waited = found.cells - found.without_core
    kinds = [f"{waited} waited for their core"] * (waited > 0) + [f"{found.without_core} had none"] * (found.without_core > 0)
    told = f"Timing noise, by the fastest repeats: median at least +{100 * (found.median - 1):.0f} %, worst at least "
    told += f"×{found.worst:.3g}, of {found.cells} of {cells} cells, of which {' and '.join(kinds)}"
    if found.once:
        told += f" ({found.once} of them timed once, whose noise is not known)"
    return told + ("; no winner changes with the fastest repeats, by either ranking." if not found.changed else ".")


def _repeats(row: tuple[object, ...]) -> np.ndarray | None:
    """The repeats of a cell, a row per part and a column per repeat; None if they were not recorded."""
    parts = [np.atleast_1d(np.asarray([] if part is None else part, dtype=float)) for part in row]
    count = len(parts[-1])
    return np.array([part if len(part) == count else np.zeros(count) for part in parts]) if count else None


def _changed(by: RankBy, kinds: list[Kind], calm: list[Kind]) -> list[str]:
    found = []
    for kind, other in zip(kinds, calm, strict=True):
        for target, choice in kind.choices.items():
            one, two = choice.winner, other.choices[target].winner
            if one and two and one.label != two.label:
                found.append(f"{kind.name}, {by.words}, to {power(target)}: {two.label} in place of {one.label}")
    return found
