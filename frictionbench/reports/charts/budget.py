"""Problems solved against time: the weighted share of problems within the target if each problem is given the same time."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.accuracy import Profile, overall, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import steps
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import GRID, INK, Look, share_axis, time_axis
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run


def panels(run: Run) -> list[Panel]:
    """A panel per target and dimension that some solver reaches."""
    draw = partial(_draw, looks=run.looks, budget=run.budget)
    return [
        Panel(f"{where}, within {power(target)}", partial(draw, costs=profiles(times, relative=False)))
        for target, every in run.times.items()
        for where, times in overall(every).items()
        if times["reached"].any()
    ]


def _draw(ax: Axes, costs: dict[str, Profile], looks: dict[str, Look], budget: float | None) -> None:
    longest = max(float(profile.cost[np.isfinite(profile.cost)].max(initial=0.0)) for profile in costs.values())
    for label, profile in costs.items():
        spent, share = steps(profile, longest)
        if len(spent):
            ax.step([*spent, longest], [*share, share[-1]], where="post", **looks[label].line, markevery=(0.1, 0.15))
    if budget is not None:
        ax.axvline(budget, color=INK, lw=0.8, alpha=0.6)
    share_axis(ax)
    ax.grid(**GRID)
    time_axis(ax, "x")
    ax.set_xlabel("time for each problem")


CHART = Chart(
    name="budget",
    panels=panels,
    section="time",
    title="Solved against time",
    ranked=True,
    columns=2,
    caption="The weighted share of all ranked problems that a solver solves to the target if each is given that time, "
    "for example the time available for a time step. Unlike a performance profile it does not depend on the other solvers.",
)
