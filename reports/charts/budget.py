"""Problems solved against time: the share of problems within the target if each problem is given the same time."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.accuracy import on_all
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import cumulative_share
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import GRID, Look, share_axis, time_axis
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
        spent, share = cumulative_share(np.sort(own.loc[own["reached"], "charged"].to_numpy()), len(own))
        if len(spent):
            ax.step([*spent, longest], [*share, share[-1]], where="post", **looks[str(label)].line, markevery=(0.1, 0.15))
    share_axis(ax)
    ax.grid(**GRID)
    time_axis(ax, "x")
    ax.set_xlabel("time for each problem")


CHART = Chart(
    name="budget",
    panels=panels,
    section="time",
    title="Solved against time",
    caption="The share of all ranked problems that a solver solves to the target if each is given that time, "
    "for example the time available for a time step. Unlike a performance profile it does not depend on the other solvers.",
    in_paper=slice(None, None, 2),
)
