"""Performance profiles of Dolan and Moré (2002) with bootstrap bands: the weighted share of problems within tau times
the least time.

The band contains 95 % of the profiles of bootstrap samples of the problems (reports.accuracy.Profile). Where the bands of two
solvers overlap, a different choice of problems of the same kind may rank them the other way round.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes

from frictionbench.reports.accuracy import Array, Profile, overall, profiles
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import GRID, Look, log_ticks, share_axis
from frictionbench.reports.drawing.text import power
from frictionbench.reports.run import Run

FARTHEST = 1e3  # ratio to the fastest at the right edge: three decades
POINTS = 61  # of a band, 20 per decade
STEPS = 160  # of a curve, finer than the resolution of a panel


def panels(run: Run) -> list[Panel]:
    """A panel per target and dimension."""
    return [
        Panel(f"{where}, within {power(target)}", partial(draw, costs=profiles(times), looks=run.looks))
        for target, every in run.times.items()
        for where, times in overall(every).items()
    ]


def draw(
    ax: Axes, costs: dict[str, Profile], looks: dict[str, Look], across: str = "time over the fastest solver's time"
) -> None:
    """Draw the profiles. costs: of each label, over the least cost, see reports.accuracy.profiles."""
    at = np.geomspace(1, FARTHEST, POINTS)
    for label, profile in costs.items():
        look, (reached, share) = looks[label], steps(profile, FARTHEST)
        x, y = [1.0, *reached, FARTHEST], [0.0, *share]
        ax.step(x, [*y, y[-1]], where="post", **look.line, markevery=(0.1, 0.15))
        ax.fill_between(at, *profile.band(at), color=look.colour, alpha=0.13, lw=0, gid=f"band-{look.tag}")
    log_ticks(ax, "x", {10.0**k: f"{10**k}" for k in range(4)})
    ax.set_xlim(1, FARTHEST)
    share_axis(ax)
    ax.grid(**GRID)
    ax.set_xlabel(across)


def steps(profile: Profile, farthest: float) -> tuple[Array, Array]:
    """The costs up to the farthest with the share of the problems within each, thinned to STEPS."""
    cost = profile.cost[profile.cost <= farthest]
    keep = np.unique(np.linspace(0, len(cost) - 1, min(len(cost), STEPS)).astype(int))
    return cost[keep], profile.share(cost[keep])


CHART = Chart(
    name="profiles",
    panels=panels,
    section="time",
    title="Performance profiles",
    ranked=True,
    caption="The weighted share of all ranked problems, the same for all solvers, solved to the target within tau times the "
    "time of the fastest solver on the problem. At tau = 1, the left edge, the share on which a solver is the fastest; at the "
    "right edge, the share that it solves at all. Bands, of the best few or of those chosen: 95 % bootstrap bands over the "
    "problems.",
    columns=2,
)
