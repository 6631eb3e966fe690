"""Performance profiles on work: like those on time, of deterministic counts, which no machine and no neighbour disturbs.

Of each problem an label's work is the count at the least time within the finest target (reports.accuracy); with one added,
so that a problem solved without any has a ratio. Counts of different units are not compared, so each unit has a panel, with
the labels that count it on every problem; what a portfolio's members counted is summed.
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
    """A panel per unit that two labels or more count."""
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
    """The work in a row by unit: "lemke pivots" of a portfolio is pivots."""
    try:
        told = json.loads(text) if isinstance(text, str) else {}
    except (ValueError, RecursionError):
        return {}
    total: Counter[str] = Counter()
    for name, count in told.items() if isinstance(told, dict) else ():
        unit = name.rsplit(" ", 1)[-1]
        if unit in UNITS and isinstance(count, int):
            total[unit] += count
    return dict(total)


CHART = Chart(
    name="work",
    panels=panels,
    section="time",
    title="Performance profiles on work, within the tightest target",
    caption="As above, for deterministic counts in place of time: no machine changes them. A unit is the same work only for "
    "methods of a kind; an iteration of one may cost ten of another's. A panel has those that count its unit on every problem.",
    columns=2,
)
