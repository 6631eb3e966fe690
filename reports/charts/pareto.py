"""Speed against accuracy over all problems: a point for each label and tolerance, and their Pareto front.

Time is the shifted geometric mean over the problems, with problems not solved charged the time limit; accuracy is the median
of the verified residual, a missing answer counting as infinite. Only labels that ran on every problem are drawn, because means
over different problems are not comparable. The front joins the points for which no other is both faster and more accurate.
"""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray

from frictionbench.reports.accuracy import shifted_geometric_mean
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import WHOLE, Panel
from frictionbench.reports.drawing.style import GRID, INK, WORST, ZERO, Look, residual_axis, time_axis
from frictionbench.reports.run import Run
from frictionbench.results.verdicts import measured


def panels(run: Run) -> list[Panel]:
    """One panel, if some solver ran on all problems."""
    points = means(run)
    return [Panel("all problems", partial(_draw, points=points, looks=run.looks), size=WHOLE)] if len(points) else []


def means(run: Run) -> pd.DataFrame:
    """A row per label and tolerance with an attempt on every ranked problem: time (s) and residual."""
    rows = run.ranked
    rows = rows.assign(
        time=rows["time"].where(rows["answered"], rows["time_limit"]),
        residual=rows["residual"].where(rows["answered"], np.inf),
        ran=rows["problem_id"].where(measured(rows)),
    )
    groups = rows.groupby(["label", "tol"], sort=False)
    points = groups.agg(time=("time", shifted_geometric_mean), residual=("residual", "median"), ran=("ran", "nunique"))
    points = points[points["ran"] == rows["problem_id"].nunique()].drop(columns="ran").reset_index()
    return points.assign(residual=points["residual"].clip(ZERO, WORST))


def front(time: NDArray[np.float64], residual: NDArray[np.float64]) -> NDArray[np.intp]:
    """The indices of the Pareto-optimal points, the fastest first."""
    order = np.lexsort((residual, time))
    best = np.minimum.accumulate(np.r_[np.inf, residual[order][:-1]])
    return order[residual[order] < best]


def _draw(ax: Axes, points: pd.DataFrame, looks: dict[str, Look]) -> None:
    for label, own in points.groupby("label"):
        look, along = looks[str(label)], own.sort_values("tol", ascending=False)
        ax.plot(along["time"], along["residual"], **look.line)
    best = points.iloc[front(points["time"].to_numpy(), points["residual"].to_numpy())]
    ax.step(best["time"], best["residual"], where="post", color=INK, lw=3, alpha=0.15, zorder=0)
    time_axis(ax, "x")
    residual_axis(ax, min(1e-8, points["residual"].min()))
    ax.grid(**GRID)
    ax.set_xlabel("time, shifted geometric mean")
    ax.set_ylabel("median verified residual")


CHART = Chart(
    name="pareto",
    panels=panels,
    section="chart",
    caption="All problems together: the shifted geometric mean of the time (form, setup and solve) and the median verified "
    "residual at each tolerance, for the solvers that ran on every problem. Lower and further left is better; the grey line is "
    "the Pareto front, formed by the solvers for which no other is both faster and more accurate.",
)
