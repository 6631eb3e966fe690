"""Speed against accuracy over all problems in the plane or in space: a point per label and tolerance, and the Pareto front.

Time is the weighted shifted geometric mean over the problems, where a missing answer is charged the time limit. Accuracy is the
weighted median of the verified residual, where a missing answer counts as infinite. Only labels that ran on every problem are
drawn, because means over different problems are not comparable.
"""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from numpy.typing import NDArray

from frictionbench.problems.verdicts import measured
from frictionbench.reports.accuracy import OVERALL, quantile, shifted_geometric_mean, weights
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK, WORST, ZERO, Look, name_axes, residual_axis, time_axis
from frictionbench.reports.run import Run

UPPER_MEDIAN = 0.5 + 1e-9  # the upper median: solving half of the problems does not make a solver accurate


def panels(run: Run) -> list[Panel]:
    """Return a panel for the plane and one for space, if some solver ran on all problems."""
    tables = {where: means(run.ranked[run.ranked["dimension"] == dimension]) for dimension, where in OVERALL.items()}
    return [Panel(where, partial(_draw, points=points, looks=run.looks)) for where, points in tables.items() if len(points)]


def means(rows: pd.DataFrame) -> pd.DataFrame:
    """Return time (s) and residual for each label and tolerance that was tried on every problem. rows: the ranked ones."""
    rows = rows.assign(
        time=rows["time"].where(rows["answered"], rows["time_limit"]),
        residual=rows["residual"].where(rows["answered"], np.inf),
        ran=rows["problem_id"].where(measured(rows)),
    )
    points = []
    for (label, tol), group in rows.groupby(["label", "tol"], sort=False):
        if group["ran"].nunique() == rows["problem_id"].nunique():
            weight = weights(group).to_numpy()
            typical = quantile(group["residual"].to_numpy(), weight, UPPER_MEDIAN)
            points.append((label, tol, shifted_geometric_mean(group["time"], weight), np.clip(typical, ZERO, WORST)))
    return pd.DataFrame(points, columns=["label", "tol", "time", "residual"])


def front(time: NDArray[np.float64], residual: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the indices of the Pareto-optimal points, the fastest first."""
    order = np.lexsort((residual, time))
    best = np.minimum.accumulate(np.r_[np.inf, residual[order][:-1]])
    return order[residual[order] < best]


def _draw(ax: Axes, points: pd.DataFrame, looks: dict[str, Look]) -> None:
    for label, of_label in points.groupby("label"):
        look, along = looks[str(label)], of_label.sort_values("tol", ascending=False)
        ax.plot(along["time"], along["residual"], **look.line)
    best = points.iloc[front(points["time"].to_numpy(), points["residual"].to_numpy())]
    ax.step(best["time"], best["residual"], where="post", color=INK, lw=3, alpha=0.15, zorder=0)
    time_axis(ax, "x")
    residual_axis(ax, min(1e-8, points["residual"].min()))
    name_axes(ax, "mean time", "median residual")


CHART = Chart(
    name="pareto",
    panels=panels,
    section="top",
    title="Speed against accuracy",
    ranked=True,
    caption="The mean time and the median verified residual by Coulomb's law at each tolerance, for the solvers that ran on "
    "every problem. Lower and further left is better; the grey line is the Pareto front, formed by the solvers for which no "
    "other shown is both faster and more accurate.",
)
