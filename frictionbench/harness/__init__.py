"""Plans, runs, isolates, verifies and times.

The names below are what programs outside the package use; each is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.harness.cells.collect import stored_friction
    from frictionbench.harness.contract.examine import Found, examine
    from frictionbench.harness.machine import content
    from frictionbench.harness.plans import families, hard
    from frictionbench.harness.plans.plan import Plan, Source
    from frictionbench.harness.plans.recorded import located
    from frictionbench.harness.process import cores
    from frictionbench.harness.progress import Progress
    from frictionbench.harness.run import run as run_plan

__all__ = [
    "Found",
    "Plan",
    "Progress",
    "Source",
    "content",
    "cores",
    "examine",
    "families",
    "hard",
    "located",
    "run_plan",
    "stored_friction",
]
_FILES = {
    "cells.collect": ("stored_friction",),
    "contract.examine": ("Found", "examine"),
    "machine": ("content",),
    "plans.plan": ("Plan", "Source"),
    "plans.recorded": ("located",),
    "process": ("cores",),
    "progress": ("Progress",),
    "run": ("run_plan",),
}


def __getattr__(name: str) -> Any:
    if name in ("families", "hard"):
        return import_module(f"{__name__}.plans.{name}")
    for file, names in _FILES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{file}"), {"run_plan": "run"}.get(name, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
