"""Problems solved against time: the share of problems within the target if each problem is given the same time."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import PercentFormatter

from frictionbench.reports.accuracy import on_all
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import staircase
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look, time_axis
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run


def panels(run: Run) -> list[Panel]:
    """A panel per target that some solver reaches."""
    return [
        Panel(f"within {power(target)}", partial(_draw, times=on_all(times), looks=run.looks))
        for target, times in run.times.items()
        if times["reached"].any()
    ]


def _draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look]) -> None:
    longest = float(times.loc[times["reached"], "charged"].max())
    for label, own in times.groupby("label"):
        spent, share = staircase(np.sort(own.loc[own["reached"], "charged"].to_numpy()), len(own))
        if len(spent):
            ax.step([*spent, longest], [*share, share[-1]], where="post", **looks[str(label)].line, markevery=(0.1, 0.15))
    ax.set_ylim(0, 1.03)
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.grid(lw=0.4, alpha=0.3)
    time_axis(ax, "x")
    ax.set_xlabel("time for each problem")
    ax.set_ylabel("share of the problems")


CHART = Chart(
    name="budget",
    panels=panels,
    section="time",
    title="Solved against time",
    caption="The share of all non-trivial problems that a solver brings within the target when each is given that time, "
    "for example the time available for a time step. Unlike a performance profile it does not depend on the other solvers.",
    in_paper=slice(None, None, 2),
)
