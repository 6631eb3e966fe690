"""What a chart is to the page and the paper, which both walk the list in reports.charts."""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.drawing.tiles import Drawing
from frictionbench.reports.run import Run

Section = Literal["solvability", "maps", "chart", "time", "energy"]  # of the page, by the id of its heading


class Chart(NamedTuple):
    """One or more panels under a name, without which there is nothing to see and the chart is left out."""

    name: str  # of its files
    panels: Callable[[Run], Sequence[Panel] | Sequence[Drawing]]
    section: Section
    caption: str  # text, or markup of our own
    title: str = ""  # none where the section's own will do
    columns: int = 1  # of panels in the paper: one fills a column of text, several the width of the page
    on_page: slice = slice(None)  # which of the panels the page shows
    in_paper: slice = slice(None)  # which the paper shows
    wide: bool = False  # drawings, each of which takes the page's width, and a file of its own
    folded: bool = False  # shown on demand
