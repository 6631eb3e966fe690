"""The dependencies of a run's results besides this package: the files of its problems and all that its plug-ins load.

The main process hashes them. A run is resumed only if no hash has changed; those in a baseline show whether what both versions
of a plug-in load has. After each task, a plug-in's worker reports modules, shared libraries, files that Python or a forked
child opened for reading, and programs that it started. The suite's own libraries are reported by version. The standard library,
system folders, temporary and compiled files, and what the worker had loaded before are left out.
"""

import os
import shlex
import shutil
import sys
import tempfile
from contextlib import suppress
from importlib.machinery import SourceFileLoader
from itertools import islice
from pathlib import Path
from typing import Any

from frictionbench.harness.plans.plan import Plan, Plugin
from frictionbench.problems.compiled import PACKAGE
from frictionbench.results import store
from frictionbench.results.files import ResultsError, cleaned
from frictionbench.solvers import executable, plugins

SYSTEM = tuple(map(Path, ("/usr/lib", "/usr/lib64", "/lib", "/lib64", "/usr/bin", "/bin", "/etc", "/proc", "/sys", "/dev")))
MOST_READ = 20_000  # files read that are recorded for a plug-in: several times what large frameworks read
STARTED = ("subprocess.Popen", "os.posix_spawn", "os.exec", "os.system")  # audit events whose first argument is a program
MOST_HASHED = 50_000  # files of a package to hash: more than any has
COMPILED = (".pyc", ".nbi", ".nbc")  # suffixes of files compiled from modules
VERSION = "version "  # prefix of the version of a library, given in place of a path
Loaded = dict[str, str]  # name to a path, or to VERSION followed by a version


class _LoadWatch:
    """The modules and libraries loaded when this process began to watch, and the files that it has opened since."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self.known = {name.partition(".")[0] for name in sys.modules}
        self.before, self.libraries = set(sys.modules), set(_mapped())
        self.read: set[str] = set()
        self.written: set[str] = set()
        self.reported: set[str] = set()  # of what was read
        self.worker, self.forked = os.getpid(), os.memfd_create("opened by forked children")
        self.identity = os.fstat(self.forked)
        sys.addaudithook(self._heard)

    def _heard(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes | os.PathLike) and len(self.read) < MOST_READ:
            flags = arguments[2] if isinstance(arguments[2], int) else 0
            path = os.path.abspath(os.fsdecode(arguments[0]))
            fresh = flags & os.O_TRUNC or (flags & os.O_CREAT and not os.path.exists(path))  # nothing in it can be read
            self._add(path, self.written if flags & os.O_WRONLY or fresh else self.read)
        elif event in STARTED and (program := _program(event, arguments)):
            self._add(program, self.read)

    def _add(self, path: str, known: set[str]) -> None:
        """Add a file read or written. A forked child reports it to its worker by a file in memory, unless it closed that."""
        if os.getpid() != self.worker and path not in known:
            with suppress(OSError):
                if os.path.samestat(os.fstat(self.forked), self.identity):
                    os.write(self.forked, (b"w" if known is self.written else b"r") + os.fsencode(path) + b"\0")
        known.add(path)

    def add_forked(self) -> None:
        """Add what forked children have reported, so that later ones do not report it again."""
        for entry in os.fsdecode(os.pread(self.forked, os.fstat(self.forked).st_size, 0)).split("\0")[:-1]:
            (self.written if entry.startswith("w") else self.read).add(entry[1:])


_watch: _LoadWatch | None = None


def watch(folder: Path) -> None:
    """Begin to watch what this process, a worker of the run in folder, loads and reads."""
    global _watch  # noqa: PLW0603  # one per process: an audit hook cannot be removed
    SourceFileLoader.path_stats = _stats  # type: ignore[method-assign]
    _watch = _watch or _LoadWatch(folder)


_own_stats = SourceFileLoader.path_stats


def _stats(self: SourceFileLoader, path: str) -> Any:
    """Find no compiled file of a module that is not installed: it may be of another source of the same size and second."""
    if path.startswith(os.path.dirname(os.__file__)) or "-packages" in path:
        return _own_stats(self, path)
    raise OSError


def loaded() -> Loaded:
    """Return what this process has loaded since `watch`, and read since the last call."""
    if _watch is None:
        return {}
    named: Loaded = {}
    for name in sorted(set(sys.modules) - _watch.before):
        top = name.partition(".")[0]
        module = sys.modules.get(top)
        if top in sys.stdlib_module_names or top == PACKAGE.name or module is None:
            continue
        if top in _watch.known and getattr(module, "__file__", None):  # not a namespace package, which others may extend
            named[top] = f"{VERSION}{getattr(module, '__version__', '')}"
            continue
        for part, place in enumerate(getattr(module, "__path__", None) or [getattr(module, "__file__", None)], 1):
            if place:  # a namespace package has several
                folder = Path(place).name if name.startswith(plugins.MODULE) else top
                named[f"{folder} {part}" if part > 1 else folder] = os.path.abspath(place)  # not resolved: a link may change
    _watch.add_forked()
    read = {*_mapped(), *_watch.read} - _watch.libraries - _watch.written - _watch.reported
    _watch.reported |= read
    places = {_watch.folder, *(Path(place).resolve() for place in named.values()), *_left_out()}
    ours = [module for name, module in list(sys.modules.items()) if name.partition(".")[0] in _watch.known]
    known = {Path(file).resolve() for module in ours if (file := getattr(module, "__file__", None))}
    for path in map(_source, map(Path, read)):
        real, metadata = path.resolve(), path.parent.suffix in (".dist-info", ".egg-info")
        if real.is_file() and path.suffix not in COMPILED and not metadata and real not in known:
            named |= {str(path): str(path)} if places.isdisjoint((real, *real.parents)) else {}
    return named


def _program(event: str, arguments: tuple[Any, ...]) -> str | None:
    """Return the path of the program started by an audit event in STARTED, or None if it is not found."""
    named, words, folder, environment = arguments if event == "subprocess.Popen" else (arguments[0], [], None, None)
    if "-c" in words[1:2]:  # a shell
        event, named = "os.system", words[2]
    try:
        words = shlex.split(os.fsdecode(named)) if event == "os.system" else [os.fsdecode(named)]
        place = os.path.join(os.fsdecode(folder or ""), words[0]) if "/" in words[0] else words[0]
        found = shutil.which(place, path=(environment or os.environ).get("PATH"))
        return os.path.abspath(found) if found else None
    except (AttributeError, LookupError, TypeError, ValueError):
        return None


def _source(path: Path) -> Path:
    """Return the module's path for a compiled file: it may have been run, or removed from sys.modules after its import."""
    source = path.parent.parent / f"{path.name.partition('.')[0]}.py"
    return source if path.suffix == ".pyc" and path.parent.name == "__pycache__" else path


