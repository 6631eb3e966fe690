"""Solvers from outside this repository: a file given on the command line, or an entry point of an installed distribution.

A source is a module that registers its classes with @solver when it is imported, or an executable. It is named by the path of
a file that ends in .py, which stands for all solvers that the file defines; by a command that begins with exec:, for an
executable (solvers.executable); or by an entry point in the group frictionbench.solvers, whose name is that of the solver.

Importing a source runs its code, so the harness imports it only in worker processes. Installed plug-ins are listed from their
metadata, without importing them. A plug-in cannot replace a solver of this package.
"""

import importlib
import importlib.util
import os
import sys
import traceback
from contextlib import suppress
from hashlib import file_digest, sha256
from importlib.metadata import EntryPoint, EntryPoints, distributions
from itertools import accumulate, chain
from pathlib import Path

from numba import config
from numba.core import caching

from frictionbench.problems.check import InputError, require
from frictionbench.regular import regular
from frictionbench.solvers import executable
from frictionbench.solvers.interface import available

GROUP = "frictionbench.solvers"
MODULE = "frictionbench_plugin_"  # prefix of the module name of a file
LARGEST_HASHED = 16 * 2**30  # bytes of a file, or of a package: more than any has, and takes a minute
FRAMES = 4  # of a traceback in describe_error: enough to reach the plug-in's own code, also if @solver raised the error
CALLERS = (f"{Path(__file__).parents[1] / 'harness'}{os.sep}", __file__)  # code that calls a plug-in, and explains no error


def is_file(source: str) -> bool:
    """Whether the source is the path of a Python file."""
    return source.endswith(".py") and not executable.is_command(source)


def defines_all(source: str) -> bool:
    """Whether the source stands for all solvers that it defines; an entry point stands for the one that it names."""
    return is_file(source) or executable.is_command(source)


def absolute(source: str) -> str:
    """A file or command with absolute paths. Errors: InputError naming the command."""
    return executable.absolute(source) if executable.is_command(source) else str(Path(source).absolute())


def files(source: str) -> list[Path]:
    """The files that the source names."""
    return executable.files(source) if executable.is_command(source) else [Path(source)] if is_file(source) else []


def places(source: str) -> list[Path]:
    """The files that the source names, or the package's folder or the module's file of an entry point, found without running
    its code. Errors: InputError naming the entry point."""
    if named := files(source):
        return named
    point = _point(source)
    with suppress(ValueError, ImportError):  # for __main__, and below a part that does not exist
        for name in accumulate(point.module.split("."), "{}.{}".format):  # namespace packages have no code and no origin
            if (spec := importlib.util.find_spec(name)) and spec.origin:
                return [Path(spec.origin).parent if "." in name or spec.submodule_search_locations else Path(spec.origin)]
    raise InputError(f"solver: {point.name} of {distribution(point)}: the module {point.module} does not exist")


def installed() -> dict[str, EntryPoint]:
    """The entry points by name, the first of each name, except names that are registered already; none is imported."""
    by_name = {point.name: point for point in reversed(_points())}
    return {name: point for name, point in sorted(by_name.items()) if name not in available()}


def content(source: str) -> str:
    """The SHA-256 of a solver's files, or of all files of an entry point's package. Errors: InputError naming the source."""
    try:
        return executable.content(source) if executable.is_command(source) else content_of(places(source)[0])
    except OSError as error:
        raise InputError(f"solver: {source} cannot be read ({error.strerror})") from None


def content_of(path: Path) -> str:
    """The SHA-256 of a file, or of the names and contents of all files in a folder except compiled ones. Errors: OSError."""
    if not path.is_dir():
        with regular(path, LARGEST_HASHED) as opened:  # another process may put a pipe in its place
            return file_digest(opened, "sha256").hexdigest()
    digest = sha256()
    for file in sorted(each for each in path.rglob("*") if each.is_file() and "__pycache__" not in each.parts):
        digest.update(f"{file.relative_to(path)}\0".encode() + bytes.fromhex(content_of(file)))
    return digest.hexdigest()


