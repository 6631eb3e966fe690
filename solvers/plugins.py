"""Solvers from outside this repository: a file given on the command line, or the entry points of an installed package.

Either is a module whose import runs @solver on its classes. Importing a file runs its code: the harness does so only in
processes that run nothing else.
"""

import importlib.util
import sys
import traceback
from hashlib import sha256
from importlib.metadata import entry_points
from pathlib import Path

from problems import InputError
from solvers.interface import available

GROUP = "frictionbench.solvers"
FRAMES = 3  # told of an error


def content(path: Path) -> str:
    """The hash of a solver's file. Errors: InputError naming the file."""
    try:
        return sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"solver: {path} cannot be read ({error.strerror})") from None


def load(path: Path) -> tuple[str, ...]:
    """Import a solver's file as it is now; the names it adds. Errors: InputError naming the file, and the line that fails."""
    module_name = f"frictionbench_plugin_{path.stem}_{content(path)[:12]}"
    if module_name in sys.modules:
        return ()
    before = set(available())
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise InputError(f"solver: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException as error:  # a plug-in may exit
        del sys.modules[module_name]
        raise InputError(f"solver: {path} cannot be imported ({told(error)})") from error
    added = tuple(sorted(set(available()) - before))
    if not added:
        raise InputError(f"solver: {path} defines no solver (decorate a class with @solver)")
    return added


def told(error: BaseException) -> str:
    """An error in one line, with the file and line of its last frames, the innermost first."""
    frames = traceback.extract_tb(error.__traceback__)[: -FRAMES - 1 : -1]
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno} in {frame.name}" for frame in frames)
    try:
        text = str(error)
    except Exception as another:  # the error's own code
        text = f"and its message cannot be told: {type(another).__name__}"
    return " ".join(f"{type(error).__name__}: {text}"[:400].split()) + (f" (at {places})" if places else "")


def load_entry_points() -> None:
    """Import every installed package's solvers. Errors: InputError naming the entry point."""
    for point in entry_points(group=GROUP):
        try:
            point.load()
        except Exception as error:
            raise InputError(f"solver: entry point {point.name} cannot be loaded ({error})") from error
