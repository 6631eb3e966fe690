"""Plans, runs, isolates, verifies and times.

The names below are what programs outside the package use; each is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.harness.cells.collect import stored_friction
    from frictionbench.harness.contract.examine import Found, examine
    from frictionbench.harness.plans import hard
    from frictionbench.harness.process import cores
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run import run as run_plan

__all__ = ["Found", "Progress", "cores", "examine", "hard", "run_plan", "stored_friction"]
_FILES = {
    "cells.collect": ("stored_friction",),
    "contract.examine": ("Found", "examine"),
    "process": ("cores",),
    "progress": ("Progress",),
    "run": ("run_plan",),
}


def __getattr__(name: str) -> Any:
    if name == "hard":
        return import_module(f"{__name__}.plans.hard")
    for file, names in _FILES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{file}"), {"run_plan": "run"}.get(name, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
