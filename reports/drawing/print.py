"""Maps for a paper: the panels of reports.drawing.tiles as PDF, in rows over the page's width."""

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.sheets import FAMILIES
from frictionbench.reports.drawing.style import INK, RC
from frictionbench.reports.drawing.tiles import Bars, Box, Dots, Drawing, Field, Panel, Text
from frictionbench.results.files import replaced

PANELS_PER_ROW = 5  # so that letters are of some six points on a page of two columns
SEAM = 0.05  # points, the outline of a tile, which closes the gap that a viewer may show between neighbours


def save_drawing(drawing: Drawing, stem: Path, width: float, family: str) -> None:
    """Save the map as STEM.pdf, `width` inches wide; the same map always gives the same bytes."""
    across, rows = min(PANELS_PER_ROW, len(drawing.panels)), -(-len(drawing.panels) // PANELS_PER_ROW)
    scale = width / (across * tiles.WIDTH)
    with mpl.rc_context(RC | {"font.family": FAMILIES[family], "font.size": 72 * tiles.LETTERS * scale}):
        figure = Figure(figsize=(width, rows * tiles.HEIGHT * scale))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, across * tiles.WIDTH), ylim=(rows * tiles.HEIGHT, 0))
        ax.axis("off")
        for k, panel in enumerate(drawing.panels):
            draw_panel(ax, panel, k % PANELS_PER_ROW * tiles.WIDTH, k // PANELS_PER_ROW * tiles.HEIGHT, 72 * scale)
        with replaced(stem.with_name(f"{stem.name}.pdf")) as file:
            figure.savefig(file, metadata={"CreationDate": None})


def draw_panel(ax: Axes, panel: Panel, left: float, top: float, points: float) -> None:
    """Draw a panel with its upper left corner at (left, top) of the axes. points: the length of one unit of the axes."""
    place = Affine2D().translate(left, top)
    for shape in panel:
        match shape:
            case Text(x, y, text, size):
                ax.text(left + x, top + y, text, color=INK, va="baseline", fontsize=points * size)
            case Box(x, y, width, height, colour, line, radius):
                style = f"round,pad=0,rounding_size={radius}" if radius else "square,pad=0"
                box = FancyBboxPatch((x, y), width, height, boxstyle=style, transform=place + ax.transData)
                box.set(lw=points * line, ec=INK, fc=colour or "none")
                ax.add_patch(box)
            case Dots(colour, places):
                xs, ys = [left + x for x, _ in places], [top + y for _, y in places]
                ax.plot(xs, ys, "o", ms=points * tiles.DOT, mew=0, color=colour)
            case Field(columns, lines, bars):
                grid = Affine2D().scale(tiles.ACROSS / columns, -tiles.UP / lines).translate(tiles.LEFT, tiles.TOP + tiles.UP)
                for one in bars:
                    colours = {"fc": one.colour, "ec": one.colour, "lw": SEAM}
                    ax.add_patch(PathPatch(_outline(one), transform=grid + place + ax.transData, **colours))


def _outline(bars: Bars) -> Outline:
    """All bars of one colour as one path."""
    corners, codes = [], []
    for left, right, height, low in bars.bars:
        corners += [(left, low), (right, low), (right, low + height), (left, low + height), (left, low)]
        codes += [Outline.MOVETO, Outline.LINETO, Outline.LINETO, Outline.LINETO, Outline.CLOSEPOLY]
    return Outline(corners, codes)
