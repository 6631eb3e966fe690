"""A comparison as Markdown, for a terminal and for a pull request: counts, the changes of each solver, and times."""

import os
from collections.abc import Iterator, Sequence
from itertools import accumulate, takewhile

import numpy as np

from frictionbench.reports.drawing.text import code, escaped, pipe, seconds
from frictionbench.results.cells import FILE
from frictionbench.results.changes import GONE, Change, Flip, Growth, Time
from frictionbench.results.commands import rerun
from frictionbench.results.compare import Comparison
from frictionbench.results.times import ALPHA

LISTED = 20  # rows of a table; more are counted below it
LONGEST = 60_000  # characters; a comment on GitHub may have 65 536


def markdown(comparison: Comparison) -> str:
    """The comparison as a page of Markdown."""
    runs = f"{code(str(comparison.current))} against {code(str(comparison.baseline))}"
    if comparison.unusable:
        return f"## Not comparable\n\n{runs}: {code(comparison.unusable)}\n"
    counts = " · ".join(f"{name} {count}" for name, count in comparison.counts.items())
    parts = [f"## {counts}", f"{runs}.", *map(escaped, comparison.notes)]
    if comparison.untimed:
        parts.append(f"Times are not compared: {comparison.untimed}.")
    for variant in solvers(comparison):
        own = [found for found in comparison.changes if found.variant == variant and not isinstance(found, Time)]
        if own:
            state = ": worse" if any(found.worse for found in own) else ""
            parts += [f"### {code(variant)}{state}", *_changes(comparison, own)]
    if comparison.times:
        parts += ["### Times", *_times(comparison)]
    whole = list(takewhile(lambda size: size < LONGEST, accumulate(len(part) + 2 for part in parts)))
    cut = [] if len(whole) == len(parts) else ["Truncated; `--out` writes the complete comparison as data."]
    return "\n\n".join([*parts[: len(whole)], *cut]) + "\n"


def summarise(comparison: Comparison) -> None:
    """Append the comparison to the summary of a GitHub workflow's step, if the program runs in one."""
    if path := os.environ.get("GITHUB_STEP_SUMMARY"):
        with open(path, "a", encoding="utf-8") as summary:
            summary.write(markdown(comparison) + "\n")


def solvers(comparison: Comparison) -> list[str]:
    """The solvers with changes, those with a regression first."""
    worse = {found.variant for found in comparison.worse}
    return sorted({found.variant for found in comparison.changes}, key=lambda name: (name not in worse, name))


def rerun_command(comparison: Comparison, flip: Flip) -> str:
    """The command that runs the cell again; empty if it is gone."""
    if flip.after == GONE:
        return ""
    return rerun(comparison.current, flip.key.partition(FILE)[0], flip.variant, comparison.sources)


def format_verdicts(flip: Flip) -> str:
    return f"{flip.before} → {flip.after}"


def _changes(comparison: Comparison, own: Sequence[Change]) -> Iterator[str]:
    flips = [found for found in own if isinstance(found, Flip)]
    work = [found for found in own if isinstance(found, Growth)]
    if flips:
        heads = ["verdict", "scene", "step", "tolerance", "residual", "command", "reason"]
        yield from _table(heads, [_flip(comparison, flip) for flip in flips])
    if work:
        yield from _table(["work", "before", "after", "ratio", "cells"], [*map(_growth, work)])


def _flip(comparison: Comparison, flip: Flip) -> list[str]:
    residuals = [f"{value:.1e}" if np.isfinite(value) else "–" for value in (flip.residual_before, flip.residual_after)]
    command = rerun_command(comparison, flip)
    cell = [code(flip.scene), flip.step or flip.table, f"{flip.tol:g}"]
    texts = [code(text) if text else "" for text in (command, flip.reason)]
    return [_bold(format_verdicts(flip), flip), *cell, " → ".join(residuals), *texts]


def _growth(growth: Growth) -> list[str]:
    ratio = f"×{growth.ratio:.2f}" if np.isfinite(growth.ratio) else ""
    sums = ["none" if count is None else str(count) for count in (growth.before, growth.after)]
    return [_bold(escaped(growth.counter), growth), *sums, ratio, str(growth.cells)]


def _times(comparison: Comparison) -> Iterator[str]:
    heads = ["solver", "before", "after", "ratio", f"{1 - ALPHA:.0%} interval", "p", "n", "cells"]
    order = sorted(comparison.times, key=lambda time: (not time.worse, not time.significant, -time.ratio))
    yield from _table(heads, [_time(time) for time in order])
    if any(time.n > 1 for time in comparison.times):
        yield (
            "The ratio is estimated from the n pairs of processes, one of each code, that ran one after the other (Hodges and "
            "Lehmann 1963). Before and after are medians over the processes of each code, whose quotient is as a rule another."
        )
    if not all(time.significant for time in comparison.times):
        yield "`~`: not significant. Fewer than six pairs give no interval: the repeats of one process are not independent."
        yield "`--confirm --code` runs up to eight pairs, and ends once those to come cannot show a regression any more."


def _time(time: Time) -> list[str]:
    ratio = f"×{time.ratio:.2f}"
    interval = f"{time.low:.2f} to {time.high:.2f}" if np.isfinite(time.high) else "~"
    p = f"{time.p:.2g}" if np.isfinite(time.p) else ""
    shown = f"{ratio} {'' if time.significant else '~'}".strip()
    names = [code(time.variant), seconds(time.before), seconds(time.after)]
    return [*names, _bold(shown, time), interval, p, str(time.n), str(time.cells)]


def _bold(text: str, found: Change) -> str:
    return f"**{text}**" if found.worse else text


def _table(heads: list[str], rows: list[list[str]]) -> Iterator[str]:
    """A table. Rows beyond LISTED are counted."""
    yield "\n".join(pipe(heads, rows[:LISTED]))
    if len(rows) > LISTED:
        yield f"and {len(rows) - LISTED} more, which `--out` writes as data."
