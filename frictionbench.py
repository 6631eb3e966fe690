"""The public face: `import frictionbench as fb`, then fb.scene, fb.FrictionProblem, fb.solve and what else is listed below.

The packages behind it are named for what they are (problems, solvers, ...) and stand beside this file. Where others of these
names come first on Python's path they would be imported instead: that is refused here, by name. `frictionbench` and
`python -m frictionbench` are the command line.
"""

import importlib
import importlib.util
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from problems import LCP, FrictionProblem, InputError, scene, scenes
    from solvers import Answer, Status, available, solve, solver

__all__ = ["LCP", "Answer", "FrictionProblem", "InputError", "Status", "available", "scene", "scenes", "solve", "solver"]
_HERE = Path(__file__).resolve().parent


def _refuse_strangers() -> None:
    """Errors: ImportError where a package that is not ours hides one that is."""
    for package in ("problems", "solvers", "harness", "results", "reports"):
        spec = importlib.util.find_spec(package)
        places = spec.submodule_search_locations if spec else None
        if not places or Path(next(iter(places))).resolve() != _HERE / package:
            where = next(iter(places), None) if places else spec.origin if spec else None
            raise ImportError(f"{where} hides frictionbench's own {package!r}: rename it, or take it off Python's path")


def __getattr__(name: str) -> Any:
    for package in ("problems", "solvers") if name in __all__ else ():
        if hasattr(found := importlib.import_module(package), name):
            return getattr(found, name)
    raise AttributeError(f"module 'frictionbench' has no attribute {name!r}")


def main() -> Any:
    """The command line."""
    from harness.cli import main as command_line

    return command_line()


if __name__ == "__main__":
    if Path.cwd() != _HERE:  # python -m puts the current folder first
        sys.path[:] = [entry for entry in sys.path if entry not in ("", os.getcwd())]
    try:
        _refuse_strangers()
    except ImportError as stranger:
        sys.exit(f"frictionbench: {stranger}")
    sys.exit(main())
_refuse_strangers()
