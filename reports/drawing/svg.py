"""Maps as SVG: on the page each panel is a separate element, so that lines break between panels; in a file they form rows."""

from itertools import groupby

from markupsafe import escape

from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.drawing.tiles import Box, Dots, Drawing, Field, Panel, Text

PANELS_PER_ROW, HEAD = 7, 26.0  # in a file; units above the first row for the title and the note
FONT = f'font-family="sans-serif" font-size="{tiles.LETTERS:g}"'


def on_page(drawing: Drawing) -> str:
    """The note and the panels as HTML."""
    head = f'<svg viewBox="0 0 {tiles.WIDTH:g} {tiles.HEIGHT:g}" {FONT} fill="currentColor">'
    note = f'<p class="soft">{escape(drawing.note)}</p>' if drawing.note else ""
    return f'{note}<div class="tiles">' + "".join(f"{head}{markup(panel)}</svg>\n" for panel in drawing.panels) + "</div>"


def in_file(drawing: Drawing) -> str:
    """The map as the text of one SVG file, below its title and note."""
    across, up = PANELS_PER_ROW * tiles.WIDTH, HEAD + -(-len(drawing.panels) // PANELS_PER_ROW) * tiles.HEIGHT
    corners = [
        (k % PANELS_PER_ROW * tiles.WIDTH, HEAD + k // PANELS_PER_ROW * tiles.HEIGHT) for k in range(len(drawing.panels))
    ]
    parts = [_shape(Text(tiles.LEFT, 10, drawing.title)), _shape(Text(tiles.LEFT, 20, drawing.note))]
    parts += [
        f'<g transform="translate({x:g} {y:g})">{markup(panel)}</g>'
        for (x, y), panel in zip(corners, drawing.panels, strict=True)
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:g} {up:g}" {FONT}'
    return f'{head} fill="{INK}" color="{INK}">\n' + "\n".join(parts) + "\n</svg>\n"


def markup(panel: Panel) -> str:
    """The shapes of a panel as SVG elements; text is escaped."""
    return "".join(map(_shape, panel))


def _shape(shape: Text | Box | Field | Dots) -> str:
    match shape:
        case Text(x, y, text, size):
            smaller = f' font-size="{size:g}"' if size != tiles.LETTERS else ""
            return f'<text x="{x:g}" y="{y:g}"{smaller}>{escape(text)}</text>'
        case Box(x, y, width, height, colour, line, radius):
            place = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"' + (f' rx="{radius:g}"' if radius else "")
            return f'<rect {place} fill="{colour or "none"}" stroke="currentColor" stroke-width="{line:g}"/>'
        case Dots(colour, places):
            path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in places)
            return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{tiles.DOT:g}" stroke-linecap="round"/>'
        case Field():
            return _field(shape)


def _field(field: Field) -> str:
    across, up = tiles.ACROSS / field.columns, tiles.UP / field.lines
    place = f"translate({tiles.LEFT:g} {tiles.TOP + tiles.UP:g}) scale({across:.5g} {-up:.5g})"
    parts = []
    for colour, same in groupby(field.bars, key=lambda bars: bars.colour):
        parts.append(f'<g fill="{colour}">')
        for _, tooltip, bars in same:
            path = "".join(f"M{a:g} {low:g}H{b:g}v{height:g}H{a:g}z" for a, b, height, low in bars)
            parts.append(f'<path d="{path}"' + (f"><title>{escape(tooltip)}</title></path>" if tooltip else "/>"))
        parts.append("</g>")
    return f'<g transform="{place}" shape-rendering="crispEdges">{"".join(parts)}</g>'
