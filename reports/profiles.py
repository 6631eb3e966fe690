"""Performance profiles of Dolan and Moré at two targets: who is how often within tau times the fastest."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

from reports.accuracy import profile
from reports.figures import Panel
from reports.style import Look, log_ticks, power

FARTHEST = 1e3  # ratio to the fastest at the right edge


def panels(times: dict[float, pd.DataFrame], looks: dict[str, Look]) -> list[Panel]:
    """A panel per target; times: target to the table of times to it."""
    return [Panel(f"within {power(target)}", partial(_draw, times=table, looks=looks)) for target, table in times.items()]


def _draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look]) -> None:
    for entry, (ratio, share) in profile(times).items():
        look = looks[entry]
        near = ratio <= FARTHEST
        x, y = [1.0, *ratio[near], FARTHEST], [0.0, *share[near]]
        ax.step(x, [*y, y[-1]], where="post", color=look.colour, marker=look.marker, markevery=(0.1, 0.15))
    log_ticks(ax, "x", {10.0**k: f"{10**k}" for k in range(4)})
    ax.set_xlim(1, FARTHEST)
    ax.set_ylim(0, 1.03)
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("time over the fastest solver's time")
    ax.set_ylabel("share of the problems")
