"""Figures as files for a paper: sheets of panels as SVG and PDF, and as PGF if LaTeX is installed, which matplotlib needs to
measure text.

A PGF figure is set in the fonts and size of the paper. The same panels always give the same files, byte for byte.
"""

import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import fill

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text as Label
from matplotlib.ticker import FixedFormatter, FixedLocator

from frictionbench.reports.drawing.figures import IMAGE, PANEL, Panel
from frictionbench.reports.drawing.style import RC, Look
from frictionbench.reports.drawing.text import plain
from frictionbench.results.files import replaced

FAMILIES = {"serif": ("serif", "STIXGeneral"), "sans": ("sans-serif", "DejaVu Sans")}  # fonts that matplotlib includes
PGF = {"pgf.texsystem": "pdflatex", "pgf.rcfonts": False, "pgf.preamble": ""}
TITLE, LETTER = 96, 0.008  # letters of a panel's title, in lines of its width; inches of a letter for each point of the font
HANDLE = 9  # letters that fit into the line or patch beside a name in the legend and the gaps around it
NOTHING: Mapping[str, Artist] = {}
BANDS = 3  # bootstrap bands in one panel; more would hide each other
Escape = Callable[[str], str]


def save_sheet(
    panels: Sequence[Panel],
    looks: Mapping[str, Look],
    stem: Path,
    columns: int = 3,
    size: tuple[float, float] = PANEL,
    font: float = RC["font.size"],
    family: str = "sans",
    escape: Escape | None = None,
    kinds: Sequence[str] = ("svg", "pdf"),
    paper: str = "none",
    handles: Mapping[str, Artist] = NOTHING,
) -> list[str]:
    """Save the panels on one sheet with a legend as STEM.svg and STEM.pdf, and as STEM.pgf if `escape` is given; names drawn.

    size: of one panel, inches; font: points; escape: converts a text to LaTeX; paper: the colour of the background. handles:
    what the legend names besides the labels that are drawn.
    """
    columns = max(1, min(columns, len(panels)))
    rows = -(-len(panels) // columns)
    width = columns * size[0]
    named_family, face = FAMILIES[family]
    sizes = {"font.size": font, "lines.markersize": font / 2, "lines.linewidth": font / 8, "font.family": named_family}
    with mpl.rc_context(RC | sizes | {f"font.{named_family}": [face]} | PGF):
        figure = Figure(figsize=(width, rows * size[1]), layout="constrained")
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
        named = {**{name: Line2D([], [], **look.line) for name, look in drawn.items()}, **handles}
        _legend(figure, {plain(name): handle for name, handle in named.items()}, rows * size[1], font)
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


def _legend(figure: Figure, named: Mapping[str, Artist], height: float, font: float) -> None:
    """A legend below the panels, in as many columns as the longest name leaves room for; the figure grows by its height."""
    longest = max(map(len, named), default=0) + HANDLE
    across = max(1, int(figure.get_figwidth() / (LETTER * font * longest)))
    figure.set_figheight(height + 0.02 * font * -(-len(named) // across))
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=across, handlelength=3)


def remove_bands(ax: Axes) -> None:
    """Remove the bootstrap bands."""
    for band in ax.findobj(lambda artist: str(artist.get_gid()).startswith("band-")):
        band.remove()


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
