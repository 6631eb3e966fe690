"""The style of all figures: one colour and marker per label in every figure, readable on light and dark pages."""

import re
from collections.abc import Iterable
from hashlib import sha256
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.colors import to_hex, to_rgb
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator, PercentFormatter

from frictionbench.reports.drawing.text import seconds

INK = "#20242b"  # text and axes; the page replaces it by its text colour
ALARM = "#d62728"
NARROW = 5.0  # least ratio of the ends of a time axis, so that it has two ticks or more
ZERO, WORST = 1e-17, 1e1  # positions of residuals of zero, and of large or missing ones
GRID: Any = {"lw": 0.4, "alpha": 0.3}  # style of grid lines
RC: Any = {
    "font.size": 9.0,
    "font.family": "sans-serif",
    "text.color": INK,
    "text.parse_math": False,  # names may come from untrusted results
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
# On the page a panel is at least 340 px wide. The size of most words, 9.2 points, is then 11 px.
ON_PAGE: Any = {"font.size": 11.0, "axes.labelsize": "small", "axes.titlesize": "small"}
COLOURS = (
    *("#0077bb", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#a6761d"),
    *("#8c6bb1", "#8a9a3b", "#e7298a", "#00a5a5", "#c49a6c", "#7f7f7f"),
)
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p", "<", ">", "h")  # 11 and 12 are coprime
_TINTS = (0.25, 0.4)  # share of white in the colours of variants, or of black if the solver's own colour is light
_LIGHT = 0.6  # mean of the red, green and blue of a light colour, weighted as greyscale does
_DASHES = ("-", "--", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)))
# A solver's position in the cycles is fixed, so that it looks the same in every report; other positions come from a hash.
_PLACES = (
    *("hybrid", "interior_point", "lemke", "path_search", "nsgs", "apgd_coulomb", "proximal_newton", "osqp", "siconos"),
    *("clarabel", "proxsuite", "admm_coulomb", "relaxation_ip", "ccp", "apgd", "admm", "nncg", "staggered", "anitescu_hart"),
    *("fischer_newton", "minmap_newton", "murty", "dantzig"),
)


class Look(NamedTuple):
    """Colour, marker and dash of one label; dashes distinguish lines in greyscale. tag: the identifier in drawings."""

    colour: str
    marker: str
    dash: Any
    tag: str

    @property
    def line(self) -> dict[str, Any]:
        """Keyword arguments for plotting its lines."""
        return {"color": self.colour, "marker": self.marker, "ls": self.dash, "gid": self.tag}


def looks(labels: Iterable[str]) -> dict[str, Look]:
    """Return a look for each label, which depends on its name and is therefore the same in every report. If two labels have the
    same marker and colour, or the same marker and dash, by which lines differ in greyscale, the later one gets others. A
    variant has a lighter tint of its solver's colour, or a darker one if that is light, to differ in greyscale, too."""
    looks_by_label: dict[str, Look] = {}
    for label in sorted(set(labels), key=lambda label: (_solver(label) not in _PLACES, label)):
        place, shift = _place(label)
        marks = [look[1:3] for look in [*looks_by_label.values()][1 - len(_MARKERS) * len(_DASHES) :]]
        dots = [look[:2] for look in looks_by_label.values()]
        used = {look.colour for look in looks_by_label.values()}
        each = [
            (colour, *_mark(place + k, shift + j))
            for k in range(len(COLOURS))
            for colour in sorted(_tints(COLOURS[(place + k) % len(COLOURS)], shift), key=used.__contains__)
            for j in range(len(_MARKERS) * len(_DASHES))
        ]
        drawn = next((one for one in each if one[1:] not in marks and one[:2] not in dots), each[0])
        looks_by_label[label] = Look(*drawn, f"label-{_number(label):x}")
    return dict(sorted(looks_by_label.items()))


def _solver(label: str) -> str:
    return re.split(r"[\[,*]| on ", label, maxsplit=1)[0]


def _place(label: str) -> tuple[int, int]:
    """Return the solver's position, which determines its colour, and the variant's shift in the cycles of marks and dashes."""
    solver = _solver(label)
    place = _PLACES.index(solver) if solver in _PLACES else len(_PLACES) + _number(solver)
    return place, _number(label) if label.rstrip("*") != solver else 0


def _mark(place: int, shift: int) -> tuple[str, Any]:
    other = place // len(COLOURS) + place + shift
    return _MARKERS[other % len(_MARKERS)], _DASHES[other % len(_DASHES)]


def _tints(colour: str, shift: int) -> list[str]:
    """Return the colours of a solver, its own, or of a variant, the one that its shift selects first."""
    own = np.array(to_rgb(colour))
    other = float(own @ (0.299, 0.587, 0.114) < _LIGHT)
    tints = [to_hex(tuple((1 - share) * own + share * other)) for share in _TINTS]
    return tints[:: -1 if shift % 2 else 1] if shift else [colour]


def _number(text: str) -> int:
    return int(sha256(text.encode("utf-8", "replace")).hexdigest()[:8], 16)


def time_axis(ax: Axes, which: Literal["x", "y"]) -> None:
    """Make an axis a logarithmic axis of times, after everything is drawn."""
    axis = _logarithmic(ax, which)
    low, high = axis.get_view_interval()
    if high < NARROW * low:  # widen it for two ticks or more
        low, high = np.sqrt(low * high / NARROW), np.sqrt(low * high * NARROW)
        axis.set_view_interval(low, high, ignore=True)
    subs = (1.0,) if high > 150 * low else (1.0, 3.0) if high > 12 * low else (1.0, 2.0, 5.0)
    axis.set_major_locator(LogLocator(subs=subs, numticks=4 if which == "x" else 7))
    axis.set_major_formatter(FuncFormatter(lambda value, _: seconds(value)))


def name_axes(ax: Axes, across: str, up: str, grid: Literal["both", "x", "y"] = "both") -> None:
    """Name both axes, and draw grid lines."""
    ax.set(xlabel=across, ylabel=up)
    ax.grid(axis=grid, **GRID)


def share_axis(ax: Axes, across: str) -> None:
    """Make the vertical axis one of the share of the problems, from none to all. across: the name of the horizontal axis."""
    ax.set_ylim(-0.03, 1.03)  # leaves room for markers
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    name_axes(ax, across, "share of the problems")


def residual_axis(ax: Axes, lowest: float = ZERO) -> None:
    """Make the vertical axis one of residuals, with a tick every four decades down to `lowest`; ZERO is labelled 0."""
    ticks = {10.0**k: f"1e{k}" for k in range(0, -13, -4) if 10.0**k >= lowest}
    log_ticks(ax, "y", ticks | {ZERO: "0"} if lowest <= ZERO else ticks)


def log_ticks(ax: Axes, which: Literal["x", "y"], labels: dict[float, str]) -> None:
    """Make an axis logarithmic, with ticks at the given values only."""
    _logarithmic(ax, which).set_ticks(list(labels), labels=list(labels.values()))


def _logarithmic(ax: Axes, which: Literal["x", "y"]) -> Axis:
    ax.set(**{f"{which}scale": "log"})
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_minor_locator(NullLocator())
    return axis
