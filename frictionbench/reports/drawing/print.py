"""Maps for a paper: the panels of reports.drawing.tiles as PDF and PGF, in rows over the page's width.

What does not fit on a page is split over several files, so that a map of many solvers is continued on the next page.
"""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.sheets import FAMILIES, PGF, Escape, save_pgf
from frictionbench.reports.drawing.style import INK, RC
from frictionbench.reports.drawing.tiles import Bars, Box, Drawing, Field, Line, Panel, Text
from frictionbench.results.files import replaced

PANELS_PER_ROW = 4  # so that letters are of some six points on a page of two columns
SEAM = 0.05  # points, the outline of a tile, which closes the gap that a viewer may show between neighbours


def pages(drawing: Drawing, width: float, height: float) -> list[tuple[Panel, ...]]:
    """The panels and the legend in parts that fit into so many inches; the legend stands at the end of the first part."""
    across = min(PANELS_PER_ROW, len(drawing.panels) + 1)
    rows = max(1, int(height / (width / across * tiles.HEIGHT / tiles.WIDTH)))
    most = across * rows
    first, rest = drawing.panels[: most - 1], drawing.panels[most - 1 :]
    return [(*first, tiles.legend(drawing.legend)), *(rest[k : k + most] for k in range(0, len(rest), most))]


def save_panels(panels: Sequence[Panel], stem: Path, width: float, family: str, escape: Escape | None = None) -> None:
    """Save panels as STEM.pdf, `width` inches wide, and as STEM.pgf if `escape` is given; equal panels give equal bytes."""
    across, rows = min(PANELS_PER_ROW, len(panels)), -(-len(panels) // PANELS_PER_ROW)
    scale = width / (across * tiles.WIDTH)
    with mpl.rc_context(RC | PGF | {"font.family": FAMILIES[family], "font.size": 72 * tiles.LETTERS * scale}):
        figure = Figure(figsize=(width, rows * tiles.HEIGHT * scale))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, across * tiles.WIDTH), ylim=(rows * tiles.HEIGHT, 0))
        ax.axis("off")
        for k, panel in enumerate(panels):
            draw_panel(ax, panel, k % PANELS_PER_ROW * tiles.WIDTH, k // PANELS_PER_ROW * tiles.HEIGHT, 72 * scale)
        with replaced(stem.with_name(f"{stem.name}.pdf")) as file:
            figure.savefig(file, metadata={"CreationDate": None})
        if escape:
            save_pgf(figure, stem, escape)


def draw_panel(ax: Axes, panel: Panel, left: float, top: float, points: float) -> None:
    """Draw a panel with its upper left corner at (left, top) of the axes. points: the length of one unit of the axes."""
    place = Affine2D().translate(left, top)
    for shape in panel:
        match shape:
            case Text(x, y, text, anchor):
                side = {"start": "left", "middle": "center", "end": "right"}[anchor]
                ax.text(left + x, top + y, text, color=INK, va="baseline", ha=side, fontsize=points * tiles.LETTERS)
            case Box(x, y, width, height, colour, line):
                box = Rectangle((x, y), width, height, transform=place + ax.transData)
                box.set(lw=points * line, ec=INK, fc=colour or "none")
                ax.add_patch(box)
            case Line(colour, places, line, dashed):
                xs, ys = [left + x for x, _ in places], [top + y for _, y in places]
                if colour and not dashed:
                    ax.plot(xs, ys, lw=2.2 * points * line, color="white", solid_capstyle="round")
                style = (0, (1.5, 2.5)) if dashed else "-"
                ax.plot(xs, ys, lw=points * line, color=colour or INK, ls=style, solid_capstyle="round")
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
