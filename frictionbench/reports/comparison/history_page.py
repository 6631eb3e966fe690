"""Runs over time as a page of charts: a panel per solver, with the runs at which its verdicts or its work change marked.

A line is a counter, or the time, over that of the first run that has it, so that different units share an axis. A time is drawn
only beside others of the same machine. A mark is a run whose counter differs by more than GROWTH from the run before, or that
solves another number of cells.
"""

from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from frictionbench.reports.comparison.history import Line
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, GRID, INK
from frictionbench.reports.drawing.text import plain
from frictionbench.reports.templates import environment
from frictionbench.results.files import write_text

Array = NDArray[np.float64]
GROWTH = 1.05  # as in results.compare, what rounding does not explain
SIZE = (4.2, 2.4)  # inches
LEAST = 1.2  # of the range of an axis, so that a change by rounding is not drawn large
COLOURS = ("#0077bb", "#e69f00", "#009e73", "#cc79a7", "#56b4e9")


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
