"""Is the problem ill-posed or the solver unstable? Backward error of every answer against the sensitivity of its problem.

The backward error is the smallest relative change of the data (q, mu) under which the answer is exact: of a stable solver it
is small on any problem (Higham 2002, section 1.5). The sensitivity is how much more than q the solution changes: it is large
for an ill-posed problem, whatever the solver. So an unstable solver is high on the left, an ill-posed problem at the right.
"""

from functools import partial
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import WHOLE, Panel
from frictionbench.reports.drawing.style import INK, Look, log_ticks
from frictionbench.reports.drawing.text import scene_title
from frictionbench.reports.run import Run
from frictionbench.results.verdicts import Verdict

SENSITIVITY, ERROR = (1e-2, 1e8), (1e-17, 1e1)  # what the axes show; beyond is drawn at the edge
ILL, UNSTABLE = 1e3, 1e-6  # where the corners begin
TOLD = 4000  # answers beyond which the page does not say what each dot is, for its own size


def panels(run: Run) -> list[Panel]:
    """One panel: the answers at the tightest tolerance to problems whose sensitivity is known."""
    rows = run.contested
    rows = rows[
        rows["answered"] & rows["sensitivity"].notna() & rows["backward_error"].notna() & (rows["tol"] == rows["tol"].min())
    ]
    if rows.empty:
        return []
    return [
        Panel("all problems", partial(_draw, rows=rows, looks=run.looks), _told(rows, run) if len(rows) <= TOLD else {}, WHOLE)
    ]


def _told(rows: pd.DataFrame, run: Run) -> dict[str, list[str]]:
    columns = ["scene", "parameters", "step", "sensitivity", "backward_error", "residual", "verdict"]
    return {
        run.looks[str(label)].tag: [
            f"{label}\n{scene_title(scene, parameters)}, step {step:.0f}\nresponse {sensitivity:.1e}, "
            f"backward error {error:.1e}, residual {residual:.1e}: {verdict}"
            for scene, parameters, step, sensitivity, error, residual, verdict in own[columns].itertuples(index=False)
        ]
        for label, own in rows.groupby("label")
    }


def _draw(ax: Axes, rows: pd.DataFrame, looks: dict[str, Look]) -> None:
    crowded = len(rows) > TOLD
    ax.axvline(ILL, color=INK, lw=0.6, ls=":")
    ax.axhline(UNSTABLE, color=INK, lw=0.6, ls=":")
    for label, own in rows.groupby("label"):
        look = looks[str(label)]
        dots = ax.scatter(
            own["sensitivity"].clip(*SENSITIVITY),
            own["backward_error"].clip(*ERROR),
            s=9,
            lw=0,
            color=look.colour,
            marker=look.marker,
            alpha=0.5,
            rasterized=crowded,
        )
        dots.set_gid(f"dots-{look.tag}")
    lost = rows[rows["verdict"] != Verdict.SOLVED]
    cross: Any = {"color": INK, "ms": 3, "mew": 0.5, "alpha": 0.6, "rasterized": crowded}
    ax.plot(lost["sensitivity"].clip(*SENSITIVITY), lost["backward_error"].clip(*ERROR), "x", **cross)
    corners = (
        (0.02, 0.97, "left", "unstable solver"),
        (0.98, 0.97, "right", "both"),
        (0.98, 0.03, "right", "ill-posed problem"),
    )
    for x, y, side, text in corners:
        height = "top" if y > 0.5 else "bottom"
        ax.text(x, y, text, transform=ax.transAxes, ha=side, va=height, fontsize="x-small", alpha=0.8)
    log_ticks(ax, "x", {10.0**k: f"1e{k}" for k in range(-2, 7, 2)} | {SENSITIVITY[1]: "∞"})
    log_ticks(ax, "y", {10.0**k: f"1e{k}" for k in range(0, -13, -4)} | {ERROR[0]: "0"})
    ax.set_xlim(SENSITIVITY[0] / 2, SENSITIVITY[1] * 2)
    ax.set_ylim(ERROR[0] / 3, ERROR[1] * 30)
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("sensitivity of the problem")
    ax.set_ylabel("backward error of the answer")


CHART = Chart(
    name="stability",
    panels=panels,
    section="solvability",
    title="Ill-posed problem or unstable solver",
    caption="A dot is an answer at the tightest tolerance; crossed where it is not solved. High: no nearby problem has this "
    "answer, so the solver is to blame. Far to the right: a small change of the problem changes its solution a lot, so nobody "
    "is. An answer that presses ever so little on a contact that opens is exact for no change of the data, and counts as high. "
    "The sensitivity is known of small problems with a solution.",
)
