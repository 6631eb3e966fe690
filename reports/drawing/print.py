"""Maps for a paper: the SVG of reports.drawing.tiles drawn again as PDF, panels in rows over the page's width.

It reads what tiles writes and no more: texts, rectangles, paths of M, H, v and h, and groups that are moved and scaled.
"""

import re
from pathlib import Path
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path as Way
from matplotlib.transforms import Affine2D, Transform

from frictionbench.reports.drawing.sheets import FAMILIES
from frictionbench.reports.drawing.style import INK, RC
from frictionbench.reports.drawing.tiles import HEIGHT, WIDTH, Drawing
from frictionbench.results.files import replaced

IN_A_ROW = 5  # panels, so that letters are of some six points
LETTERS = 7.0  # units high


def save_drawing(drawing: Drawing, stem: Path, width: float, family: str) -> None:
    """Save the map as STEM.pdf, so many inches wide, the same byte for byte from the same map."""
    across, rows = min(IN_A_ROW, len(drawing.panels)), -(-len(drawing.panels) // IN_A_ROW)
    scale = width / (across * WIDTH)
    with mpl.rc_context(RC | {"font.family": FAMILIES[family], "font.size": 72 * LETTERS * scale}):
        figure = Figure(figsize=(width, rows * HEIGHT * scale))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, across * WIDTH), ylim=(rows * HEIGHT, 0))
        ax.axis("off")
        for k, panel in enumerate(drawing.panels):
            draw_panel(ax, panel, k % IN_A_ROW * WIDTH, k // IN_A_ROW * HEIGHT, 72 * scale)
        with replaced(stem.with_name(f"{stem.name}.pdf")) as file:
            figure.savefig(file, metadata={"CreationDate": None})


def draw_panel(ax: Axes, panel: str, x: float, y: float, points: float) -> None:
    """Draw a panel with its upper left corner at x, y. points: of one of the axes' units."""
    _draw(ax, ElementTree.fromstring(f"<g>{panel}</g>"), Affine2D().translate(x, y), points, "none")  # our own


def _draw(ax: Axes, group: ElementTree.Element, place: Transform, points: float, fill: str) -> None:
    """Draw what is in a group. place: its units in the axes'; fill: its own colour."""
    for element in group:
        at, colour = place + ax.transData, element.get("fill", fill)
        if element.tag == "g":
            _draw(ax, element, _moved(element) + place, points, colour)
        elif element.tag == "text":
            x, y = place.transform((float(element.get("x", 0)), float(element.get("y", 0))))
            size = points * float(element.get("font-size", LETTERS))
            ax.text(x, y, element.text or "", color=INK, va="baseline", fontsize=size)
        elif element.tag == "rect":
            x, y, w, h, corner = (float(element.get(name, 0)) for name in ("x", "y", "width", "height", "rx"))
            style = f"round,pad=0,rounding_size={corner}" if corner else "square,pad=0"
            line = points * float(element.get("stroke-width", 0))
            ax.add_patch(FancyBboxPatch((x, y), w, h, boxstyle=style, transform=at, lw=line, ec=INK, fc=colour))
        elif element.tag == "path" and element.get("stroke"):
            dots = [tuple(map(float, pair)) for pair in re.findall(r"M(\S+) (\S+)h0", element.get("d", ""))]
            size = points * float(element.get("stroke-width", 1))
            ax.plot(*place.transform(np.reshape(dots, (-1, 2))).T, "o", ms=size, mew=0, color=element.get("stroke"))
        elif element.tag == "path":
            ax.add_patch(PathPatch(_way(element.get("d", "")), transform=at, fc=colour, ec=colour, lw=0.05))


def _moved(group: ElementTree.Element) -> Affine2D:
    told = dict(re.findall(r"(translate|scale)\(([^)]*)\)", group.get("transform", "")))
    scale, move = (list(map(float, told.get(name, usual).split())) for name, usual in (("scale", "1 1"), ("translate", "0 0")))
    return Affine2D().scale(*scale).translate(*move)


def _way(text: str) -> Way:
    """Bars, each M x y H to v height H back z."""
    corners, codes = [], []
    for x, y, end, height in re.findall(r"M(\S+) (\S+?)H([^v]+)v([^H]+)H[^z]+z", text):
        a, b, c, d = float(x), float(y), float(end), float(y) + float(height)
        corners += [(a, b), (c, b), (c, d), (a, d), (a, b)]
        codes += [Way.MOVETO, Way.LINETO, Way.LINETO, Way.LINETO, Way.CLOSEPOLY]
    return Way(corners, codes)
