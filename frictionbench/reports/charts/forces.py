"""The impulse at each contact of redundant supports, by solver: if W is rank deficient, many distributions are solutions.

A body on more supports than it needs is hyperstatic: the motion and the net impulse are unique, their distribution over the
contacts is not. Distributions are not compared; the chart shows what a simulator that uses contact forces would obtain.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.convergence import by_problem
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import GRID, Look
from frictionbench.reports.run import Run
from frictionbench.results.extras import ConvergenceHistory

EXACT = 1e-4  # residual below which an answer is drawn: an order of magnitude finer than the eye sees


def panels(run: Run) -> list[Panel]:
    """A panel per redundant problem of few contacts, with the answers that solve the exact problem."""
    known = (history for history in run.histories if history.variant in run.looks and history.residuals)
    drawn = [history for history in known if history.redundant and history.impulse and history.residuals[-1] <= EXACT]
    return [Panel(title, partial(_draw, histories=own, looks=run.looks)) for title, own in by_problem(drawn).items()]


def _draw(ax: Axes, histories: list[ConvergenceHistory], looks: dict[str, Look]) -> None:
    for k, history in enumerate(histories):
        impulse = np.array(history.impulse)
        shift = 0.5 * ((k + 0.5) / len(histories) - 0.5)
        contacts = np.arange(1, len(impulse) + 1)
        ax.plot(contacts + shift, impulse[:, 0], **looks[history.variant].line | {"ls": "none"})
    ax.set_xticks(range(1, histories[0].contacts + 1))
    ax.set_xlim(0.5, histories[0].contacts + 0.5)
    largest = max(contact[0] for history in histories for contact in history.impulse)
    ax.set_ylim(0, 1.1 * largest if largest > 0 else 1.0)
    ax.grid(axis="y", **GRID)
    ax.set_xlabel("contact")
    ax.set_ylabel("normal impulse in N s")


CHART = Chart(
    name="forces",
    panels=panels,
    section="solvability",
    title="Force per contact on redundant supports",
    caption="The normal impulses of answers that solve the exact problem. On more supports than a body needs, many "
    "distributions of the load give the same motion. Each solver returns one of them; all are correct, and none is preferred.",
    columns=2,
)
