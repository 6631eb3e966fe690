"""Figures, the HTML page, paper figures and tables: made from a results folder, without running anything again.

The names below are what programs outside the package use; each is imported when it is first used, because matplotlib takes a
second.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.reports.accuracy import OVERALL
    from frictionbench.reports.choice import Kind, choices, headline
    from frictionbench.reports.drawing.text import count, power, seconds
    from frictionbench.reports.noise import sentence, timing_noise
    from frictionbench.reports.page import write_report
    from frictionbench.reports.robustness import MapCells, map_cells
    from frictionbench.reports.run import Run, read_run
    from frictionbench.reports.settings import workers_on_all_cores
    from frictionbench.reports.tables import reliabilities
    from frictionbench.reports.templates import environment, script

__all__ = [
    "OVERALL",
    "Kind",
    "MapCells",
    "Run",
    "choices",
    "count",
    "environment",
    "headline",
    "map_cells",
    "power",
    "read_run",
    "reliabilities",
    "script",
    "seconds",
    "sentence",
    "timing_noise",
    "workers_on_all_cores",
    "write_report",
]
_FILES = {
    "accuracy": ("OVERALL",),
    "choice": ("Kind", "choices", "headline"),
    "drawing.text": ("count", "power", "seconds"),
    "noise": ("sentence", "timing_noise"),
    "page": ("write_report",),
    "robustness": ("MapCells", "map_cells"),
    "run": ("Run", "read_run"),
    "settings": ("workers_on_all_cores",),
    "tables": ("reliabilities",),
    "templates": ("environment", "script"),
}


def __getattr__(name: str) -> Any:
    for file, names in _FILES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{file}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
