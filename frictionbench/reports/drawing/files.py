"""Figures as files for a paper: sheets of panels as SVG and PDF, maps (reports.drawing.tiles) as PDF, and both as PGF if LaTeX
is installed, which matplotlib needs to measure text.

A PGF figure is set in the fonts and size of the paper. The same panels always give the same files, byte for byte. What does not
fit on a page is split over several files, so that a map of many solvers is continued on the next page.
"""

import shutil
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.text import Text as Label
from matplotlib.ticker import FixedFormatter, FixedLocator
from matplotlib.transforms import Affine2D

from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.figures import IMAGE, PANEL, Panel
from frictionbench.reports.drawing.style import INK, RC, Look
from frictionbench.reports.drawing.text import plain
from frictionbench.reports.drawing.tiles import Bars, Box, Drawing, Field, Line, Text
from frictionbench.results.files import replaced

FAMILIES = {"serif": "STIXGeneral", "sans": "DejaVu Sans"}  # fonts that matplotlib includes
PGF = {"pgf.texsystem": "pdflatex", "pgf.rcfonts": False, "pgf.preamble": ""}
TITLE, LETTER = 96, 0.008  # letters of a panel's title, in lines of its width; inches of a letter for each point of the font
BANDS = 3  # bootstrap bands in one panel; more would hide each other
Escape = Callable[[str], str]
PANELS_PER_ROW = 4  # so that letters are of some six points on a page of two columns
SEAM = 0.05  # points, the outline of a tile, which closes the gap that a viewer may show between neighbours


def save_sheet(
    panels: Sequence[Panel],
    looks: dict[str, Look],
    stem: Path,
    columns: int = 3,
    size: tuple[float, float] = PANEL,
    font: float = RC["font.size"],
    family: str = "sans",
    escape: Escape | None = None,
    kinds: Sequence[str] = ("svg", "pdf"),
    paper: str = "none",
) -> list[str]:
    """Save the panels on one sheet with a legend as STEM.svg and STEM.pdf, and as STEM.pgf if `escape` is given; names drawn.

    size: of one panel, inches; font: points; escape: converts a text to LaTeX; paper: the colour of the background.
    """
    columns = max(1, min(columns, len(panels)))
    rows = -(-len(panels) // columns)
    across = max(1, int(columns * size[0] / (0.2 * font)))  # an item of the legend is about 13 letters wide
    sizes = {"font.size": font, "lines.markersize": font / 2, "lines.linewidth": font / 8, "font.family": _family(family)}
    with mpl.rc_context(RC | sizes | {f"font.{_family(family)}": [FAMILIES[family]]} | PGF):
        figure = Figure(figsize=(columns * size[0], rows * size[1]), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, panel in zip(grid, panels, strict=False):
            panel.draw(ax)
            ax.set_title(fill(plain(panel.title, TITLE), int(size[0] / (LETTER * font)), break_long_words=False))
            if len(looks) > BANDS:
                remove_bands(ax)
        for ax in grid[len(panels) :]:
            ax.axis("off")
        tags = {str(artist.get_gid()).removeprefix("dots-") for artist in figure.findobj()}
        drawn = {name: look for name, look in looks.items() if look.tag in tags}
        figure.set_figheight(rows * size[1] + 0.02 * font * -(-len(drawn) // across))
        handles = [Line2D([], [], **look.line) for look in drawn.values()]
        figure.legend(handles, [plain(name) for name in drawn], loc="outside lower center", ncols=across, handlelength=3)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # keep the positions
        for path in (stem.with_suffix(f".{kind}") for kind in kinds):
            date = "Date" if path.suffix == ".svg" else "CreationDate"
            with replaced(path) as file:
                figure.savefig(file, dpi=IMAGE, facecolor=paper, metadata={date: None})
        if escape:
            figure.set_layout_engine("constrained")  # the font differs
            save_pgf(figure, stem, escape)
        return list(drawn)


def remove_bands(ax: Axes) -> None:
    """Remove the bootstrap bands."""
    for band in ax.findobj(lambda artist: str(artist.get_gid()).startswith("band-")):
        band.remove()


def _family(family: str) -> str:
    return {"serif": "serif", "sans": "sans-serif"}[family]


def save_pgf(figure: Figure, stem: Path, escape: Escape) -> list[Path]:
    """Save the figure as STEM.pgf with the images that it includes, STEM-img0.png and so on."""
    _escape_all(figure, escape)
    saved = []
    with tempfile.TemporaryDirectory() as scratch:
        figure.savefig(Path(scratch) / f"{stem.name}.pgf", dpi=IMAGE, backend="pgf")
        for made in sorted(Path(scratch).iterdir()):
            with replaced(stem.with_name(made.name)) as file:
                shutil.copyfile(made, file)
            saved.append(stem.with_name(made.name))
    return saved


def _escape_all(figure: Figure, escape: Escape) -> None:
    """Convert all texts to LaTeX, because matplotlib writes them unchanged. Ticks get fixed positions and labels."""
    figure.draw_without_rendering()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            for minor, locate, form in (
                (False, axis.set_major_locator, axis.set_major_formatter),
                (True, axis.set_minor_locator, axis.set_minor_formatter),
            ):
                labels = [escape(label.get_text()) for label in axis.get_ticklabels(minor=minor)]
                locate(FixedLocator(list(axis.get_ticklocs(minor=minor))))
                form(FixedFormatter(labels))
    for text in figure.findobj(Label):
        text.set_text("\n".join(map(escape, text.get_text().split("\n"))))


def pages(drawing: Drawing, width: float, height: float) -> list[tuple[tiles.Panel, ...]]:
    """The panels and the legend in parts that fit into so many inches; the legend stands at the end of the first part."""
    across = min(PANELS_PER_ROW, len(drawing.panels) + 1)
    rows = max(1, int(height / (width / across * tiles.HEIGHT / tiles.WIDTH)))
    most = across * rows
    first, rest = drawing.panels[: most - 1], drawing.panels[most - 1 :]
    return [(*first, tiles.legend(drawing.legend)), *(rest[k : k + most] for k in range(0, len(rest), most))]


def save_panels(panels: Sequence[tiles.Panel], stem: Path, width: float, family: str, escape: Escape | None = None) -> None:
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


def draw_panel(ax: Axes, panel: tiles.Panel, left: float, top: float, points: float) -> None:
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
