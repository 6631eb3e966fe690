"""Figures as files for a paper: sheets of panels as SVG and PDF. The same panels always give the same files, byte for byte."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictionbench.reports.drawing.figures import IMAGE, PANEL, Panel
from frictionbench.reports.drawing.style import RC, Look
from frictionbench.reports.drawing.text import plain
from frictionbench.results.files import replaced

FAMILIES = {"serif": ("serif", "STIXGeneral"), "sans": ("sans-serif", "DejaVu Sans")}  # fonts that matplotlib includes
TITLE, LETTER = 96, 0.008  # longest title of a panel, letters; width of a letter, inches per point of the font
HANDLE = 9  # width, in letters, of a legend's line or patch with the gaps around it
NO_HANDLES: Mapping[str, Artist] = {}


def save_sheet(
    panels: Sequence[Panel],
    looks: Mapping[str, Look],
    stem: Path,
    columns: int = 3,
    size: tuple[float, float] = PANEL,
    font: float = RC["font.size"],
    family: str = "sans",
    kinds: Sequence[str] = ("svg", "pdf"),
    paper: str = "none",
    handles: Mapping[str, Artist] = NO_HANDLES,
) -> list[str]:
    """Save the panels on one sheet with a legend as STEM.svg and STEM.pdf; return the names in the legend.

    size: of one panel, inches. font: points. paper: the colour of the background. handles: legend entries besides the labels.
    """
    columns = max(1, min(columns, len(panels)))
    rows = -(-len(panels) // columns)
    width = columns * size[0]
    named_family, face = FAMILIES[family]
    sizes = {"font.size": font, "lines.markersize": font / 2, "lines.linewidth": font / 8, "font.family": named_family}
    with mpl.rc_context(RC | sizes | {f"font.{named_family}": [face]}):
        figure = Figure(figsize=(width, rows * size[1]), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, panel in zip(grid, panels, strict=False):
            panel.draw(ax)
            ax.set_title(fill(plain(panel.title, TITLE), int(size[0] / (LETTER * font)), break_long_words=False))
        for ax in grid[len(panels) :]:
            ax.axis("off")
        tags = {str(artist.get_gid()).removeprefix("dots-") for artist in figure.findobj()}
        drawn = {name: look for name, look in looks.items() if look.tag in tags}
        named = {**{name: Line2D([], [], **look.line) for name, look in drawn.items()}, **handles}
        _legend(figure, {plain(name): handle for name, handle in named.items()}, rows * size[1], font)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # keep the positions
        for path in (stem.with_suffix(f".{kind}") for kind in kinds):
            date = "Date" if path.suffix == ".svg" else "CreationDate"
            with replaced(path) as file:
                figure.savefig(file, dpi=IMAGE, facecolor=paper, metadata={date: None})
    return list(named)


def legend_size(names: Collection[str], width: float, font: float) -> tuple[int, float]:
    """Return the number of columns of a legend of this width (inches) and its height (inches). font: points."""
    longest = max(map(len, names), default=0) + HANDLE
    across = max(1, int(width / (LETTER * font * longest)))
    return across, 0.02 * font * -(-len(names) // across)


def _legend(figure: Figure, named: Mapping[str, Artist], height: float, font: float) -> None:
    """Add a legend below the panels, in as many columns as the longest name allows; the figure grows by its height."""
    across, legend_height = legend_size(named, figure.get_figwidth(), font)
    figure.set_figheight(height + legend_height)
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=across, handlelength=3)
