"""Charts of convergence histories (results.histories): the verified residual of a solver that is stopped after a number of its
iterations, and the impulses of its last answer, which a simulator that uses contact forces would obtain.
"""

from collections.abc import Iterable
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ZERO, Look, log_ticks, name_axes, residual_axis
from frictionbench.reports.run import Run
from frictionbench.results.conventions import count, scene_title
from frictionbench.results.histories import ConvergenceHistory

WORST = 1e3  # larger residuals, of iterations that diverge, are drawn here
DRAWN_BELOW = 1e-4  # residual below which an answer's impulses are drawn: their errors are then far below visibility


def panels(run: Run) -> list[Panel]:
    """Return a panel per problem with a history of two points or more, all with the same axes."""
    drawn = [history for history in run.histories if history.variant in run.looks and len(history.units) > 1]
    most = max((history.units[-1] for history in drawn), default=1)
    draw = partial(_draw, looks=run.looks, most=most)
    return [Panel(title, partial(draw, histories=same)) for title, same in by_problem(drawn).items()]


def forces(run: Run) -> list[Panel]:
    """Return a panel per redundant problem of few contacts, with the answers that solve the exact problem."""
    known = (history for history in run.histories if history.variant in run.looks and history.residuals)
    drawn = [history for history in known if history.redundant and history.impulse and history.residuals[-1] <= DRAWN_BELOW]
    return [Panel(title, partial(_draw_forces, histories=same, looks=run.looks)) for title, same in by_problem(drawn).items()]


def by_problem(histories: Iterable[ConvergenceHistory]) -> dict[str, list[ConvergenceHistory]]:
    """Return the histories on each problem, by its title."""
    grouped: dict[str, list[ConvergenceHistory]] = {}
    for history in histories:
        step = f", step {history.step}" if history.step else ""
        title = f"{scene_title(history.scene, history.parameters)}{step}: {count(history.contacts, 'contact')}"
        grouped.setdefault(title, []).append(history)
    return grouped


def _draw(ax: Axes, histories: list[ConvergenceHistory], looks: dict[str, Look], most: int) -> None:
    for history in histories:
        residuals = [min(max(value, ZERO), WORST) for value in history.residuals]
        ax.plot(history.units, residuals, **looks[history.variant].line, markevery=(0.05, 0.2))
    decades = range(len(str(most)))
    log_ticks(ax, "x", {10.0**k: f"{10**k}" for k in decades})
    residual_axis(ax)
    ax.set_xlim(0.9, 1.1 * max(most, 10))
    ax.set_ylim(ZERO / 30, WORST * 3)
    name_axes(ax, "sweeps, iterations or pivots", "verified residual")


def _draw_forces(ax: Axes, histories: list[ConvergenceHistory], looks: dict[str, Look]) -> None:
    for k, history in enumerate(histories):
        impulse = np.array(history.impulse)
        shift = 0.5 * ((k + 0.5) / len(histories) - 0.5)
        contacts = np.arange(1, len(impulse) + 1)
        ax.plot(contacts + shift, impulse[:, 0], **looks[history.variant].line | {"ls": "none"})
    most = max(len(history.impulse) for history in histories)
    ax.set_xticks(range(1, most + 1))
    ax.set_xlim(0.5, most + 0.5)
    ax.set_ylim(bottom=0)
    name_axes(ax, "contact", "normal impulse in N s", grid="y")


CHART = Chart(
    name="convergence",
    panels=panels,
    section="chart",
    title="Residual against iterations",
    caption="The verified residual of a solver that is stopped after a number of units of its own work; each point is the "
    "answer of a separate, untimed call. A unit is what the method counts, so that curves of different methods show their rate "
    "of convergence and not which one is faster. Portfolios and solvers that solve neither the problem nor their own model are "
    "left out; the curve of a relaxation levels off at its model error.",
)
FORCES = Chart(
    name="forces",
    panels=forces,
    section="solvability",
    title="Force per contact on redundant supports",
    caption="The normal impulses of answers that solve the exact problem, for the solvers of the chart of convergence. On more "
    "supports than a body needs, many distributions of the load give the same motion. Each solver returns one of them; all are "
    "correct, and none is preferred.",
)
