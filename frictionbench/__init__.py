"""Compare solvers for the friction LCPs of rigid-body dynamics: `import frictionbench as fb`.

The names below are imported when they are first used, so that a part of the package costs only what it needs.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictionbench.problems import LCP, FrictionProblem, InputError, scene, scenes
    from frictionbench.solvers import Answer, Status, available, solve, solver

__all__ = ["LCP", "Answer", "FrictionProblem", "InputError", "Status", "available", "scene", "scenes", "solve", "solver"]


def __getattr__(name: str) -> Any:
    for package in ("frictionbench.problems", "frictionbench.solvers") if name in __all__ else ():
        if hasattr(found := importlib.import_module(package), name):
            return getattr(found, name)
    raise AttributeError(f"module 'frictionbench' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
