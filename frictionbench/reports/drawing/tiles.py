"""A map: panels of coloured tiles over two parameters, as SVG for the page and on matplotlib's axes for a paper.

Grid points are counted in grid lines from the lower left corner. A panel on the page is written by templates/tiles.svg and not
by matplotlib: it may hold thousands of tiles with tooltips. Tiles of one colour and tooltip form one path, thresholds points.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import groupby
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from frictionbench.reports.drawing import figures
from frictionbench.reports.drawing.text import plain

LONGEST_TITLE = 38  # letters of a title; a longer one is cut
SEAM = 0.05  # width of a tile's outline, points: it closes gaps that a viewer may show between neighbours
CORNERS = (-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)  # of a unit tile
RIM = withStroke(linewidth=1.3, foreground="white")  # sets a mark off from tiles of any colour
Point = tuple[float, float]


class Tile(NamedTuple):
    """A square of `width` grid lines centred at the grid point (i, j). tooltip: text shown when the pointer hovers over it."""

    i: float
    j: float
    width: float
    colour: str
    tooltip: str = ""


class Axis(NamedTuple):
    """The name of a parameter with its unit, its ticks as pairs of grid line and text, and its number of grid lines."""

    name: str
    ticks: tuple[tuple[float, str], ...]
    grid_lines: int


class Entry(NamedTuple):
    """An entry of the legend: a name and a colour. mark: of points, matplotlib's name; empty for tiles."""

    name: str
    colour: str
    mark: str = ""


class Grid(NamedTuple):
    """What all panels of a map share: both axes, and the points of each threshold, which are drawn over the tiles."""

    x: Axis
    y: Axis
    points: Mapping[Entry, Sequence[Point]]


class Field(NamedTuple):
    """One panel. ground: the background colour; whole tiles of this colour can be left out. scale: the colours of a scale, the
    lowest first; ticks: texts at equal distances along it, from end to end."""

    title: str
    tiles: Sequence[Tile]
    ground: str = ""
    scale: Sequence[str] = ()
    ticks: Sequence[str] = ()


class Drawing(NamedTuple):
    """A map: its title, the name of its file, its legend, its grid and its panels. note: on what needs no panel. facts: data by
    which the page names the scene of a tile (see reports.charts.failure_maps)."""

    title: str
    name: str
    legend: tuple[Entry, ...]
    grid: Grid
    fields: tuple[Field, ...]
    note: str = ""
    facts: Mapping[str, object] = {}

    @property
    def panels(self) -> list[figures.Panel]:
        """The panels for matplotlib."""
        return [figures.Panel(field.title, partial(draw, field=field, grid=self.grid)) for field in self.fields]

    @property
    def handles(self) -> dict[str, Line2D | Patch]:
        """The legend for matplotlib."""
        return {one.name: _marked(one) if one.mark else Patch(fc=one.colour, ec="0.5", lw=0.4) for one in self.legend}


def draw(ax: Axes, field: Field, grid: Grid) -> None:
    """Draw a panel on matplotlib's axes."""
    ax.set(xlim=(-0.5, grid.x.grid_lines - 0.5), ylim=(-0.5, grid.y.grid_lines - 0.5), facecolor=field.ground or "none")
    for colour, same in groupby(sorted(field.tiles, key=_order), key=attrgetter("colour")):
        outlines = [[(t.i + x * t.width, t.j + y * t.width) for x, y in CORNERS] for t in same]
        ax.add_collection(PolyCollection(outlines, facecolors=colour, edgecolors=colour, linewidths=SEAM), autolim=False)
    for entry, points in grid.points.items():
        ax.add_line(_marked(entry, points))
    for axis, place, name in ((grid.x, ax.set_xticks, ax.set_xlabel), (grid.y, ax.set_yticks, ax.set_ylabel)):
        place([line for line, _ in axis.ticks], [text for _, text in axis.ticks])
        name(plain(axis.name, LONGEST_TITLE))
    if field.scale:
        bar = ax.figure.colorbar(ScalarMappable(cmap=ListedColormap(field.scale)), ax=ax)
        bar.set_ticks(np.linspace(0, 1, len(field.ticks)).tolist(), labels=field.ticks)


def _marked(entry: Entry, points: Sequence[Point] = ()) -> Line2D:
    """Return the points of a threshold as marks with a white rim."""
    size = 1.8 if entry.mark in "x+" else 4.0  # a cross fits into a ring
    x, y = np.reshape(points, (-1, 2)).T
    return Line2D(x, y, color=entry.colour, marker=entry.mark, ls="none", mfc="none", ms=size, mew=0.6, path_effects=[RIM])


def paths(tiles: Iterable[Tile]) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return, by colour and then by tooltip, the SVG path of the tiles that have both, in grid lines."""
    return [
        (colour, [(tooltip, "".join(map(_square, equal))) for tooltip, equal in groupby(same, key=attrgetter("tooltip"))])
        for colour, same in groupby(sorted(tiles, key=_order), key=attrgetter("colour"))
    ]


def _square(tile: Tile) -> str:
    return f"M{tile.i - tile.width / 2:g} {tile.j - tile.width / 2:g}h{tile.width:g}v{tile.width:g}h-{tile.width:g}z"


def _order(tile: Tile) -> tuple[float, str, str]:
    """Sort wider tiles first, so that refinements are drawn over them; then by colour and tooltip."""
    return -tile.width, tile.colour, tile.tooltip
