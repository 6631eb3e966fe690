"""Performance profiles of Dolan and Moré: who is how often within tau times the fastest."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

from reports.accuracy import TARGETS, profile
from reports.charts.chart import Chart
from reports.drawing.figures import Panel
from reports.drawing.style import Look, log_ticks
from reports.drawing.text import power
from reports.run import Run

FARTHEST = 1e3  # ratio to the fastest at the right edge


def panels(run: Run) -> list[Panel]:
    """A panel per target that somebody tried for."""
    return [
        Panel(f"within {power(target)}", partial(draw, times=times, looks=run.looks))
        for target, times in run.times.items()
        if len(times)
    ]


def draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look]) -> None:
    for entry, (ratio, share) in profile(times).items():
        look = looks[entry]
        near = ratio <= FARTHEST
        x, y = [1.0, *ratio[near], FARTHEST], [0.0, *share[near]]
        ax.step(x, [*y, y[-1]], where="post", **look.line, markevery=(0.1, 0.15))
    log_ticks(ax, "x", {10.0**k: f"{10**k}" for k in range(4)})
    ax.set_xlim(1, FARTHEST)
    ax.set_ylim(0, 1.03)
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("time over the fastest solver's time")
    ax.set_ylabel("share of the problems")


CHART = Chart(
    name="profiles",
    panels=panels,
    section="time",
    title="Performance profiles",
    caption="The share of all non-trivial problems brought within the target in at most so many times the time of the fastest "
    "solver there. Left edge: how often a solver is the fastest; right edge: how often it gets there at all.",
    in_paper=slice(None, None, len(TARGETS) - 1),  # the coarsest and the finest
)
