"""Time against size: growth of the time to a target with the number of contacts, for scenes of several sizes.

The exponent p of time ~ contacts^p is the slope of the least-squares line through the logarithms, over the sizes at which every
problem was solved; ± gives the standard error of the slope.
"""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.accuracy import TARGETS, Array, shifted_geometric_mean
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look, log_ticks, name_axes, time_axis
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run

TARGET = TARGETS[1]
SIZES = 3  # the fewest sizes for which a slope has a standard error


def panels(run: Run) -> list[Panel]:
    """Return a panel per scene with SIZES sizes or more, with the exponent of each label."""
    contacts = run.ranked.groupby("problem_id")["contacts"].max()
    target = TARGET if TARGET in run.times else run.outer_targets[-1]
    times = run.times[target].join(contacts, on="problem_id")
    scenes = times.groupby("scene", sort=False)
    curves_by_scene = {str(scene): _curves(times) for scene, times in scenes if times["contacts"].nunique() >= SIZES}
    means = [curve["mean"] for curves in curves_by_scene.values() for curve in curves.values()]
    ends = (min(mean.min() for mean in means) / 1.5, 1.5 * max(mean.max() for mean in means)) if means else (0.0, 0.0)
    draw = partial(_draw, looks=run.looks, ends=ends, up=f"time to {power(target)}")
    return [Panel(scene, partial(draw, curves=curves), notes=_exponents(curves)) for scene, curves in curves_by_scene.items()]


def _curves(times: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return for each label, by number of contacts, the mean (s) and `all`, whether all problems of that size were solved."""
    groups = times.groupby(["label", "contacts"])
    table = pd.DataFrame({"mean": groups["charged"].agg(shifted_geometric_mean), "all": groups["reached"].all()})
    return {str(label): of_label.droplevel("label") for label, of_label in table.groupby("label")}


def exponent(contacts: Array, time: Array) -> tuple[float, float]:
    """Return the slope of log time over log contacts and its standard error; NaN for fewer than SIZES sizes."""
    if len(contacts) < SIZES:
        return np.nan, np.nan
    (slope, _), covariance = np.polyfit(np.log(contacts), np.log(time), 1, cov=True)
    return float(slope), float(np.sqrt(covariance[0, 0]))


def _exponents(curves: dict[str, pd.DataFrame]) -> dict[str, str]:
    """Return the exponents, as text, of the labels that solve enough sizes, the smallest first."""
    solved = {label: curve.loc[curve["all"] & (curve.index > 0), "mean"] for label, curve in curves.items()}
    slopes = [(*exponent(mean.index.to_numpy(dtype=float), mean.to_numpy()), label) for label, mean in solved.items()]
    known = sorted(one for one in slopes if np.isfinite(one[0]))
    return {label: f"n^{slope:.1f} ± {error:.1f}" for slope, error, label in known}


def _draw(ax: Axes, curves: dict[str, pd.DataFrame], looks: dict[str, Look], ends: tuple[float, float], up: str) -> None:
    for label, curve in curves.items():
        look, incomplete = looks[label], curve[~curve["all"]]
        ax.plot(curve.index, curve["mean"], color=look.colour, ls=look.dash, gid=look.tag)
        ax.plot(curve.index[curve["all"]], curve.loc[curve["all"], "mean"], look.marker, color=look.colour, gid=look.tag)
        ax.plot(incomplete.index, incomplete["mean"], "x", color=look.colour, mew=1.4, gid=look.tag)
    sizes = sorted({size for curve in curves.values() for size in curve.index})
    shown = sizes[:1]
    for size in sizes[1:]:
        shown += [size] if size >= 1.8 * shown[-1] else []
    log_ticks(ax, "x", {n: f"{n:g}" for n in (shown if len(shown) > 1 else [sizes[0], sizes[-1]])})
    ax.set_ylim(ends)
    time_axis(ax, "y")
    name_axes(ax, "contacts", up)


CHART = Chart(
    name="growth",
    panels=panels,
    section="time",
    ranked=True,
    title="Time against size",
    caption="The mean time to the residual that the axis names. Crosses: at least one problem of that size was not solved and "
    "is charged the time limit. Below each panel, the growth of the time with the number of contacts n, fitted to the sizes "
    "solved completely, if these are three or more.",
)
