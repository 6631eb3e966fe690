"""Chart of convergence histories (results.histories): the verified residual of a solver that is stopped after a number of its
iterations.
"""

from collections.abc import Iterable
from functools import partial

from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import ZERO, Look, log_ticks, name_axes, residual_axis
from frictionbench.reports.run import Run
from frictionbench.results.conventions import count, scene_title
from frictionbench.results.histories import ConvergenceHistory

WORST = 1e3  # larger residuals, of iterations that diverge, are drawn here


def panels(run: Run) -> list[Panel]:
    """Return a panel per problem with a history of two points or more, all with the same axes."""
    drawn = [history for history in run.histories if history.variant in run.looks and len(history.units) > 1]
    most = max((history.units[-1] for history in drawn), default=1)
    draw = partial(_draw, looks=run.looks, most=most)
    return [Panel(title, partial(draw, histories=same)) for title, same in by_problem(drawn).items()]


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
