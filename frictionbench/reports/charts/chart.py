"""The description of a chart. Page and paper take charts from the list in reports.charts."""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.run import Run

Section = Literal["top", "solvability", "maps", "chart", "time", "energy"]  # sections of the page, by the ids of headings


class Chart(NamedTuple):
    """One or more panels under a name. A chart without panels is left out.

    Each drawing of a map has its own file.
    """

    name: str  # of its files
    panels: Callable[[Run], Sequence[Panel] | Sequence[Drawing]]
    section: Section
    caption: str  # text, or trusted markup
    title: str = ""  # empty if the heading of the section suffices
    on_page: slice = slice(None)  # the panels shown on the page
    folded: bool = False  # shown on demand
    ranked: bool = False  # depends on the ranking: the page shows it for both
