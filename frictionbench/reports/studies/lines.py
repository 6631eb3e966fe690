"""Curves that differ by colour, marker and dash, with a legend beside or inside the axes."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from numpy.typing import ArrayLike

from frictionbench.reports.drawing.style import GRID
from frictionbench.reports.drawing.text import plain

COLOURS = ("#0077bb", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#a6761d", "#8c6bb1", "#7f7f7f")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p")
_DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), "-", "--", "-.")


def curve(ax: Axes, k: int, x: ArrayLike, y: ArrayLike, label: str = "", **more: Any) -> None:
    """The k-th curve of a panel."""
    look = {"color": COLOURS[k % 8], "marker": _MARKERS[k % 8], "ls": _DASHES[k % 8], "ms": 3.5} | more
    ax.plot(x, y, label=plain(label) if label else "_", **look)


def finish(ax: Axes, x: str, y: str, logarithmic: str = "", **more: Any) -> None:
    """Labels, grid and legend; logarithmic: "x", "y", "xy" or none."""
    ax.set(xlabel=x, ylabel=y, **{f"{axis}scale": "log" for axis in logarithmic}, **more)
    for axis in (getattr(ax, f"{axis}axis") for axis in logarithmic):
        low, high = axis.get_view_interval()
        subs = (1.0,) if high > 90 * low else (1.0, 2.0, 5.0)
        axis.set_major_locator(LogLocator(subs=subs, numticks=7))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_locator(NullLocator())
    ax.grid(**GRID)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="x-small")
