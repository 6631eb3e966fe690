"""The time of each step of a motion, for users who have to finish each step within a budget."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK, Look, name_axes, time_axis
from frictionbench.reports.drawing.text import seconds
from frictionbench.reports.recorded import step_times
from frictionbench.reports.run import Run


def panels(run: Run) -> list[Panel]:
    """A panel per motion, see reports.recorded."""
    draw = partial(_draw, looks=run.looks, budget=run.budget)
    line = "" if run.budget is None else f"; dashed: the budget of {seconds(run.budget)}"
    return [Panel(title + line, partial(draw, times=times)) for title, times in step_times(run)]


def _draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look], budget: float | None) -> None:
    for label, of_label in times.sort_values("step").groupby("label"):
        look, missed = looks[str(label)], of_label[~of_label["reached"]]
        ax.plot(of_label["step"], of_label["charged"], color=look.colour, lw=0.9, ls=look.dash, gid=look.tag)
        ax.plot(missed["step"], missed["charged"], "x", color=look.colour, ms=4, mew=1.2, gid=look.tag)
    if budget is not None:
        ax.axhline(budget, color=INK, lw=0.8, ls="--", alpha=0.7)
    time_axis(ax, "y")
    name_axes(ax, "step", "time to the tightest target", grid="y")


CHART = Chart(
    name="steps",
    panels=panels,
    section="time",
    title="Time of each step of a motion",
    ranked=True,
    caption="Crosses: the step was not solved to the tightest target and is charged the time limit.",
)
