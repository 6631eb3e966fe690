"""Ill-posed problems and unstable solvers: the backward error of every answer against the sensitivity of its problem.

The backward error is the smallest relative change of the data (q, mu) for which the answer is exact; a stable solver has a
small one on any problem (Higham 2002, section 1.5). Sensitivity is the relative change of the solution over that of q.
"""

from functools import partial
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK, WORST, ZERO, Look, log_ticks, name_axes, residual_axis
from frictionbench.reports.run import Run

SENSITIVITY = 1e-2, 1e8  # the range of the axis; values outside are drawn at its ends
ILL_POSED, UNSTABLE = 1e3, 1e-6  # dotted lines: a solution that loses three digits, an error far above rounding
MOST_DOTS = 4000  # more dots are drawn as an image, to keep the page small


def panels(run: Run) -> list[Panel]:
    """Return one panel with the answers at the tightest tolerance to problems whose sensitivity is known."""
    rows = run.tightest
    rows = rows[rows["answered"] & rows["sensitivity"].notna() & rows["backward_error"].notna()]
    return [Panel("all problems", partial(_draw, rows=rows, looks=run.looks))] if len(rows) else []


def _draw(ax: Axes, rows: pd.DataFrame, looks: dict[str, Look]) -> None:
    small: Any = {"ms": 3, "alpha": 0.5, "rasterized": len(rows) > MOST_DOTS}
    ax.axvline(ILL_POSED, color=INK, lw=0.6, ls=":")
    ax.axhline(UNSTABLE, color=INK, lw=0.6, ls=":")
    rows = rows.assign(x=rows["sensitivity"].clip(*SENSITIVITY), y=rows["backward_error"].clip(ZERO, WORST))
    for label, own in rows.groupby("label"):
        look = looks[str(label)]
        ax.plot(own["x"], own["y"], look.marker, color=look.colour, mew=0, gid=f"dots-{look.tag}", **small)
    failed = rows[rows["verdict"] != Verdict.SOLVED]
    ax.plot(failed["x"], failed["y"], "x", color=INK, mew=0.5, **small)
    for x, y, side, text in (
        (0.02, 0.97, "left", "unstable solver"),
        (0.98, 0.97, "right", "both"),
        (0.98, 0.03, "right", "ill-posed problem"),
    ):
        height = "top" if y > 0.5 else "bottom"
        ax.text(x, y, text, transform=ax.transAxes, ha=side, va=height, fontsize="small", alpha=0.8)
    log_ticks(ax, "x", {10.0**k: f"1e{k}" for k in range(0, 7, 2)} | {SENSITIVITY[0]: "≤1e-2", SENSITIVITY[1]: "≥1e8"})
    residual_axis(ax)
    ax.set_xlim(SENSITIVITY[0] / 2, SENSITIVITY[1] * 2)
    ax.set_ylim(ZERO / 100, WORST * 100)  # leaves room for the words above and below the dots
    name_axes(ax, "sensitivity of the problem", "backward error of the answer")


CHART = Chart(
    name="stability",
    panels=panels,
    section="solvability",
    title="Ill-posed problem or unstable solver",
    caption="A dot is an answer at the tightest tolerance, with a cross if the problem is not solved. A large backward error "
    "means that no near problem has this answer: the solver is unstable. Large sensitivity means that a small change of the "
    "problem changes its solution much: the problem is ill-posed. An answer with an impulse on a contact that opens is not "
    "exact for any change of the data and has a large backward error. The sensitivity is computed for small problems with a "
    "solution.",
)
