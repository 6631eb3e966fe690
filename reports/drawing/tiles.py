"""A map as data: panels of coloured tiles over two parameters, laid out as a few shapes that each renderer draws.

A panel is WIDTH x HEIGHT units with its origin at the upper left; the field of tiles is ACROSS x UP of them. Grid points are
counted in grid lines from the lower left corner of the field. reports.drawing.svg draws the shapes for the page, where a panel
may hold thousands of tiles, and reports.drawing.print draws them for a paper.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple

from frictionbench.reports.drawing.text import plain

WIDTH, HEIGHT = 124.0, 112.0
LEFT, TOP, ACROSS, UP = 1.0, 14.0, 120.0, 96.0  # of the field of tiles
LETTERS, SMALL_LETTERS = 7.0, 5.6  # font sizes; a title of more than SHORT letters fits in the smaller one
SHORT, LONGEST = 28, 40  # letters of a title; a title longer than LONGEST is cut
DOT = 1.6  # units, the diameter of a dot
LEGEND_ROWS = 7  # of a column of the legend: as many as fit above the names of the axes
Points = Mapping[str, Iterable[tuple[float, float]]]  # grid points by colour


class Tile(NamedTuple):
    """A square of `width` grid lines centred at the grid point (i, j). tooltip: text shown when the pointer hovers over it."""

    i: float
    j: float
    width: float
    colour: str
    tooltip: str = ""


class Grid(NamedTuple):
    """What the panels of a map have in common: of each axis its parameter, its ends as text and its number of grid lines; and
    points drawn over the tiles."""

    x: tuple[str, str, str, int]
    y: tuple[str, str, str, int]
    points: Points


class Text(NamedTuple):
    """A line of text whose baseline starts at (x, y)."""

    x: float
    y: float
    text: str
    size: float = LETTERS


class Box(NamedTuple):
    """An outlined rectangle with its upper left corner at (x, y). colour: empty for no fill; line: width of the outline."""

    x: float
    y: float
    width: float
    height: float
    colour: str
    line: float
    radius: float = 0.0


class Bars(NamedTuple):
    """Tiles of one colour and tooltip, neighbours joined: each bar is (left, right, height, lower edge) in grid lines."""

    colour: str
    tooltip: str
    bars: tuple[tuple[float, float, float, float], ...]


class Field(NamedTuple):
    """The tiles of a panel, the wider ones first so that refinements are drawn over them, on columns x lines grid lines."""

    columns: int
    lines: int
    bars: tuple[Bars, ...]


class Dots(NamedTuple):
    """Dots of one colour at places (x, y) of the panel."""

    colour: str
    places: tuple[tuple[float, float], ...]


Panel = tuple[Text | Box | Field | Dots, ...]


class Drawing(NamedTuple):
    """A map: its title, the name of its file, its panels, and a note on what needs no panel."""

    title: str
    name: str
    panels: tuple[Panel, ...]
    note: str = ""


def legend(labels: Sequence[tuple[str, str, bool]], grid: Grid) -> Panel:
    """The panel of names and their colours, as dots where the third item is true, and of the parameters of both axes."""
    shapes: list[Text | Box] = []
    for k, (name, colour, dot) in enumerate(labels):
        x, y = 2 + 60 * (k // LEGEND_ROWS), TOP + 9 * (k % LEGEND_ROWS)
        shapes += [Box(x, y, 6, 6, colour, 0.3, radius=3.0 * dot), Text(x + 9, y + 5.4, name)]
    for k, (way, (parameter, low, high, _)) in enumerate((("across", grid.x), ("upwards", grid.y))):
        y = HEIGHT - 27 + 16 * k
        shapes += [Text(2, y, f"{way}: {parameter}"), Text(2, y + 8, f"{low} to {high}")]
    return tuple(shapes)


def panel(title: str, tiles: Iterable[Tile], grid: Grid, background: str = "") -> Panel:
    """A title over a field of tiles. background: the colour of the field, so that whole tiles of it can be left out."""
    columns, lines = grid.x[3], grid.y[3]
    dots = (
        Dots(colour, tuple((LEFT + (i + 0.5) * ACROSS / columns, TOP + UP - (j + 0.5) * UP / lines) for i, j in points))
        for colour, points in grid.points.items()
    )
    return (
        Text(LEFT, 10, plain(title, LONGEST), SMALL_LETTERS if len(title) > SHORT else LETTERS),
        Box(LEFT, TOP, ACROSS, UP, background, 0.5),
        Field(columns, lines, tuple(_joined(tiles))),
        *dots,
    )


def _joined(tiles: Iterable[Tile]) -> Iterable[Bars]:
    for (_, colour, tooltip), alike in groupby(sorted(tiles, key=_order), key=_order):
        bars: list[tuple[float, float, float, float]] = []
        for j, i, w in sorted((tile.j, tile.i, tile.width) for tile in alike):
            left, low = i + 0.5 - w / 2, j + 0.5 - w / 2
            if bars and bars[-1][1:] == (left, w, low):
                left = bars.pop()[0]
            bars.append((left, i + 0.5 + w / 2, w, low))
        yield Bars(colour, tooltip, tuple(bars))


def _order(tile: Tile) -> tuple[float, str, str]:
    return -tile.width, tile.colour, tile.tooltip
