"""Residual against work: what a solver has when it is stopped after so many of its own iterations, on a few problems.

Each point is an answer of a call of its own with that limit, outside all timing, verified like any other (results.courses).
"""

from collections.abc import Iterable
from functools import partial

from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look, log_ticks
from frictionbench.reports.drawing.text import scene_title
from frictionbench.reports.run import Run
from frictionbench.results.courses import Course

ZERO, WORST = 1e-17, 1e3  # what the axis shows of a residual; beyond is drawn at the edge


def panels(run: Run) -> list[Panel]:
    """A panel per problem on which a solver was followed over two limits or more, all on the same axes."""
    drawn = [course for course in run.courses if course.variant in run.looks and len(course.units) > 1]
    most = max((course.units[-1] for course in drawn), default=1)
    return [Panel(title, partial(_draw, courses=own, looks=run.looks, most=most)) for title, own in by_problem(drawn).items()]


def by_problem(courses: Iterable[Course]) -> dict[str, list[Course]]:
    """The courses on each problem, by its title."""
    found: dict[str, list[Course]] = {}
    for course in courses:
        step = f", step {course.step}" if course.step else ""
        title = f"{scene_title(course.scene, course.parameters)}{step}: {course.contacts} contact{'s' * (course.contacts != 1)}"
        found.setdefault(title, []).append(course)
    return found


def _draw(ax: Axes, courses: list[Course], looks: dict[str, Look], most: int) -> None:
    for course in courses:
        residuals = [min(max(value, ZERO), WORST) for value in course.residuals]
        ax.plot(course.units, residuals, **looks[course.variant].line, markevery=(0.05, 0.2))
    decades = range(len(str(most)))
    log_ticks(ax, "x", {10.0**k: f"{10**k}" for k in decades})
    log_ticks(ax, "y", {10.0**k: f"1e{k}" for k in range(0, -13, -4)} | {ZERO: "0"})
    ax.set_xlim(0.9, 1.1 * max(most, 10))
    ax.set_ylim(ZERO / 3, WORST * 3)
    ax.grid(lw=0.4, alpha=0.3)
    ax.set_xlabel("sweeps, iterations or pivots allowed")
    ax.set_ylabel("verified residual")


CHART = Chart(
    name="courses",
    panels=panels,
    section="chart",
    title="Residual against iterations",
    caption="What a solver has when it is stopped after so many units of its own work: each point is the answer of a call of "
    "its own, made apart from all timing, and verified. A unit is what the method counts, so that curves of unlike methods "
    "show how they come down, and not who is faster. Portfolios are left out, and who does not solve the problem.",
    columns=2,
)
