"""Panels, and their conversion to inline SVG for the page."""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import NamedTuple

import matplotlib as mpl
from markupsafe import escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from frictionbench.reports.drawing.style import INK, ON_PAGE, RC, Look

PANEL = (3.9, 2.9)  # inches
IMAGE = 200  # dots per inch of rasterised parts, twice the resolution of usual screens


class Panel(NamedTuple):
    """One drawing on one pair of axes.

    dots: for each tag, the tooltips of its dots in the order drawn. notes: text per label, shown below the panel.
    """

    title: str
    draw: Callable[[Axes], object]
    dots: Mapping[str, Sequence[str]] = {}
    notes: Mapping[str, str] = {}


def inline_svg(panel: Panel) -> str:
    """Return the panel, without its title, as an SVG element in the text colour of the page.

    Ids of groups are removed, because a page would repeat them. Ids of labels become the attributes data-label and data-dots.
    """
    with mpl.rc_context(RC | ON_PAGE):
        figure = Figure(figsize=PANEL, layout="constrained")
        panel.draw(figure.subplots())
        return _element(figure, f'role="img" aria-label="{escape(panel.title)}"')


def distinct(svg: str, number: int) -> str:
    """Return the SVG element with its number in the page added to its ids: an id refers to the first, which may be hidden."""
    return re.sub(r'( id="|href="#|url\(#)(\w+)', rf"\1\2-{number}", svg)


@cache
def swatch(look: Look) -> str:
    """Return the line and marker of a label as a small SVG element, for the legend of the page."""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(0.34, 0.17))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.axis("off")
        ax.plot([0, 1, 2], [0, 0, 0], **look.line | {"gid": None}, markevery=[1], markersize=6)
        return _element(figure, 'aria-hidden="true"')


def _element(figure: Figure, attributes: str) -> str:
    """Return the figure as an SVG element. attributes: for accessibility."""
    text = io.StringIO()
    figure.savefig(text, format="svg", dpi=IMAGE, metadata={"Date": None})
    svg = text.getvalue()
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = re.sub(r'\s*<defs>\s*<style type="text/css">\*\{(.*?)\}</style>\s*</defs>', "", svg, count=1)  # affects the page
    svg = svg.replace("<svg", f'<svg {attributes} style="stroke-linejoin: round; stroke-linecap: butt"', 1)
    svg = re.sub(r'<g id="dots-(label-[0-9a-f]+)"', r'<g data-dots="\1"', svg)
    svg = re.sub(r'<g id="(label-[0-9a-f]+)"', r'<g data-label="\1"', svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg).replace(INK, "currentColor")
    return re.sub(r'(?<= d=")[^"]*', lambda way: re.sub(r"(\.\d)\d+|\s*\n", r"\1", way[0]), svg)  # tenths of a point suffice
