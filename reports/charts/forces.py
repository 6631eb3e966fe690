"""The force at each contact of redundant supports, by solver: where W lacks rank, many distributions move the bodies alike.

A body on more supports than it needs is hyperstatic: one motion and one net impulse come of many shares of the single
contacts. What is compared is never these shares; they show what a simulator that reads forces gets.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.courses import by_problem
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look
from frictionbench.reports.run import Run
from frictionbench.results.courses import Course

EXACT = 1e-4  # residual


def panels(run: Run) -> list[Panel]:
    """A panel per redundant problem of few contacts, with the answers that solve it, and not the relaxation alone."""
    known = (course for course in run.courses if course.variant in run.looks and course.residuals)
    drawn = [course for course in known if course.redundant and course.impulse and course.residuals[-1] <= EXACT]
    return [Panel(title, partial(_draw, courses=own, looks=run.looks)) for title, own in by_problem(drawn).items()]


def _draw(ax: Axes, courses: list[Course], looks: dict[str, Look]) -> None:
    for k, course in enumerate(courses):
        impulse = np.array(course.impulse)
        shift = 0.5 * ((k + 0.5) / len(courses) - 0.5)
        contacts = np.arange(1, len(impulse) + 1)
        ax.plot(contacts + shift, impulse[:, 0], **looks[course.variant].line | {"ls": "none"})
    ax.set_xticks(range(1, courses[0].contacts + 1))
    ax.set_xlim(0.5, courses[0].contacts + 0.5)
    largest = max(contact[0] for course in courses for contact in course.impulse)
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