def version(source: str) -> str:
    """The version in the tables: the file's name, or the distribution and its version, and the start of the content hash."""
    named = files(source)
    return f"{named[0].name if named else distribution(_point(source))} {content(source)[:12]}"


def load(source: str) -> tuple[str, ...]:
    """Import a source; the names of the solvers that it adds. Errors: InputError naming the source and the failing line."""
    if executable.is_command(source):
        return (executable.register(source),)
    point = None if is_file(source) else _point(source)
    name = point.module if point else f"{MODULE}{Path(source).stem}_{content(source)[:12]}"
    if name in sys.modules and not point:
        return ()
    before, by = set(available()), f" of {distribution(point)}" if point else ""
    try:
        if point:
            importlib.import_module(name)
        else:
            _import_file(name, source)
    except BaseException as error:  # a plug-in may also call sys.exit
        raise InputError(f"solver: {source}{by} cannot be imported ({describe_error(error)})") from error
    added = tuple(sorted(available().keys() - before))
    require(point is None or source in available(), "solver", f"{name}{by} defines no solver {source}")
    require(bool(point or added), "solver", f"{source} defines no solver; decorate a class with @solver")
    return (source,) if point else added


def _import_file(name: str, path: str) -> None:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    sys.modules[name] = importlib.util.module_from_spec(spec)
    try:  # not the compiled file, which may be of another source of the same size and time, as when a link has changed
        exec(compile(Path(path).read_bytes(), path, "exec"), vars(sys.modules[name]))
    except BaseException:
        del sys.modules[name]
        raise


def describe_error(error: BaseException) -> str:
    """An error in one line, with the file and line of its last frames, the innermost first; of an executable there are none."""
    if isinstance(error, SyntaxError):  # its text names the file and the line; its frames are those of the import
        return f"{type(error).__name__}: {error}"
    files = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<")]
    own = [frame for frame in files if not frame.filename.startswith(CALLERS)] or files
    frames = [] if any(frame.filename == executable.__file__ for frame in own) else own[: -FRAMES - 1 : -1]
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno} in {frame.name}" for frame in frames)
    try:
        text = str(error)
    except Exception as another:  # str() runs code of the plug-in
        text = f"its message cannot be formatted: {type(another).__name__}"
    description = " ".join(f"{type(error).__name__}: {text}"[:400].split()) + (f" (at {places})" if places else "")
    damaged = bool(frames) and frames[0].filename == caching.__file__
    return description + (f"; compiled kernels are damaged: delete {config.CACHE_DIR}" if damaged else "")


def _points() -> list[EntryPoint]:
    """The entry points of the group, without distributions whose metadata cannot be read, as a line without `=`."""
    by_distribution: dict[str, EntryPoints] = {}  # the first of a name, which Python imports
    for each in distributions():
        with suppress(TypeError, ValueError):
            if points := each.entry_points.select(group=GROUP):
                by_distribution.setdefault(each.name, points)
    return list(chain.from_iterable(by_distribution.values()))


def _point(name: str) -> EntryPoint:
    """The entry point of this name. Errors: InputError if not exactly one distribution declares it, or it names no module."""
    points = {(point.value, distribution(point)): point for point in _points() if point.name == name}
    require(bool(points), "solver", f"no installed distribution declares an entry point {name} in the group {GROUP}")
    declared = " and by ".join(sorted(where for _, where in points))
    require(len(points) == 1, "solver", f"{name} is declared by {declared}; uninstall all but one")
    (point,) = points.values()
    require(bool(point.pattern.match(point.value)), "solver", f"{name} of {declared} names no module, but {point.value!r}")
    return point


def distribution(point: EntryPoint) -> str:
    """The name and version of the distribution that declares an entry point."""
    return f"{point.dist.name} {point.dist.version}" if point.dist else point.module
