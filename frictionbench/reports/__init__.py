"""Figures, the HTML page, paper figures and tables: made from a results folder, without running anything again.

The names below are what programs outside the package use; each is imported when it is first used, because matplotlib takes a
second.
"""

from typing import TYPE_CHECKING

from frictionbench.lazy import importer

if TYPE_CHECKING:
    from frictionbench.reports.accuracy import OVERALL as OVERALL
    from frictionbench.reports.batches import HEADER as HEADER
    from frictionbench.reports.batches import METHOD as METHOD
    from frictionbench.reports.batches import RateTable as RateTable
    from frictionbench.reports.batches import rate_tables as rate_tables
    from frictionbench.reports.choice import Kind as Kind
    from frictionbench.reports.choice import choices as choices
    from frictionbench.reports.choice import headline as headline
    from frictionbench.reports.drawing.figures import Panel as Panel
    from frictionbench.reports.drawing.files import save_sheet as save_sheet
    from frictionbench.reports.drawing.style import ALARM as ALARM
    from frictionbench.reports.drawing.style import GRID as GRID
    from frictionbench.reports.drawing.style import INK as INK
    from frictionbench.reports.drawing.style import Look as Look
    from frictionbench.reports.drawing.style import looks as looks
    from frictionbench.reports.drawing.text import count as count
    from frictionbench.reports.drawing.text import escaped as escaped
    from frictionbench.reports.drawing.text import percent as percent
    from frictionbench.reports.drawing.text import plain as plain
    from frictionbench.reports.drawing.text import power as power
    from frictionbench.reports.drawing.text import seconds as seconds
    from frictionbench.reports.page import write_report as write_report
    from frictionbench.reports.robustness import MapCells as MapCells
    from frictionbench.reports.robustness import map_cells as map_cells
    from frictionbench.reports.run import Run as Run
    from frictionbench.reports.run import read_run as read_run
    from frictionbench.reports.tables import disturbed as disturbed
    from frictionbench.reports.tables import reliabilities as reliabilities
    from frictionbench.reports.tables import workers_on_all_cores as workers_on_all_cores
    from frictionbench.reports.templates import environment as environment
    from frictionbench.reports.templates import script as script

__getattr__ = importer(__name__, __file__)
