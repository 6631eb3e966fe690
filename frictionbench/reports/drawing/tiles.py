"""A map: panels of coloured tiles over two parameters, as SVG for the page and on matplotlib's axes for a paper.

Grid points are counted in grid lines from the lower left corner. A panel on the page is WIDTH x HEIGHT units with its origin at
the upper left; its field of tiles is ACROSS x UP of them. It is written here and not by matplotlib, because it may hold
thousands of tiles, each with its tooltip: neighbours of one colour and tooltip are joined to one bar.

`polylines` joins points that were found in no order along a line, such as the crossings of a threshold with the grid.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import groupby
from math import dist
from typing import NamedTuple

from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from frictionbench.reports.drawing import figures
from frictionbench.reports.drawing.text import plain

WIDTH, HEIGHT = 158.0, 142.0
LEFT, TOP, ACROSS, UP = 30.0, 22.0, 120.0, 96.0  # of the field of tiles
LETTERS = 7.2  # font size
LONGEST = 38  # letters of a title; a longer one is cut
FEW = 6  # panels of a map that are drawn large
SEAM = 0.05  # points, the outline of a tile, which closes the gap that a viewer may show between neighbours
REACH = 1.5  # grid lines: neighbours on a curve that crosses all lines of the grid are at most a diagonal, 1.41, apart
CURVE, TICK, HALO = 1.3, 0.5, 2.9  # widths of lines on the page, twice those in print; HALO: the white one below a curve
DASHES = 3.3, 4.6  # of every other curve, so that two that coincide are both seen
Point = tuple[float, float]


class Tile(NamedTuple):
    """A square of `width` grid lines centred at the grid point (i, j). tooltip: text shown when the pointer hovers over it."""

    i: float
    j: float
    width: float
    colour: str
    tooltip: str = ""


class Bar(NamedTuple):
    """Tiles of one colour and tooltip, neighbours joined: its sides, in grid lines."""

    colour: str
    tooltip: str
    left: float
    right: float
    low: float
    high: float


class Axis(NamedTuple):
    """The name of a parameter with its unit, its ticks, each a grid line and a text, and its number of grid lines."""

    name: str
    ticks: tuple[tuple[float, str], ...]
    grid_lines: int


class Grid(NamedTuple):
    """What the panels of a map have in common: both axes, and by colour the lines drawn over the tiles, through grid points."""

    x: Axis
    y: Axis
    lines: Mapping[str, Sequence[Sequence[Point]]]


class Field(NamedTuple):
    """One panel. ground: the colour of the field, so that its whole tiles can be left out."""

    title: str
    tiles: Sequence[Tile]
    ground: str = ""


class Entry(NamedTuple):
    """An entry of the legend: a name and its colour, of a line or of tiles."""

    name: str
    colour: str
    line: bool = False
    dashed: bool = False


class Drawing(NamedTuple):
    """A map: its title, the name of its file, its legend, its grid, its panels, a note on what needs no panel, and the facts by
    which a reader finds what a tile stands for (see reports.charts.failure_maps)."""

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
        return {
            name: Line2D([], [], color=colour, ls="--" if dashed else "-") if line else Patch(fc=colour, ec="0.5", lw=0.4)
            for name, colour, line, dashed in self.legend
        }


def draw(ax: Axes, field: Field, grid: Grid) -> None:
    """Draw a panel on matplotlib's axes."""
    ax.set(xlim=(-0.5, grid.x.grid_lines - 0.5), ylim=(-0.5, grid.y.grid_lines - 0.5), facecolor=field.ground or "none")
    for colour, bars in groupby(joined(field.tiles), key=lambda bar: bar.colour):
        outlines = [((b.left, b.low), (b.right, b.low), (b.right, b.high), (b.left, b.high)) for b in bars]
        ax.add_collection(PolyCollection(outlines, facecolors=colour, edgecolors=colour, linewidths=SEAM), autolim=False)
    for k, (colour, ways) in enumerate(grid.lines.items()):
        for way in ways:
            x, y = zip(*way, strict=True)
            if not k % 2:
                ax.plot(x, y, lw=HALO / 2, color="white", solid_capstyle="round")
            ax.plot(x, y, lw=CURVE / 2, color=colour, ls=(0, (1.5, 2.5)) if k % 2 else "-", solid_capstyle="round")
    for axis, place, name in ((grid.x, ax.set_xticks, ax.set_xlabel), (grid.y, ax.set_yticks, ax.set_ylabel)):
        place([line for line, _ in axis.ticks], [text for _, text in axis.ticks])
        name(plain(axis.name, LONGEST))


def on_page(drawing: Drawing) -> Markup:
    """The legend, the note and the panels as HTML. The script of the page enlarges panels and tells what a tile stands for."""
    entries = "".join(map(_swatch, drawing.legend))
    note = f'<p class="soft">{escape(drawing.note)}</p>' if drawing.note else ""
    enlarge = '<button class="enlarge" hidden title="enlarge" aria-label="enlarge">⤢</button>'
    shown = "".join(f'<div class="map">{enlarge}{markup(field, drawing.grid)}</div>\n' for field in drawing.fields)
    facts = json.dumps(drawing.facts).replace("<", "\\u003c")
    data = f'<script type="application/json" class="facts">{facts}</script>' if drawing.facts else ""
    tiles = f'<div class="tiles{" few" * (len(drawing.fields) <= FEW)}">{shown}</div><div class="tile" hidden></div>'
    return Markup(f'<p class="entries">{entries}</p>{note}{tiles}{data}')


