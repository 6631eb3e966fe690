"""Runs over time: for each solver a line per run that measured it, with verdicts, work and time over the cells that all of
these runs measured; as a table, and as a page with a panel per solver.

In a panel a line is a counter, or the time, over that of the first run that has it, so that different units share an axis. A
time is drawn only beside others of the same machine. A mark is a run whose counter differs by more than GROWTH from the run
before, or that solves another number of cells.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray
from rich.table import Table
from rich.text import Text

from frictionbench.problems.verdicts import ACCEPTED
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, GRID, INK
from frictionbench.reports.drawing.text import plain, seconds
from frictionbench.reports.templates import environment
from frictionbench.results.cells import Cells, format_counts, parse_counts, read
from frictionbench.results.files import ResultsError, printable, write_text

Array = NDArray[np.float64]
GROWTH = 1.05  # as in results.compare, what rounding does not explain
SIZE = (4.2, 2.4)  # inches
LEAST = 1.2  # of the range of an axis, so that a change by rounding is not drawn large
COLOURS = ("#0077bb", "#e69f00", "#009e73", "#cc79a7", "#56b4e9")


class Line(NamedTuple):
    """A solver in one run: the verdicts of the cells, and over those that every run solves the sums of the counters and the
    geometric mean of the times, s."""

    run: Cells
    verdicts: Counter[str]
    work: Counter[str]
    time: float

    @property
    def solved(self) -> int:
        """The number of cells with an accepted verdict."""
        return sum(count for verdict, count in self.verdicts.items() if verdict in ACCEPTED)


def lines(paths: Iterable[Path]) -> dict[str, list[Line]]:
    """By solver its lines in the runs, results folders or baselines, the oldest first.

    Errors: ResultsError if one cannot be read, or if nothing was measured in any.
    """
    runs = sorted(map(read, paths), key=lambda run: run.made)
    measured = [(run, run.measured) for run in runs]
    found = {}
    for variant in sorted({variant for _, cells in measured for variant in cells["variant"]}):
        own = [(run, cells[cells["variant"] == variant]) for run, cells in measured if variant in set(cells["variant"])]
        common = _common([cells for _, cells in own])
        good = [key for key in common if all(cells["verdict"][key] in ACCEPTED for _, cells in own)]
        found[variant] = [_line(run, cells.loc[common], good) for run, cells in own]
    if not found:
        raise ResultsError("history: no cell was measured in these runs")
    return found


def history(found: dict[str, list[Line]]) -> Table:
    """The lines as a table."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("solver", "run", "made", "code", "cells", "verdicts", "work", "time"):
        table.add_column(name, overflow="fold")
    for variant, own in found.items():
        for i, line in enumerate(own):
            verdicts = ", ".join(f"{count} {verdict}" for verdict, count in line.verdicts.most_common())
            results = (str(line.verdicts.total()), verdicts, format_counts(dict(line.work)), seconds(line.time))
            names = (
                "" if i else printable(variant),
                str(line.run.path),
                printable(line.run.made[:10]),
                printable(line.run.code),
            )
            table.add_row(*map(Text, (*names, *results)))
    return table


def _common(tables: Sequence[pd.DataFrame]) -> pd.Index:
    common = tables[0].index
    for table in tables[1:]:
        common = common.intersection(table.index)
    return common


def _line(run: Cells, cells: pd.DataFrame, good: list[str]) -> Line:
    work: Counter[str] = Counter()
    for text in cells.loc[good, "work"]:
        work.update(parse_counts(text))
    mean = float(np.exp(np.log(cells.loc[good, "seconds"]).mean())) if len(good) else np.nan
    return Line(run, Counter(cells["verdict"]), work, mean)


def write_history(found: dict[str, list[Line]], path: Path) -> Path:
    """Write the page; return its path."""
    drawn = {variant: own for variant, own in found.items() if series(own)}
    panels = [Panel(variant, partial(draw, lines=own), size=SIZE) for variant, own in drawn.items()]
    steps = {variant: changes(own) for variant, own in found.items()}
    write_text(path, environment().get_template("history.html").render(panels=panels, steps=steps, runs=found))
    return path


def changes(lines: list[Line]) -> dict[int, str]:
    """The runs, by their number, at which something changes, with what does."""
    found = {}
    for k, (before, after) in enumerate(pairwise(lines), start=1):
        told = [f"{before.solved} → {after.solved} cells solved"] if before.solved != after.solved else []
        for name in sorted(before.work.keys() | after.work.keys()):
            a, b = before.work[name], after.work[name]
            if max(a, b) > GROWTH * min(a, b):
                told.append(f"{name} {a} → {b}")
        if told:
            found[k] = ", ".join(told)
    return found


def series(lines: list[Line]) -> dict[str, Array]:
    """By name the counters of a solver run by run, and its times, where two are of one machine; NaN where a run has none."""
    found = {name: [line.work.get(name, 0) or np.nan for line in lines] for name in sorted(lines[-1].work)}
    machine = next((line.run.machine for line in reversed(lines) if line.run.machine), {})
    found["time"] = [line.time if machine and line.run.machine == machine else np.nan for line in lines]
    known = {name: np.array(values, dtype=float) for name, values in found.items()}
    return {name: values for name, values in known.items() if np.isfinite(values).sum() > (name == "time")}


def draw(ax: Axes, lines: list[Line]) -> None:
    """Draw the counters and the time of one solver, run by run."""
    at = np.arange(len(lines))
    for k, (name, known) in enumerate(series(lines).items()):
        style: Any = {"color": INK, "ls": ":", "marker": "s"} if name == "time" else {"color": COLOURS[k % 5], "marker": "o"}
        ax.plot(at, known / known[np.isfinite(known)][0], label=plain(name), **style)
    for k in changes(lines):
        ax.axvline(k, color=ALARM, lw=0.8, ls="--", alpha=0.7)
    ax.axhline(1, color=INK, lw=0.5, alpha=0.5)
    ax.set_xticks(at, [f"{plain(line.run.made[5:10])}\n{plain(line.run.code[:8])}" for line in lines])
    ax.set_xlim(-0.3, max(len(lines) - 0.7, 0.3))
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, 1 / LEAST), max(high, LEAST))
    ax.set_ylabel("over the first run")
    ax.grid(axis="y", **GRID)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="upper left")
