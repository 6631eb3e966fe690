"""Figures as files for a paper: sheets of panels as SVG and PDF. The same panels always give the same files, byte for byte."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from frictionbench.reports.drawing.figures import IMAGE, PANEL, Panel
from frictionbench.reports.drawing.style import RC, Look
from frictionbench.reports.drawing.text import plain
from frictionbench.results.files import replaced

FAMILIES = {"serif": ("serif", "STIXGeneral"), "sans": ("sans-serif", "DejaVu Sans")}  # fonts that matplotlib includes
TITLE, LETTER = 96, 0.008  # longest title of a panel, letters; width of a letter, inches per point of the font
ROUNDS = 4  # of breaking texts into lines: more lines of one leave less room for others
SPARE = 0.97  # share of its room that a text may take: letters are slightly wider or narrower in the files
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
    paper: str = "none",
    handles: Mapping[str, Artist] = NO_HANDLES,
) -> list[str]:
    """Save the panels on one sheet with a legend as STEM.svg and STEM.pdf; return the names in the legend.

    size: of one panel, inches. font: points. paper: the colour of the background. handles: legend entries besides the labels.
    """
    rows = -(-len(panels) // columns)
    width = columns * size[0]
    named_family, face = FAMILIES[family]
    sizes = {"font.size": font, "lines.markersize": font / 2, "lines.linewidth": font / 8, "font.family": named_family}
    with mpl.rc_context(RC | sizes | {f"font.{named_family}": [face]}):
        figure = Figure(figsize=(width, rows * size[1]), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for ax, panel in zip(grid, panels, strict=False):
            panel.draw(ax)
            ax.set_title(re.sub(r",(?! )", ", ", plain(panel.title, TITLE)))  # lines break at spaces
        for ax in grid[len(panels) :]:
            ax.axis("off")
        tags = {str(artist.get_gid()).removeprefix("dots-") for artist in figure.findobj()}
        named = {**{name: Line2D([], [], **look.line) for name, look in looks.items() if look.tag in tags}, **handles}
        names = [plain(name) for name in named]
        across, height = legend_size(names, width, font)
        figure.set_figheight(rows * size[1] + height)  # the legend is below the panels
        figure.legend(list(named.values()), names, loc="outside lower center", ncols=across, handlelength=3)
        _lay_out(figure, grid, columns, size)
        figure.set_layout_engine("none")  # keep the positions
        for path in (stem.with_suffix(".svg"), stem.with_suffix(".pdf")):
            date = "Date" if path.suffix == ".svg" else "CreationDate"
            with replaced(path) as file:
                figure.savefig(file, dpi=IMAGE, facecolor=paper, metadata={date: None})
    return list(named)


def _lay_out(figure: Figure, axes: Iterable[Axes], columns: int, size: tuple[float, float]) -> None:
    """Place the panels, with titles and labels broken into lines that stay within their panel, see `save_sheet`."""
    texts = [(k, ax, *text) for k, ax in enumerate(axes) for text in ((0, ax.title), (0, ax.xaxis.label), (1, ax.yaxis.label))]
    words = shown = [text.get_text() for *_, text in texts]
    for _ in range(ROUNDS):
        figure.draw_without_rendering()
        for (k, ax, way, text), whole in zip(texts, words, strict=True):
            start = (size[0] * (k % columns), figure.get_figheight() - size[1] * (k // columns + 1))[way]
            middle = ax.get_window_extent().get_points()[:, way].mean() / figure.dpi - start
            room = 2 * SPARE * min(middle, size[way] - middle) * figure.dpi
            for letters in range(len(whole), 0, -1):
                text.set_text(fill(whole, letters))
                if np.ptp(text.get_window_extent().get_points()[:, way]) <= room:
                    break
        before, shown = shown, [text.get_text() for *_, text in texts]
        if shown == before:
            break


def legend_size(names: Collection[str], width: float, font: float) -> tuple[int, float]:
    """Return the number of columns of a legend of this width (inches) and its height (inches). font: points."""
    longest = max(map(len, names), default=0) + HANDLE
    across = max(1, int(width / (LETTER * font * longest)))
    return across, 0.02 * font * -(-len(names) // across)
