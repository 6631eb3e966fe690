"""Energy over time in closed loop, relative to the scene's energy scale. A rise without external work is an error."""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, INK, Look, name_axes
from frictionbench.reports.run import Run
from frictionbench.results.conventions import scene_title

POINTS = 200  # points of a curve: finer than the panel's resolution
FLAT = 1e-7  # per cent: smaller changes are rounding errors
MOST_PANELS = 24  # panels on the page; more make it slow to load


def panels(run: Run) -> list[Panel]:
    """A panel per scene and parameters and scheme that has a curve."""
    simulations = run.simulations
    lengths = simulations[["times", "energies"]].map(np.size).min(axis=1)
    with_curve = simulations[lengths > 1]
    groups = with_curve.groupby(["scene", "parameters", "scheme"], sort=False)
    several = len(with_curve["scheme"].unique()) > 1
    return [
        Panel(scene_title(scene, parameters) + f", {scheme}" * several, partial(_draw, simulations=group, looks=run.looks))
        for (scene, parameters, scheme), group in groups
    ]


def _draw(ax: Axes, simulations: pd.DataFrame, looks: dict[str, Look]) -> None:
    highest = 0.0
    for row in simulations.itertuples():
        count = min(len(row.times), len(row.energies))
        keep = np.unique(np.linspace(0, count - 1, min(count, POINTS)).astype(int))
        scale = row.energy_scale if row.energy_scale > 0 else 1.0
        change = 100 * (row.energies[keep] - row.energies[0]) / scale
        keep, change = (part[np.isfinite(row.times[keep]) & np.isfinite(change)] for part in (keep, change))
        if len(keep):  # matplotlib cannot place markers on an empty curve
            ax.plot(row.times[keep], change, **looks[row.label].line, markevery=(0.1, 0.3), ms=3.5, alpha=0.9)
        highest = max(highest, float(np.nanmax(change, initial=0.0)))
    ax.axhline(0, color=INK, lw=0.6)
    if highest > 1e-4:
        bottom, top = ax.get_ylim()
        ax.axhspan(0, top, color=ALARM, alpha=0.08, lw=0)
        ax.set_ylim(bottom, top)
        ax.text(0.02, 0.95, "energy gained", transform=ax.transAxes, va="center", fontsize="small", alpha=0.8)
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -FLAT), max(high, FLAT))
    ax.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
    name_axes(ax, "time in s", "change of energy, %")


CHART = Chart(
    name="energy",
    panels=panels,
    section="energy",
    caption="Change of kinetic plus potential energy since the start, relative to the scene's energy scale. Friction and "
    "impacts dissipate energy: unless an applied force does work, a rise is an error of the scheme or the solver.",
    on_page=slice(MOST_PANELS),
)
