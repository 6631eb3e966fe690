"""Time against size: how an entry's time to a target grows with the number of contacts, for scenes of several sizes."""

from functools import partial

import pandas as pd
from matplotlib.axes import Axes

from reports.accuracy import shifted_geometric_mean, times_to
from reports.cells import contested
from reports.figures import Panel
from reports.style import Look, log_ticks, time_axis

SIZES = 3  # fewer make no curve


def panels(rows: pd.DataFrame, looks: dict[str, Look], target: float) -> list[Panel]:
    """A panel per scene that comes in three sizes or more; rows: the annotated solves table."""
    made = []
    for scene, group in contested(rows).groupby("scene", sort=False):
        if group["contacts"].nunique() >= SIZES:
            times = times_to(group, target)
            contacts = group.groupby("problem_id")["contacts"].max()
            times["contacts"] = times["problem_id"].map(contacts)
            made.append(Panel(scene, partial(_draw, times=times, looks=looks)))
    return made


def _draw(ax: Axes, times: pd.DataFrame, looks: dict[str, Look]) -> None:
    for entry, own in times.dropna(subset="contacts").groupby("entry"):
        look = looks[entry]
        groups = own.groupby("contacts")
        mean = groups["charged"].agg(shifted_geometric_mean)
        missed = ~groups["reached"].all()
        ax.plot(mean.index, mean, color=look.colour)
        ax.plot(mean.index[~missed], mean[~missed], look.marker, color=look.colour)
        ax.plot(mean.index[missed], mean[missed], "x", color=look.colour, mew=1.4)
    sizes = sorted(times["contacts"].dropna().unique())
    shown = [n for i, n in enumerate(sizes) if i == 0 or n >= 1.8 * sizes[i - 1]]
    log_ticks(ax, "x", {n: f"{n:g}" for n in shown})
    time_axis(ax, "y")
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("contacts")
    ax.set_ylabel("time to the target")
