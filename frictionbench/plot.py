"""The charts of the report, drawn on your matplotlib axes.

Each function takes a results folder or the result of `read_results`, the axes to draw on (by default pyplot's current ones),
and the panel, given by its title or its index from 0; `titles` lists them. A chart has a panel per target, the coarsest first,
and dimension (profiles), counter and dimension (work), problem class (speed_accuracy), scene of three sizes or more (growth),
scene and scheme (energy), or problem (convergence).
Each function returns the axes. Draw one chart per axes, since scales, ticks and legend are set.

Errors: ValueError if the run has nothing to draw, or no such panel; ResultsError if the folder cannot be read.

>>> import frictionbench as fb
>>> from matplotlib.figure import Figure
>>> fb.plot.titles("run", "energy")
['bar']
>>> ax = fb.plot.energy("run", ax=Figure().subplots())
>>> ax.get_xlabel(), ax.get_ylabel()
('time in s', 'change of energy, %')
>>> [text.get_text() for text in ax.get_legend().get_texts()]
['lemke']
"""

from pathlib import Path
from typing import Protocol

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from frictionbench.reports.charts import CHARTS
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.style import RC
from frictionbench.reports.drawing.text import plain
from frictionbench.reports.run import Run
from frictionbench.tables import Results, read_results

__all__ = ["convergence", "energy", "growth", "profiles", "speed_accuracy", "titles", "work"]


def __dir__() -> list[str]:
    return __all__


class Draw(Protocol):
    """A function that draws one chart."""

    def __call__(self, results: Results | str | Path, *, ax: Axes | None = None, panel: str | int = 0) -> Axes: ...


def _chart(name: str, shown: str) -> Draw:
    """Return the function that draws the chart of this name. shown: the beginning of its docstring."""

    def draw(results: Results | str | Path, *, ax: Axes | None = None, panel: str | int = 0) -> Axes:
        run = _run(results)
        panels = {each.title: each for each in _panels(name, run)}
        if not panels:
            raise ValueError(f"{name}: this run has nothing to draw")
        try:
            chosen = panels[panel] if isinstance(panel, str) else list(panels.values())[panel]
        except (LookupError, TypeError):
            raise ValueError(f"panel: {name} has no panel {panel!r}; it has {', '.join(panels)}") from None
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.gca()
        widths = {setting: RC[setting] for setting in ("lines.linewidth", "lines.markersize")}
        with mpl.rc_context({"text.parse_math": False} | widths):
            chosen.draw(ax)
            ax.set_title(plain(chosen.title))
            _legend(ax, run, chosen)
        return ax

    draw.__name__ = draw.__qualname__ = name
    draw.__doc__ = f"""{shown}

    results: a results folder, or what `read_results` returns. ax: by default pyplot's current axes. panel: a title of
    `titles`, or its position.

    Returns the axes. Errors: ValueError where the run has nothing to draw, or no such panel.

    >>> from matplotlib.figure import Figure
    >>> for title in titles("run", "{name}"):
    ...     axes = {name}("run", ax=Figure().subplots(), panel=title)
    """
    return draw


profiles, work, speed_accuracy, growth, energy, convergence = (
    _chart(name, shown)
    for name, shown in {
        "profiles": "Performance profiles: the weighted share of problems within a residual in tau times the least time.",
        "work": "Performance profiles on deterministic counts in place of times, within the tightest target.",
        "speed_accuracy": "Verified residual (relative contact velocity) against time (s), a line along a solver's tolerances.",
        "growth": "Time (s) to a target against the number of contacts, with fitted exponents in the legend.",
        "energy": "Change of energy over time (s) in simulations, relative to the scene's energy scale.",
        "convergence": "Verified residual against the sweeps, iterations or pivots allowed.",
    }.items()
)


def titles(results: Results | str | Path, chart: str) -> list[str]:
    """Return the titles of a chart's panels in their order; none if the run has nothing to draw.

    results: a results folder, or the result of `read_results`. chart: the name of a function of this module: "profiles",
    "work", "speed_accuracy", "growth", "energy" or "convergence".
    Errors: ValueError for another chart; ResultsError if the folder cannot be read.

    >>> import frictionbench as fb
    >>> fb.plot.titles("run", "energy")
    ['bar']
    """
    return [panel.title for panel in _panels(chart, _run(results))]


def _run(results: Results | str | Path) -> Run:
    return (results if isinstance(results, Results) else read_results(results)).run


def _panels(chart: str, run: Run) -> list[Panel]:
    if chart not in __all__ or chart not in CHARTS:
        raise ValueError(f"chart: there is no chart {chart!r}")
    return [panel for panel in CHARTS[chart].panels(run) if isinstance(panel, Panel)]


def _legend(ax: Axes, run: Run, panel: Panel) -> None:
    """Add a legend to the right of the axes; curves are identified by their group ids."""
    drawn = {str(artist.get_gid()) for artist in ax.findobj()}
    named = {name: look for name, look in run.looks.items() if {look.tag, f"dots-{look.tag}"} & drawn}
    labels = [f"{plain(name)} {panel.notes.get(name, '')}".strip() for name in named]
    lines = [Line2D([], [], **look.line) for look in named.values()]
    ax.legend(lines, labels, loc="upper left", bbox_to_anchor=(1, 1), fontsize="small", frameon=False)
