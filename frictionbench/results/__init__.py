"""What a run stores: tables with their schema, files beside them, and the comparison of two runs.

The names below are what programs outside the package use; each is imported when it is first used, because pandas and pyarrow
take half a second.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.problems.verdicts import measured
    from frictionbench.results.conventions import RankBy, scene_title
    from frictionbench.results.files import ResultsError, read_json, subfolder, write_text
    from frictionbench.results.schema import TABLES
    from frictionbench.results.store import read_table

__all__ = [
    "TABLES",
    "RankBy",
    "ResultsError",
    "measured",
    "read_json",
    "read_table",
    "scene_title",
    "subfolder",
    "write_text",
]
_FILES = {
    "conventions": ("RankBy", "scene_title"),
    "files": ("ResultsError", "read_json", "subfolder", "write_text"),
    "schema": ("TABLES",),
    "store": ("read_table",),
    "verdicts": ("measured",),
}


def __getattr__(name: str) -> Any:
    for file, names in _FILES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{file}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
