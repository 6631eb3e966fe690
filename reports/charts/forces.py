"""The force at each contact of redundant supports, by solver: where W lacks rank, many distributions move the bodies alike.

A body on more supports than it needs is hyperstatic: one motion and one net impulse come of many shares of the single
contacts. What is compared is never these shares; they show what a simulator that reads forces gets.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.convergence import by_problem
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look
from frictionbench.reports.run import Run
from frictionbench.results.convergence import ConvergenceHistory

EXACT = 1e-4  # residual


def panels(run: Run) -> list[Panel]:
    """A panel per redundant problem of few contacts, with the answers that solve it, and not the relaxation alone."""
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
    ax.grid(axis="y", lw=0.4, alpha=0.3)
    ax.set_xlabel("contact")
    ax.set_ylabel("normal impulse in N s")


CHART = Chart(
    name="forces",
    panels=panels,
    section="solvability",
    title="Force per contact on redundant supports",
    caption="The normal impulses of exact answers. With more supports than a body needs, one motion comes of many "
    "distributions of the load, and which of them is the solver's choice: none is more right, and none is compared by it.",
    columns=2,
)
