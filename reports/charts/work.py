"""Performance profiles of work: deterministic counters in place of time, which do not depend on the machine or its load.

The work of a solver on a problem is the counter at the least time within the finest target (reports.accuracy), plus one, so
that the ratio to a problem solved without work is defined. Counters of different units are not compared: a unit has a panel
with the solvers that count it on every problem. The counters of the members of a portfolio are summed.
"""

import json
from collections import Counter
from functools import partial

import pandas as pd

from frictionbench.reports.accuracy import ratios
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import draw
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.run import Run

UNITS = ("pivots", "sweeps", "iterations", "factorisations")


def panels(run: Run) -> list[Panel]:
    """A panel per unit that two or more labels count."""
    times = run.times[run.ends[-1]]
    counts = pd.DataFrame([counted(text) for text in times["work"]], index=times.index, columns=list(UNITS))
    found = []
    for unit in UNITS:
        counting = (counts[unit].notna() | ~times["reached"]).groupby(times["label"]).transform("all")
        own = times.assign(work=counts[unit].fillna(0.0) + 1.0)[counting]
        if len(set(own.loc[own["reached"], "label"])) > 1:
            across = f"{unit} over the fewest of any solver"
            found.append(Panel(unit, partial(draw, costs=ratios(own, "work"), looks=run.looks, across=across)))
    return found


def counted(text: object) -> dict[str, int]:
    """The work in a row by unit: the counter "lemke pivots" of a portfolio has the unit pivots."""
    try:
        counters = json.loads(text) if isinstance(text, str) else {}
    except (ValueError, RecursionError):
        return {}
    total: Counter[str] = Counter()
    for name, count in counters.items() if isinstance(counters, dict) else ():
        unit = name.rsplit(" ", 1)[-1]
        if unit in UNITS and isinstance(count, int):
            total[unit] += count
    return dict(total)


CHART = Chart(
    name="work",
    panels=panels,
    section="time",
    title="Performance profiles on work, within the tightest target",
    caption="As above, for deterministic counters in place of time, independent of the machine. A unit is the same work "
    "only for similar methods; an iteration of one may cost as much as ten of another. Each panel shows the solvers that count "
    "its unit on every problem.",
    columns=2,
)
