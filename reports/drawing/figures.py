"""Panels, and inline SVG made of them for a page."""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionbench.reports.drawing.style import INK, RC, Look

PANEL = (3.9, 2.9)  # inches
WHOLE = (5.0, 3.1)  # of a panel that stands alone
IMAGE = 200  # dots an inch of what is drawn as an image


@dataclass(frozen=True)
class Panel:
    """One drawing on one pair of axes."""

    title: str
    draw: Callable[[Axes], object]
    dots: Mapping[str, Sequence[str]] = field(default_factory=dict)  # what the dots of each tag are, in the order drawn
    size: tuple[float, float] = PANEL
    notes: Mapping[str, str] = field(default_factory=dict)  # of labels, for the panel's own legend


def inline_svg(panel: Panel) -> str:
    """The panel, without its title, as an SVG element whose ink is the page's own.

    The ids of groups are dropped, for a page holds many such elements; those of labels stay as data-label, data-dots or
    data-band.
    """
    with mpl.rc_context(RC):
        figure = Figure(figsize=panel.size, layout="constrained")
        panel.draw(figure.subplots())
        return _element(figure)


def swatch(look: Look) -> str:
    """An label's line and marker as a small SVG element, for a legend on the page."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(0.34, 0.17))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.axis("off")
        ax.plot([0, 1, 2], [0, 0, 0], **look.line | {"gid": None}, markevery=[1], markersize=6)
        return _element(figure)


def _element(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg", dpi=IMAGE, metadata={"Date": None})
    svg = text.getvalue()
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = re.sub(r'<g id="(dots|band)-(label-[0-9a-f]+)"', r'<g data-\1="\2"', svg)
    svg = re.sub(r'<g id="(label-[0-9a-f]+)"', r'<g data-label="\1"', svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg).replace(INK, "currentColor")
    return re.sub(r'(?<= d=")[^"]*', lambda way: re.sub(r"(\.\d)\d+|\s*\n", r"\1", way[0]), svg)  # tenths of a point will do
