"""Performance profiles of Dolan and Moré (2002): the weighted share of problems within tau times the least time of any solver.

Further charts show the share within a time, which does not depend on the other solvers, and profiles of deterministic counters
instead of time, which do not depend on the machine.

The work of a solver on a problem is the counter at the least time within the tightest target (reports.accuracy), plus one, so
that ratios are defined if a solver needs no work. Counters of different units are not compared: each unit has a panel with the
solvers that count it on every problem. The members of a portfolio count different units, so that it has no place.
"""

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from frictionbench.reports.accuracy import Profile, overall, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import INK, Look, log_ticks, share_axis, time_axis
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import PORTFOLIO, Run
from frictionbench.results.cells import counts

STEPS = 160  # steps of a curve: finer than the resolution of a panel
UNITS = ("pivots", "sweeps", "iterations", "factorisations")


def panels(run: Run) -> list[Panel]:
    """Return a panel per target and dimension that some solver reaches."""
    return [Panel(title, partial(_draw, costs=profiles(times), looks=run.looks)) for title, times in _by_target(run)]


def within_time(run: Run) -> list[Panel]:
    """Return a panel per target and dimension that some solver reaches."""
    draw = partial(_draw_within, looks=run.looks, budget=run.budget)
    return [Panel(title, partial(draw, costs=profiles(times, relative=False))) for title, times in _by_target(run)]


def _by_target(run: Run) -> list[tuple[str, pd.DataFrame]]:
    parts = [(where, target, times) for target, every in run.times.items() for where, times in overall(every).items()]
    parts.sort(key=lambda part: run.overall.index(part[0]))
    return [(f"{where}, within {power(target)}", times) for where, target, times in parts if times["reached"].any()]


def work(run: Run) -> list[Panel]:
    """Return a panel per dimension and unit that two or more labels count."""
    panels = []
    for where, times in overall(run.times[run.outer_targets[-1]]).items():
        single = ~times["label"].str.contains(PORTFOLIO, regex=False)
        units = pd.DataFrame(map(counts, times["work"]), index=times.index, columns=list(UNITS))
        for unit in UNITS:
            counting = (units[unit].notna() | ~times["reached"]).groupby(times["label"]).transform("all")
            own = times.assign(work=units[unit].fillna(0.0) + 1.0)[counting & single]
            if len(set(own.loc[own["reached"], "label"])) > 1:
                draw = partial(_draw, costs=profiles(own, "work"), looks=run.looks)
                panels.append(Panel(f"{where}, {unit}", partial(draw, across=f"{unit} over the fewest")))
    return panels


def _draw(ax: Axes, costs: dict[str, Profile], looks: dict[str, Look], across: str = "time over the fastest") -> None:
    """Draw the profiles. costs: each label's, relative to the least cost, see reports.accuracy.profiles."""
    decades = max(1, int(np.ceil(np.log10(_draw_shares(ax, costs, looks)))))
    log_ticks(ax, "x", {10.0**k: f"{10**k}" if k < 4 else f"1e{k}" for k in range(0, decades + 1, 1 + decades // 5)})
    ax.set_xlim(1, 10**decades)
    share_axis(ax, across)


def _draw_within(ax: Axes, costs: dict[str, Profile], looks: dict[str, Look], budget: float | None) -> None:
    _draw_shares(ax, costs, looks)
    if budget is not None:
        ax.axvline(budget, color=INK, lw=0.8, alpha=0.6)
    share_axis(ax, "time for each problem")
    time_axis(ax, "x")


def _draw_shares(ax: Axes, costs: dict[str, Profile], looks: dict[str, Look]) -> float:
    """Draw the share of the problems within each cost, from the least to the largest of all labels, and return the largest."""
    every = np.unique(np.concatenate([profile.cost[np.isfinite(profile.cost)] for profile in costs.values()]))
    for label, profile in costs.items():
        own = profile.cost[np.isfinite(profile.cost)]
        keep = np.unique(np.linspace(0, len(own) - 1, min(len(own), STEPS)).astype(int))
        at = np.r_[every[0], own[keep], every[-1]]
        ax.step(at, profile.share(at), where="post", **looks[label].line, markevery=(0.1, 0.15))
    return float(every[-1])


CHART = Chart(
    name="profiles",
    panels=panels,
    section="time",
    title="Performance profiles",
    ranked=True,
    caption="The weighted share of all ranked problems, the same for all solvers, solved to the target within a multiple of "
    "the time of the fastest solver shown on the problem. At 1, the left edge, the share on which a solver is the fastest; at "
    "the right end of its line, the share that it solves at all.",
)
WORK = Chart(
    name="work",
    panels=work,
    section="time",
    title="Performance profiles on work, within the tightest target",
    caption="Performance profiles on deterministic counters in place of time, which do not depend on the machine. A unit is "
    "the same work only for similar methods; an iteration of one may cost as much as ten of another. Each panel shows the "
    "solvers that count its unit on every problem; portfolios, whose members count different units, are left out.",
)
WITHIN = Chart(
    name="budget",
    panels=within_time,
    section="time",
    title="Solved against time",
    ranked=True,
    caption="The weighted share of all ranked problems that a solver solves to the target if each is given that time, "
    "for example the time available for a time step. Unlike a performance profile it does not depend on the other solvers.",
)
