"""Maps as SVG, written by hand, for a page holds a hundred thousand tiles: panels of coloured tiles over two parameters.

A panel is WIDTH x HEIGHT units, its field of tiles ACROSS x UP of them; places are counted in grid lines from the lower left.
On a page each panel is an element of its own, and as many stand side by side as there is room for; in a file, in rows.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple

from markupsafe import escape

from frictionbench.reports.drawing.style import INK
from frictionbench.reports.drawing.text import plain

WIDTH, HEIGHT = 124.0, 112.0
LEFT, TOP, ACROSS, UP = 1.0, 14.0, 120.0, 96.0  # of the field
IN_A_ROW, HEAD = 7, 26.0  # panels, and the height of the words above them, in a file
SHORT, LONGEST = 28, 40  # letters of a title: beyond the one smaller, beyond the other cut
LINES = 7  # of a legend, in a column
Dots = Mapping[str, Iterable[tuple[float, float]]]  # places, by colour


class Tile(NamedTuple):
    """A square in grid lines, about the place (i, j). told: what a reader sees who points at it."""

    i: float
    j: float
    width: float
    colour: str
    told: str = ""


class Grid(NamedTuple):
    """What all panels of a map share: of each axis its parameter, its ends as text and its number of grid lines; and dots."""

    x: tuple[str, str, str, int]
    y: tuple[str, str, str, int]
    dots: Dots


class Drawing(NamedTuple):
    """A map: a title, the name of its file, panels as SVG without their outermost element, and what needs no panel."""

    title: str
    name: str
    panels: tuple[str, ...]
    note: str = ""


def on_page(drawing: Drawing) -> str:
    """HTML: the panels, which flow like words."""
    head = f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" font-family="sans-serif" font-size="7" fill="currentColor">'
    note = f'<p class="soft">{escape(drawing.note)}</p>' if drawing.note else ""
    return f'{note}<div class="tiles">' + "".join(f"{head}{panel}</svg>\n" for panel in drawing.panels) + "</div>"


def in_file(drawing: Drawing) -> str:
    """One SVG file: the panels in rows, above them the title and the note."""
    across, up = IN_A_ROW * WIDTH, HEAD + -(-len(drawing.panels) // IN_A_ROW) * HEIGHT
    parts = [_text(LEFT, 10, drawing.title), _text(LEFT, 20, drawing.note)]
    parts += [
        f'<g transform="translate({k % IN_A_ROW * WIDTH:g} {HEAD + k // IN_A_ROW * HEIGHT:g})">{panel}</g>'
        for k, panel in enumerate(drawing.panels)
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:g} {up:g}" font-family="sans-serif" font-size="7"'
    return f'{head} fill="{INK}" color="{INK}">\n' + "\n".join(parts) + "\n</svg>\n"


def legend(entries: Sequence[tuple[str, str, bool]], grid: Grid) -> str:
    """A panel of names and their colours, of dots where the third is true; and what the two axes are."""
    parts = []
    for k, (name, colour, dot) in enumerate(entries):
        x, y = 2 + 60 * (k // LINES), TOP + 9 * (k % LINES)
        shape = f'<rect x="{x}" y="{y:g}" width="6" height="6" rx="{3 * dot}" fill="{colour}"'
        parts.append(f'{shape} stroke="currentColor" stroke-width=".3"/>')
        parts.append(_text(x + 9, y + 5.4, name))
    for k, (way, (parameter, low, high, _)) in enumerate((("across", grid.x), ("upwards", grid.y))):
        parts += [_text(2, HEIGHT - 27 + 16 * k, f"{way}: {parameter}"), _text(2, HEIGHT - 19 + 16 * k, f"{low} to {high}")]
    return "".join(parts)


def panel(title: str, tiles: Iterable[Tile], grid: Grid, ground: str = "") -> str:
    """ground: the colour under all tiles; those that are as wide as a grid line, of that colour, need not be told."""
    columns, lines = grid.x[3], grid.y[3]
    field = f'x="{LEFT:g}" y="{TOP:g}" width="{ACROSS:g}" height="{UP:g}"'
    place = f"translate({LEFT:g} {TOP + UP:g}) scale({ACROSS / columns:.5g} {-UP / lines:.5g})"
    parts = [
        _text(LEFT, 10, plain(title, LONGEST), small=len(title) > SHORT),
        f'<rect {field} fill="{ground or "none"}" stroke="currentColor" stroke-width=".5"/>',
        f'<g transform="{place}" shape-rendering="crispEdges">{_squares(tiles)}</g>',
    ]
    for colour, places in grid.dots.items():
        at = [(LEFT + (i + 0.5) * ACROSS / columns, TOP + UP - (j + 0.5) * UP / lines) for i, j in places]
        way = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in at)
        parts.append(f'<path d="{way}" fill="none" stroke="{colour}" stroke-width="1.6" stroke-linecap="round"/>')
    return "".join(parts)


def _squares(tiles: Iterable[Tile]) -> str:
    """The wider below the narrower; those of one colour without a text in one path, neighbours joined."""
    parts = []
    for (_, colour), alike in groupby(sorted(tiles, key=_order), key=lambda tile: _order(tile)[:2]):
        parts.append(f'<g fill="{colour}">')
        for told, same in groupby(alike, key=lambda tile: tile.told):
            way = "".join(f"M{a:g} {b:g}H{end:g}v{w:g}H{a:g}z" for a, end, w, b in _bars(same))
            parts.append(f'<path d="{way}"' + (f"><title>{escape(told)}</title></path>" if told else "/>"))
        parts.append("</g>")
    return "".join(parts)


def _bars(tiles: Iterable[Tile]) -> list[list[float]]:
    """Tiles as bars along the grid lines: from, to, height, lower edge."""
    bars: list[list[float]] = []
    for j, i, w in sorted((tile.j, tile.i, tile.width) for tile in tiles):
        a, b = i + 0.5 - w / 2, j + 0.5 - w / 2
        if bars and bars[-1][1:] == [a, w, b]:
            bars[-1][1] = a + w
        else:
            bars.append([a, a + w, w, b])
    return bars


def _order(tile: Tile) -> tuple[float, str, str]:
    return -tile.width, tile.colour, tile.told


def _text(x: float, y: float, text: str, *, small: bool = False) -> str:
    size = ' font-size="5.6"' if small else ""
    return f'<text x="{x:g}" y="{y:g}"{size}>{escape(text)}</text>'
