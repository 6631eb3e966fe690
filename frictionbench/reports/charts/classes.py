"""Performance profiles by the properties that make a problem difficult: number of contacts, and rank of W over its rows.

Rank deficiency is more difficult for most methods than lack of convexity (Acary, Brémond and Huber 2018).
"""

from functools import partial

import pandas as pd

from frictionbench.reports.accuracy import OVERALL, overall, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.charts.profiles import draw
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.run import Run

SIZES = {"1 to 10 contacts": (1, 10), "11 to 100": (11, 100), "101 to 1000": (101, 1000), "more than 1000": (1001, 10**12)}
RANKS = {
    "W of full rank": (1.0, 1.0),
    "rank 0.75 of the rows or more": (0.75, 1 - 1e-12),
    "rank below that": (0.0, 0.75 - 1e-12),
}
FEWEST = 2  # problems of a class that has a panel


def panels(run: Run) -> list[Panel]:
    """A panel per class, if the problems of a run belong to several classes."""
    tried = [target for target in sorted(run.times) if len(run.times[target])]
    if not tried:
        return []
    times = run.times[tried[0]]
    facts = run.ranked.groupby("problem_id")[["contacts", "rank", "dimension"]].max()
    ratio = facts["rank"] / (facts["contacts"] * facts["dimension"])
    found = []
    for dimension, where in OVERALL.items():
        for values, classes in ((facts["contacts"], SIZES), (ratio, RANKS)):
            own = values[facts["dimension"] == dimension]
            members = {name: own.index[own.between(*ends)] for name, ends in classes.items()}
            members = {f"{where}, {name}": problems for name, problems in members.items() if len(problems) >= FEWEST}
            if len(members) > 1:
                found += [_panel(name, times[times["problem_id"].isin(problems)], run) for name, problems in members.items()]
    return found


def _panel(name: str, times: pd.DataFrame, run: Run) -> Panel:
    costs = next(map(profiles, overall(times).values()), {})
    return Panel(f"{name}: {times['problem_id'].nunique()} problems", partial(draw, costs=costs, looks=run.looks))


CHART = Chart(
    name="classes",
    panels=panels,
    section="time",
    title="Performance profiles by size and by rank, within the tightest target",
    caption="Performance profiles for the problems of one class, by number of contacts and by the rank of W over its rows, "
    "which is computed for up to 600 rows.",
    columns=2,
    folded=True,
    ranked=True,
)