def _swatch(entry: Entry) -> str:
    kind = ("dashed" if entry.dashed else "stroke") if entry.line else "area"
    return f'<span><i class="{kind}" style="color:{entry.colour}"></i>{escape(entry.name)}</span>'


def markup(field: Field, grid: Grid) -> str:
    """A panel as an SVG element; text is escaped. The group with a transform counts in grid lines, upwards."""
    across, up, bottom = ACROSS / grid.x.grid_lines, UP / grid.y.grid_lines, TOP + UP
    parts = [_text(1, 8, plain(field.title, LONGEST)), _text(1, TOP - 3, plain(grid.y.name, LONGEST))]
    ground = field.ground or "none"
    parts.append(f'<rect x="{LEFT:g}" y="{TOP:g}" width="{ACROSS:g}" height="{UP:g}" fill="{ground}" stroke="currentColor"/>')
    place = f"translate({LEFT + across / 2:.5g} {bottom - up / 2:.5g}) scale({across:.5g} {-up:.5g})"
    parts.append(f'<g transform="{place}" shape-rendering="crispEdges">{_bars(field.tiles)}</g>')
    for k, (colour, ways) in enumerate(grid.lines.items()):
        for way in ways:
            places = "L".join(f"{LEFT + (i + 0.5) * across:.1f} {bottom - (j + 0.5) * up:.1f}" for i, j in way)
            line = (
                f'<path d="M{places}{"h0" * (len(way) == 1)}" fill="none" stroke-linecap="round" stroke-linejoin="round" stroke'
            )
            halo = f'{line}="#ffffff" stroke-width="{HALO}"/>' if not k % 2 else ""
            dashes = f' stroke-dasharray="{DASHES[0]} {DASHES[1]}"' if k % 2 else ""
            parts.append(f'{halo}{line}="{colour}" stroke-width="{CURVE}"{dashes}/>')
    ticks = []
    for i, text in grid.x.ticks:
        x = LEFT + (i + 0.5) * across
        ticks.append(f"M{x:.4g} {bottom:g}v2.5")
        parts.append(_text(x, bottom + 10, text, "middle"))
    for j, text in grid.y.ticks:
        y = bottom - (j + 0.5) * up
        ticks.append(f"M{LEFT:g} {y:.4g}h-2.5")
        parts.append(_text(LEFT - 4, y + 2.5, text, "end"))
    parts.append(f'<path d="{"".join(ticks)}" stroke="currentColor" stroke-width="{TICK}"/>')
    parts.append(_text(LEFT + ACROSS, bottom + 19, plain(grid.x.name, LONGEST), "end"))
    label = f'role="img" aria-label="{escape(field.title)} over {escape(grid.x.name)} and {escape(grid.y.name)}"'
    font = f'font-family="sans-serif" font-size="{LETTERS:g}" fill="currentColor" stroke-width=".5"'
    return f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" {label} {font}>{"".join(parts)}</svg>'


def _text(x: float, y: float, text: str, anchor: str = "start") -> str:
    return f'<text x="{x:.4g}" y="{y:.4g}" text-anchor="{anchor}">{escape(text)}</text>'


def _bars(tiles: Iterable[Tile]) -> str:
    parts = []
    for colour, same in groupby(joined(tiles), key=lambda bar: bar.colour):
        parts.append(f'<g fill="{colour}" stroke="none">')
        for tooltip, bars in groupby(same, key=lambda bar: bar.tooltip):
            path = "".join(f"M{b.left:g} {b.low:g}H{b.right:g}V{b.high:g}H{b.left:g}z" for b in bars)
            parts.append(f'<path d="{path}"' + (f"><title>{escape(tooltip)}</title></path>" if tooltip else "/>"))
        parts.append("</g>")
    return "".join(parts)


def joined(tiles: Iterable[Tile]) -> list[Bar]:
    """The tiles as bars, the wider ones first, so that refinements are drawn over them; then by colour and tooltip."""
    bars: list[Bar] = []
    for i, j, width, colour, tooltip in sorted(tiles, key=lambda t: (-t.width, t.colour, t.tooltip, t.j, t.i)):
        bar = Bar(colour, tooltip, i - width / 2, i + width / 2, j - width / 2, j + width / 2)
        last = bars[-1] if bars else None
        if last and last._replace(left=bar.left, right=bar.right) == bar and last.right == bar.left:
            bars[-1] = last._replace(right=bar.right)
        else:
            bars.append(bar)
    return bars


def polylines(points: Iterable[Point], reach: float = REACH) -> list[list[Point]]:
    """The points joined each with the nearest of the others, as far as one is within reach: lines of one point or more.

    A line begins at the point that has the fewest others within reach, so that it is an end where the curve has one, and goes
    on to the nearest point until none is left; a curve that comes back to its first point is closed.
    """
    left = list(dict.fromkeys(points))
    found = []
    while left:
        start = min(left, key=lambda point: (sum(dist(point, other) <= reach for other in left), point))
        line = [start]
        left.remove(start)
        while left and dist(nearest := min(left, key=lambda point: dist(point, line[-1])), line[-1]) <= reach:
            line.append(nearest)
            left.remove(nearest)
        if len(line) > 3 and dist(line[0], line[-1]) <= reach / 2:
            line.append(line[0])
        found.append(line)
    return found
