"""Time against size: how an entry's time to a target grows with the number of contacts, for scenes of several sizes."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes

from reports.accuracy import TARGETS, shifted_geometric_mean
from reports.charts.chart import Chart
from reports.drawing.figures import Panel
from reports.drawing.style import Look, log_ticks, time_axis
from reports.drawing.text import power
from reports.run import Run

TARGET = TARGETS[1]
SIZES = 3  # fewer make no curve


def panels(run: Run) -> list[Panel]:
    """A panel per scene that comes in three sizes or more."""
    problems = run.contested.groupby("problem_id").agg(scene=("scene", "first"), contacts=("contacts", "max"))
    scenes = run.times[TARGET].join(problems, on="problem_id").groupby("scene", sort=False)
    return [
        Panel(scene, partial(_draw, times=times, looks=run.looks))
        for scene, times in scenes
        if times["contacts"].nunique() >= SIZES
    ]


def _draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look]) -> None:
    for entry, own in times.dropna(subset="contacts").groupby("entry"):
        look = looks[entry]
        groups = own.groupby("contacts")
        mean = groups["charged"].agg(shifted_geometric_mean)
        missed = ~groups["reached"].all()
        ax.plot(mean.index, mean, color=look.colour, ls=look.dash, gid=look.tag)
        ax.plot(mean.index[~missed], mean[~missed], look.marker, color=look.colour, gid=look.tag)
        ax.plot(mean.index[missed], mean[missed], "x", color=look.colour, mew=1.4, gid=look.tag)
    sizes = sorted(times["contacts"].dropna().unique())
    shown = [n for i, n in enumerate(sizes) if i == 0 or n >= 1.8 * sizes[i - 1]]
    log_ticks(ax, "x", {n: f"{n:g}" for n in shown})
    time_axis(ax, "y")
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("contacts")
    ax.set_ylabel("time to the target")


CHART = Chart(
    name="growth",
    panels=panels,
    section="time",
    title=f"Time against size, residual within {power(TARGET)}",
    caption="Crosses: at least one problem of that size was missed and is charged at the time limit.",
)
