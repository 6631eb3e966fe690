"""Maps as SVG: on the page each panel is a separate element, so that lines break between panels; in a file they form rows."""

import json
from itertools import groupby

from markupsafe import escape

from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.drawing.tiles import Box, Drawing, Entry, Field, Line, Panel, Shape, Text

PANELS_PER_ROW, HEAD = 4, 26.0  # in a file; units above the first row for the title and the note
FEW = 6  # panels of a map that are drawn large
FONT = f'font-family="sans-serif" font-size="{tiles.LETTERS:g}"'


def on_page(drawing: Drawing) -> str:
    """The legend, the note and the panels as HTML. The script of the page enlarges panels and tells what a tile stands for."""
    size = f'viewBox="0 0 {tiles.WIDTH:g} {tiles.HEIGHT:g}"'
    head = f'<svg {size} {FONT} fill="currentColor">'
    entries = "".join(map(_swatch, drawing.legend))
    note = f'<p class="soft">{escape(drawing.note)}</p>' if drawing.note else ""
    enlarge = '<button class="enlarge" hidden title="enlarge" aria-label="enlarge">⤢</button>'
    shown = "".join(f'<div class="map">{enlarge}{head}{markup(panel)}</svg></div>\n' for panel in drawing.panels)
    facts = json.dumps(drawing.facts).replace("<", "\\u003c")
    data = f'<script type="application/json" class="facts">{facts}</script>' if drawing.facts else ""
    few = " few" if len(drawing.panels) <= FEW else ""
    return f'<p class="entries">{entries}</p>{note}<div class="tiles{few}">{shown}</div><div class="tile" hidden></div>{data}'


def _swatch(entry: Entry) -> str:
    kind = ("dashed" if entry.dashed else "stroke") if entry.line else "area"
    return f'<span><i class="{kind}" style="color:{entry.colour}"></i>{escape(entry.name)}</span>'


def in_file(drawing: Drawing) -> str:
    """The map as the text of one SVG file, below its title and note."""
    panels = (*drawing.panels, tiles.legend(drawing.legend))
    across = min(PANELS_PER_ROW, len(panels)) * tiles.WIDTH
    up = HEAD + -(-len(panels) // PANELS_PER_ROW) * tiles.HEIGHT
    corners = [(k % PANELS_PER_ROW * tiles.WIDTH, HEAD + k // PANELS_PER_ROW * tiles.HEIGHT) for k in range(len(panels))]
    parts = [_shape(Text(1, 9, drawing.title)), _shape(Text(1, 19, drawing.note))]
    parts += [
        f'<g transform="translate({x:g} {y:g})">{markup(panel)}</g>' for (x, y), panel in zip(corners, panels, strict=True)
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {across:g} {up:g}" {FONT}'
    return f'{head} fill="{INK}" color="{INK}">\n' + "\n".join(parts) + "\n</svg>\n"


def markup(panel: Panel) -> str:
    """The shapes of a panel as SVG elements; text is escaped."""
    return "".join(map(_shape, panel))


def _shape(shape: Shape) -> str:
    match shape:
        case Text(x, y, text, anchor):
            side = "" if anchor == "start" else f' text-anchor="{anchor}"'
            return f'<text x="{x:.4g}" y="{y:.4g}"{side}>{escape(text)}</text>'
        case Box(x, y, width, height, colour, line):
            place = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}"'
            return f'<rect {place} fill="{colour or "none"}" stroke="currentColor" stroke-width="{line:g}"/>'
        case Line(colour, places, width, dashed):
            path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places) + "h0" * (len(places) == 1)
            drawn = f'<path d="{path}" fill="none" stroke-linecap="round" stroke-linejoin="round" stroke'
            halo = f'{drawn}="#ffffff" stroke-width="{2.2 * width:.3g}"/>' if colour and not dashed else ""
            dashes = f' stroke-dasharray="{2.5 * width:.3g} {3.5 * width:.3g}"' if dashed else ""
            return f'{halo}{drawn}="{colour or "currentColor"}" stroke-width="{width:g}"{dashes}/>'
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
