"""Solvers from outside this repository: a file given on the command line, or an entry point of an installed distribution.

Either is a module whose import runs @solver on its classes, and a string says which: the path of a file, which ends in .py and
stands for all that it defines, or the name of an entry point in the group frictionbench.solvers, which is the solver's own:

    [project.entry-points."frictionbench.solvers"]
    mine = "my_package.solvers"

Importing one runs its code: the harness does so only in processes that run nothing else. What is installed is told apart by
its metadata alone; a name of ours stays ours.
"""

import importlib
import importlib.util
import sys
import traceback
from hashlib import sha256
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from frictionbench.problems import InputError
from frictionbench.solvers.interface import available

GROUP = "frictionbench.solvers"
FRAMES = 3  # of a traceback that describe_error names: enough to reach the plug-in's own code


def is_file(source: str) -> bool:
    """Whether it is a file that is meant, not the name of a solver."""
    return source.endswith(".py")


def installed() -> dict[str, EntryPoint]:
    """The entry points by name, the first of each, without those whose name is taken; nothing of theirs is run."""
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, point)
    return {name: point for name, point in sorted(found.items()) if name not in available()}


def content(source: str) -> str:
    """The hash of a solver's file, or of all files of an entry point's package. Errors: InputError naming the source."""
    try:
        if is_file(source):
            return sha256(Path(source).read_bytes()).hexdigest()
        digest = sha256()
        for home, path in _files(_point(source)):
            digest.update(f"{path.relative_to(home)}\0".encode() + sha256(path.read_bytes()).digest())
        return digest.hexdigest()
    except OSError as error:
        raise InputError(f"solver: {source} cannot be read ({error.strerror})") from None


def version(source: str) -> str:
    """What rows say of it: the file's name, or the distribution with its version, and the content."""
    return f"{Path(source).name if is_file(source) else distribution(_point(source))} {content(source)[:12]}"


def load(source: str) -> tuple[str, ...]:
    """Import a source as it is now; the names it adds. Errors: InputError naming it, and the line that fails."""
    return _load_file(Path(source)) if is_file(source) else _load_point(_point(source))


def _load_file(path: Path) -> tuple[str, ...]:
    module_name = f"frictionbench_plugin_{path.stem}_{content(str(path))[:12]}"
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


def _load_point(point: EntryPoint) -> tuple[str, ...]:
    if point.module in sys.modules:
        return ()
    try:
        importlib.import_module(point.module)
    except BaseException as error:
        raise InputError(f"solver: {point.name} of {distribution(point)} cannot be imported ({told(error)})") from error
    if point.name not in available():
        raise InputError(f"solver: {point.module} of {distribution(point)} defines no solver {point.name}")
    return (point.name,)


def _point(name: str) -> EntryPoint:
    """Errors: InputError where no distribution has such an entry point, or two have."""
    points = {(point.value, distribution(point)): point for point in entry_points(group=GROUP, name=name)}
    if not points:
        raise InputError(f"solver: no installed distribution has an entry point {name}")
    if len(points) > 1:
        raise InputError(f"solver: {name} is in {' and in '.join(sorted(where for _, where in points))}")
    (point,) = points.values()
    return point


def distribution(point: EntryPoint) -> str:
    """The name and version of the distribution that an entry point is of."""
    return f"{point.dist.name} {point.dist.version}" if point.dist else point.module


def _files(point: EntryPoint) -> list[tuple[Path, Path]]:
    """The files of the package or module that an entry point is in, each behind its folder; found without running them."""
    top = importlib.util.find_spec(point.module.partition(".")[0])
    if top is None:
        raise InputError(f"solver: {point.name} of {distribution(point)}: there is no module {point.module}")
    if not top.submodule_search_locations:
        path = Path(str(top.origin))
        return [(path.parent, path)]
    homes = [Path(place) for place in top.submodule_search_locations]
    return sorted(
        (home, path) for home in homes for path in home.rglob("*") if path.is_file() and "__pycache__" not in path.parts
    )