def _mapped() -> list[str]:
    """Return the files from which this process has mapped code."""
    with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
        entries = [line.split(maxsplit=5) for line in maps]
    return [entry[5].rstrip("\n") for entry in entries if len(entry) == 6 and "x" in entry[1] and entry[5].startswith("/")]


def _left_out() -> list[Path]:
    standard = [place for place in Path(os.__file__).parent.iterdir() if place.name not in ("site-packages", "dist-packages")]
    suite = [Path(place) for top in ("numpy", "scipy", "numba", "llvmlite") for place in sys.modules[top].__path__]
    places = [PACKAGE, Path(sys.executable), Path(tempfile.gettempdir()), *SYSTEM, *suite, *standard]
    return [place.resolve() for place in places]


def changed_content(plan: Plan, recorded: dict[str, str]) -> list[str]:
    """Return the places in `recorded`, the `content` of a manifest, whose hash is different now."""
    now = cleaned(initial_content(plan)["content"])  # in the form in which they are stored in the manifest
    return [place for place, digest in recorded.items() if (now.get(place) or place_hash(place)) != digest]


class LoadRecord:
    """What the plug-ins of a run have loaded so far. The manifest keeps it as `loaded`, by source and name, and `content`, the
    hashes by place of these and of the problems' files."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._seen: set[tuple[str, str, str]] = set()

    def add(self, source: str, loaded: Loaded) -> None:
        """Add what a worker has loaded for the plug-in of this source."""
        new = {(source, name, place) for name, place in loaded.items()} - self._seen
        if not new:
            return
        self._seen |= new
        manifest = store.read_manifest(self._folder)
        known = manifest["loaded"].setdefault(source, {})  # has the files that the source names, which a worker hashes again
        known |= {name: place for _, name, place in new if name != place or place not in known.values()}
        manifest["content"] |= {place: place_hash(place) for *_, place in new if place not in manifest["content"]}
        with suppress(ResultsError):  # too much is not recorded: half of the manifest is left for the run's own entries
            store.write_manifest(self._folder, manifest, share=0.5)


def initial_content(plan: Plan) -> dict[str, Any]:
    """Return the parts `loaded` and `content` of a manifest before anything has run. Files that do not exist yet are left out,
    such as the judged steps, which are named by their hashes."""
    files = {name for source in plan.sources for name in (source.file, source.before) if name}
    loaded = {plugin.source: _named_files(plugin) for plugin in plan.plugins}
    places = sorted(files | {place for known in loaded.values() for place in known.values()})
    return {"loaded": loaded, "content": {place: digest for place in places if (digest := place_hash(place))}}


def _named_files(plugin: Plugin) -> Loaded:
    """Return the files that a plug-in's source names, and the hash of an executable's command."""
    named_files = {path.name: str(path) for path in plugins.files(plugin.source)}
    if executable.is_command(plugin.source):
        named_files["command"] = f"{VERSION}{executable.command_hash(plugin.source)}"
    return named_files


def place_hash(place: str) -> str:
    """Return the hash of a file or folder, or the version if `place` is one; empty if it cannot be read or is too large, since
    a worker may report any path."""
    if place.startswith(VERSION):
        return place.removeprefix(VERSION)
    path = Path(place)
    try:
        files = [path] if path.is_file() else list(islice(filter(Path.is_file, path.rglob("*")), MOST_HASHED + 1))
        if not files or len(files) > MOST_HASHED or sum(each.stat().st_size for each in files) > plugins.LARGEST_HASHED:
            return ""
        return plugins.content_of(path)
    except OSError:
        return ""
