"""A map as data: panels of coloured tiles over two parameters, laid out as a few shapes that each renderer draws.

A panel is WIDTH x HEIGHT units with its origin at the upper left; the field of tiles is ACROSS x UP of them, below the title
and the name of the upward axis, with ticks on the left and below. Grid points are counted in grid lines from the lower left
corner of the field. reports.drawing.svg draws the shapes for the page, where a panel may hold thousands of tiles, and
reports.drawing.files draws them for a paper.

`polylines` joins points that were found in no order along a line, such as the crossings of a threshold with the grid,
and `picture` draws the first steps of a scene as paths of SVG, in which y points down.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from math import hypot
from typing import Literal, NamedTuple

import numpy as np

from frictionbench.reports.drawing.text import plain
from frictionbench.results.maps import FirstSteps
from frictionbench.results.motion import Array, Outline

WIDTH, HEIGHT = 158.0, 142.0
LEFT, TOP, ACROSS, UP = 30.0, 22.0, 120.0, 96.0  # of the field of tiles
LETTERS = 7.2  # font size
LONGEST = 38  # letters of a title; a longer one is cut
LEGEND_ROWS = 8  # of a column of the legend: as many as fit on a panel
Point = tuple[float, float]
REACH = 1.5  # grid lines: neighbours on a curve that crosses all lines of the grid are at most a diagonal, 1.41, apart
MARGIN = 0.15  # around the bodies, relative to their size


class Tile(NamedTuple):
    """A square of `width` grid lines centred at the grid point (i, j). tooltip: text shown when the pointer hovers over it."""

    i: float
    j: float
    width: float
    colour: str
    tooltip: str = ""


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


class Text(NamedTuple):
    """A line of text whose baseline starts, has its middle or ends at (x, y)."""

    x: float
    y: float
    text: str
    anchor: Literal["start", "middle", "end"] = "start"


class Box(NamedTuple):
    """An outlined rectangle with its upper left corner at (x, y). colour: empty for no fill; line: width of the outline."""

    x: float
    y: float
    width: float
    height: float
    colour: str
    line: float


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


class Line(NamedTuple):
    """A line through places (x, y) of the panel. colour: of a curve, which a wider white one sets off from the tiles; empty for
    a tick. dashed: every other curve is, so that two that coincide are both seen."""

    colour: str
    places: tuple[Point, ...]
    width: float
    dashed: bool = False


Shape = Text | Box | Field | Line
Panel = tuple[Shape, ...]
CURVE, TICK = 1.3, 0.5  # widths of lines


class Entry(NamedTuple):
    """An entry of the legend: a name and its colour, of a line or of tiles."""

    name: str
    colour: str
    line: bool = False
    dashed: bool = False


class Drawing(NamedTuple):
    """A map: its title, the name of its file, its legend, its panels, a note on what needs no panel, and the facts by which a
    reader finds what a tile stands for (see reports.charts.failure_maps)."""

    title: str
    name: str
    legend: tuple[Entry, ...]
    panels: tuple[Panel, ...]
    note: str = ""
    facts: Mapping[str, object] = {}


def legend(entries: Sequence[Entry]) -> Panel:
    """The panel of names and their colours."""
    shapes: list[Shape] = []
    for k, (name, colour, line, dashed) in enumerate(entries):
        x, y = 2 + 78 * (k // LEGEND_ROWS), TOP + 11 * (k % LEGEND_ROWS)
        shapes.append(Line(colour, ((x, y + 3), (x + 8, y + 3)), CURVE, dashed) if line else Box(x, y, 8, 6, colour, 0.3))
        shapes.append(Text(x + 11, y + 5.6, name))
    return tuple(shapes)


def panel(title: str, tiles: Iterable[Tile], grid: Grid, background: str = "") -> Panel:
    """A title over a field of tiles with its axes. background: the colour of the field, so that its whole tiles can be left
    out."""
    columns, rows = grid.x.grid_lines, grid.y.grid_lines
    bottom = TOP + UP

    def place(i: float, j: float) -> Point:
        return LEFT + (i + 0.5) * ACROSS / columns, bottom - (j + 0.5) * UP / rows

    lines = (
        Line(colour, tuple(place(*at) for at in one), CURVE, dashed=bool(k % 2))
        for k, (colour, ways) in enumerate(grid.lines.items())
        for one in ways
    )
    ticks: list[Shape] = []
    for i, text in grid.x.ticks:
        x, _ = place(i, 0)
        ticks += [Line("", ((x, bottom), (x, bottom + 2.5)), TICK), Text(x, bottom + 10, text, "middle")]
    for j, text in grid.y.ticks:
        _, y = place(0, j)
        ticks += [Line("", ((LEFT - 2.5, y), (LEFT, y)), TICK), Text(LEFT - 4, y + 2.5, text, "end")]
    return (
        Text(1, 8, plain(title, LONGEST)),
        Text(1, TOP - 3, plain(grid.y.name, LONGEST)),
        Box(LEFT, TOP, ACROSS, UP, background, 0.5),
        Field(columns, rows, tuple(_joined(tiles))),
        *lines,
        *ticks,
        Text(LEFT + ACROSS, bottom + 19, plain(grid.x.name, LONGEST), "end"),
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


def polylines(points: Iterable[Point], reach: float = REACH) -> list[list[Point]]:
    """The points joined each with the nearest of the others, as far as one is within reach: lines of one point or more.

    A line begins at the point that has the fewest others within reach, so that it is an end where the curve has one, and goes
    on to the nearest point until none is left; a curve that comes back to its first point is closed.
    """
    left = list(dict.fromkeys(points))
    found = []
    while left:
        start = min(left, key=lambda point: (sum(_apart(point, other) <= reach for other in left), point))
        line = [start]
        left.remove(start)
        while left and _apart(nearest := min(left, key=lambda point: _apart(point, line[-1])), line[-1]) <= reach:
            line.append(nearest)
            left.remove(nearest)
        if len(line) > 3 and _apart(line[0], line[-1]) <= reach / 2:
            line.append(line[0])
        found.append(line)
    return found


def _apart(a: Point, b: Point) -> float:
    return hypot(a[0] - b[0], a[1] - b[1])


def picture(found: FirstSteps) -> dict[str, object]:
    """at: the grid point. view: of the SVG. ground: a path. frames: a path each, the earliest first."""
    moving = [outline for outline in found.outlines if outline.body >= 0]
    places = [_placed(outline, pose) for pose in found.poses for outline in moving]
    low, high = (
        (np.min([place.min(axis=0) for place in places], axis=0), np.max([place.max(axis=0) for place in places], axis=0))
        if places
        else (-np.ones(2), np.ones(2))
    )
    margin = MARGIN * max(float((high - low).max()), 1e-9)
    box = low - margin, high + margin
    still = [outline for outline in found.outlines if outline.body < 0]
    return {
        "at": found.point,
        "view": " ".join(f"{value:.5g}" for value in (box[0][0], -box[1][1], *(box[1] - box[0]))),
        "ground": "".join(_svg_path(_ground(outline, box), closed=not outline.endless) for outline in still),
        "frames": ["".join(_svg_path(_placed(outline, pose)) for outline in moving) for pose in found.poses],
    }


def _placed(outline: Outline, pose: Array) -> Array:
    """The corners (k, 2) of a body's shape, of a disc those of a polygon, and its radius to show how it turns."""
    x, y, angle = pose[outline.body]
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    placed: Array = _outline_corners(outline) @ turn + (x, y)
    return placed


def _outline_corners(outline: Outline) -> Array:
    if not outline.radius:
        return outline.corners
    around = np.linspace(0, 2 * np.pi, 25)
    circle = abs(outline.radius) * np.column_stack([np.cos(around), np.sin(around)])
    return np.vstack([outline.corners[:1] + circle, outline.corners[:1]])


def _ground(outline: Outline, box: tuple[Array, Array]) -> Array:
    """The shape; the surface of a half plane as far as it is seen in the box between the lowest and the highest corner."""
    if not outline.endless or len(outline.corners) < 2:
        return _outline_corners(outline)
    a, b = outline.corners[:2]
    along = (b - a) / max(float(np.linalg.norm(b - a)), 1e-300)
    middle = a + along * float(along @ ((box[0] + box[1]) / 2 - a))
    far = 2 * float(np.linalg.norm(box[1] - box[0]))
    return np.stack([middle - far * along, middle + far * along])


def _svg_path(corners: Array, closed: bool = True) -> str:
    return "M" + "L".join(f"{x:.5g} {-y:.5g}" for x, y in corners) + "Z" * closed
