"""The speed-accuracy chart: verified residual against time, one panel per problem class. Its caption explains the marks."""

from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.axes import Axes

from frictionbench.problems.verdicts import Verdict, measured
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ALARM, INK, WORST, ZERO, Look, name_axes, residual_axis, time_axis
from frictionbench.reports.drawing.text import seconds
from frictionbench.reports.run import Run
from frictionbench.results.commands import rerun
from frictionbench.results.conventions import scene_title

STRIP = 2e3  # upper end of the strip above WORST
MOST_TOOLTIPS = 5000  # with more cells in a run, dots have no tooltips, which would make the page too large
MOST_DOTS = 1500  # more dots are drawn as an image, for the same reason


def panels(run: Run) -> list[Panel]:
    """Return a panel per problem class, all with the same axes."""
    answers = run.ranked[run.ranked["answered"]]
    ends = (0.7 * answers["time"].min(), 1.4 * answers["time"].max()) if len(answers) else (1e-3, 1.0)
    lowest = min(1e-10, _shown(answers["residual"]).min()) if len(answers) else 1e-10
    draw = partial(_draw, looks=run.looks, ends=ends, lowest=lowest, across=f"time, {run.rank_by.parts}")
    few = len(run.ranked) <= MOST_TOOLTIPS
    classes = run.ranked.groupby("problem_class", sort=False)
    return [Panel(name, partial(draw, rows=group), _tooltips(group, run) if few else {}) for name, group in classes]


def _tooltips(rows: pd.DataFrame, run: Run) -> dict[str, list[str]]:
    """Return for each dot the solver, problem, accuracy and time, and the command that runs the cell again."""
    return {
        run.looks[str(label)].tag: [
            f"{label}\n{scene_title(row.scene, row.parameters)}, step {row.step}, tolerance {row.tol:g}\n"
            f"residual {row.residual:.1e} in {seconds(row.time)}: {row.verdict}\n"
            + rerun(Path("DIR"), row.key, row.variant, run.plugins)
            for row in of_label.itertuples()
        ]
        for label, of_label in rows[rows["answered"]].groupby("label")
    }


def _draw(ax: Axes, rows: pd.DataFrame, looks: dict[str, Look], ends: tuple[float, float], lowest: float, across: str) -> None:
    answers = rows[rows["answered"]]
    rasterised = len(answers) > MOST_DOTS
    for label, own in answers.groupby("label"):
        look = looks[label]
        dots = ax.scatter(own["time"], _shown(own["residual"]), s=5, lw=0, color=look.colour, alpha=0.35, rasterized=rasterised)
        dots.set_gid(f"dots-{look.tag}")
        medians = own.groupby("tol")[["time", "residual", "model_residual"]].median().sort_index(ascending=False)
        ax.plot(medians["time"], _shown(medians["residual"]), **look.line)
        if (own["model"] == "relaxation").any():
            ax.plot(medians["time"], _shown(medians["model_residual"]), **look.line | {"ls": ":", "mfc": "none", "lw": 0.8})
    wrong = answers[answers["verdict"] == Verdict.WRONG]
    ring = 1.7 * mpl.rcParams["lines.markersize"]
    ax.plot(wrong["time"], _shown(wrong["residual"]), "o", ms=ring, mfc="none", mec=ALARM, zorder=4)
    ax.set_xlim(ends)
    time_axis(ax, "x")
    bottom = 10.0 ** np.floor(np.log10(lowest))
    residual_axis(ax, bottom)
    ax.set_ylim(bottom / 30, STRIP)
    name_axes(ax, across, "verified residual", grid="y")
    _no_answers(ax, rows, looks)


def _shown(residual: pd.Series) -> pd.Series:
    return residual.clip(ZERO, WORST)


def _no_answers(ax: Axes, rows: pd.DataFrame, looks: dict[str, Look]) -> None:
    counts = rows[~rows["answered"] & measured(rows)].groupby("label").size()
    if counts.empty:
        return
    ax.axhspan(WORST, STRIP, color=INK, alpha=0.07, lw=0)
    ax.text(-0.03, 0.95, "none", transform=ax.transAxes, va="center", ha="right", fontsize="small")
    for i, (label, count) in enumerate(counts.items()):
        x, colour = 0.02 + 0.98 * i / max(6, len(counts)), looks[str(label)].colour
        ax.text(x, 0.95, f"×{count}", transform=ax.transAxes, va="center", fontsize="small", weight="bold", color=colour)


CHART = Chart(
    name="speed_accuracy",
    panels=panels,
    section="chart",
    caption=Markup(
        "Verified residual against time, by class of problems. Lower is more accurate, left is faster. Dots are cells, each of "
        "a problem and a tolerance; a line joins the medians of a solver at its tolerances. A dotted line with hollow markers "
        "is the residual of a relaxation on its own model. "
        '<span class="alarm">Red rings</span> are wrong claims; a strip at the top, none, counts cells without an answer.'
    ),
)
