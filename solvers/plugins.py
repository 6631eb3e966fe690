"""Solvers from outside this repository: a file given on the command line, or the entry points of an installed package.

Either is a module whose import runs @solver on its classes.
"""

import importlib.util
import sys
from importlib.metadata import entry_points
from pathlib import Path

from problems import InputError
from solvers.interface import available

GROUP = "frictionbench.solvers"


def load(path: Path) -> tuple[str, ...]:
    """Import a solver's file; the names it adds. Errors: InputError naming the file."""
    module_name = f"frictionbench_plugin_{path.stem}"
    if module_name in sys.modules:
        return ()
    before = set(available())
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise InputError(f"solver: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        raise InputError(f"solver: {path} cannot be imported ({type(error).__name__}: {error})") from error
    added = tuple(sorted(set(available()) - before))
    if not added:
        raise InputError(f"solver: {path} defines no solver (decorate a class with @solver)")
    return added


def load_entry_points() -> None:
    """Import every installed package's solvers. Errors: InputError naming the entry point."""
    for point in entry_points(group=GROUP):
        try:
            point.load()
        except Exception as error:
            raise InputError(f"solver: entry point {point.name} cannot be loaded ({error})") from error
