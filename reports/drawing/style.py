"""How every figure looks: one colour and marker per entry wherever it is drawn, readable on light and dark pages."""

from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from reports.drawing.text import seconds

INK = "#20242b"  # text and axes; a page replaces it by its own ink
ALARM = "#d62728"
RC: Any = {
    "font.size": 9.0,
    "font.family": "sans-serif",
    "text.color": INK,
    "text.parse_math": False,  # names come from results, which may come from strangers
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.facecolor": "none",
    "axes.titlesize": "medium",
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": "small",
    "ytick.labelsize": "small",
    "figure.facecolor": "none",
    "legend.frameon": False,
    "legend.fontsize": "small",
    "lines.linewidth": 1.1,
    "lines.markersize": 4.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "frictionbench",
    "pdf.fonttype": 42,
}
_COLOURS = (
    *("#0077bb", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#a6761d"),
    *("#8c6bb1", "#8a9a3b", "#e7298a", "#00a5a5", "#c49a6c", "#7f7f7f"),
)
_MARKERS = ("o", "s", "^", "D", "v")  # 5 and 12 are coprime: 60 looks before one repeats


class Look(NamedTuple):
    """Colour and marker of one entry."""

    colour: str
    marker: str


def looks(entries: Iterable[str]) -> dict[str, Look]:
    """A look for each entry, the same whatever the order of the rows."""
    names = sorted(set(entries))
    return {name: Look(_COLOURS[i % len(_COLOURS)], _MARKERS[i % len(_MARKERS)]) for i, name in enumerate(names)}


def time_axis(ax: Axes, which: Literal["x", "y"]) -> None:
    """A logarithmic axis of times, once all is drawn."""
    axis = _logarithmic(ax, which)
    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0,) if high > 150 * low else (1.0, 3.0), numticks=7))
    axis.set_major_formatter(FuncFormatter(lambda value, _: seconds(value)))


def log_ticks(ax: Axes, which: Literal["x", "y"], labels: dict[float, str]) -> None:
    """A logarithmic axis with ticks at the given values only."""
    _logarithmic(ax, which).set_ticks(list(labels), labels=list(labels.values()))


def _logarithmic(ax: Axes, which: Literal["x", "y"]) -> Axis:
    ax.set(**{f"{which}scale": "log"})
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_minor_locator(NullLocator())
    return axis
