"""Performance profiles of work: deterministic counters in place of time, which do not depend on the machine or its load.

The work of a solver on a problem is the counter at the least time within the finest target (reports.accuracy), plus one, so
that the ratio to a problem solved without work is defined. Counters of different units are not compared: a unit has a panel
with the solvers that count it on every problem. The counters of the members of a portfolio are summed.
"""

from collections import Counter
from functools import partial

import pandas as pd

from frictionbench.reports.accuracy import overall, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import draw
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import Look
from frictionbench.reports.run import Run
from frictionbench.results.cells import counts

UNITS = ("pivots", "sweeps", "iterations", "factorisations")


def panels(run: Run) -> list[Panel]:
    """A panel per dimension and unit that two or more labels count."""
    every = overall(run.times[run.outer_targets[-1]])
    return [panel for where, times in every.items() for panel in _of(where, times, run.looks)]


def _of(where: str, times: pd.DataFrame, looks: dict[str, Look]) -> list[Panel]:
    units = pd.DataFrame([counted(text) for text in times["work"]], index=times.index, columns=list(UNITS))
    found = []
    for unit in UNITS:
        counting = (units[unit].notna() | ~times["reached"]).groupby(times["label"]).transform("all")
        own = times.assign(work=units[unit].fillna(0.0) + 1.0)[counting]
        if len(set(own.loc[own["reached"], "label"])) > 1:
            across = f"{unit} over the fewest of any solver"
            found.append(Panel(f"{where}, {unit}", partial(draw, costs=profiles(own, "work"), looks=looks, across=across)))
    return found


def counted(text: object) -> dict[str, int]:
    """The work in a row by unit: the counter "lemke pivots" of a portfolio has the unit pivots."""
    total: Counter[str] = Counter()
    for name, count in counts(text).items():
        unit = name.rsplit(" ", 1)[-1]
        if unit in UNITS:
            total[unit] += count
    return dict(total)


CHART = Chart(
    name="work",
    panels=panels,
    section="time",
    title="Performance profiles on work, within the tightest target",
    caption="Performance profiles on deterministic counters in place of time, which do not depend on the machine. A unit is "
    "the same work only for similar methods; an iteration of one may cost as much as ten of another. Each panel shows the "
    "solvers that count its unit on every problem.",
    columns=2,
)
