"""How every figure looks: one colour and marker per entry wherever it is drawn, readable on light and dark pages."""

from collections.abc import Iterable
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

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
    "#0077bb",
    "#e69f00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
    "#a6761d",
    "#8c6bb1",
    "#8a9a3b",
    "#e7298a",
    "#00a5a5",
    "#c49a6c",
    "#7f7f7f",
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


def plain(text: str, longest: int = 48) -> str:
    """Text a figure can hold: what the font or XML lacks replaced, cut to length, and no leading underscore, which hides
    a legend's entry."""
    latin = text.encode("latin-1", "replace").decode("latin-1")
    shown = "".join(c if c.isprintable() else "?" for c in latin)
    shown = shown if len(shown) <= longest else shown[: longest - 3] + "..."
    return " " + shown if shown.startswith("_") else shown


def seconds(value: float) -> str:
    """A time in s with a unit that suits it: 12 µs, 3.4 ms, 0.56 s."""
    if not np.isfinite(value):
        return "–"
    for scale, unit in ((1e-6, "µs"), (1e-3, "ms")):
        if abs(value) < 999.5 * scale:
            return f"{value / scale:.2g} {unit}" if abs(value) < 99.5 * scale else f"{value / scale:.0f} {unit}"
    return f"{value:.2g} s" if abs(value) < 99.5 else f"{value:.0f} s"


def power(value: float) -> str:
    """A power of ten as a reader of numbers writes it: 1e-8."""
    return f"1e{round(np.log10(value))}" if value > 0 else "0"


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
