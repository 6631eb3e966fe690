"""The dependencies of a run's results besides this package: the files of its problems and all that its plug-ins load.

The main process hashes them. A run is resumed only if no hash has changed; those in a baseline show whether what both versions
of a plug-in load has. After each task, a plug-in's worker reports modules, shared libraries, files that Python or a forked
child opened for reading, and programs that it started. The suite's own libraries are reported by version. The standard library,
system folders, temporary files, numba's cache, and what the worker had loaded before are left out. Paths are `quoted`.
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
from string import punctuation
from typing import Any
from urllib.parse import quote, unquote_to_bytes

from numba import config

from frictionbench.harness.plans.plan import Plan
from frictionbench.problems.compiled import PACKAGE
from frictionbench.results import store
from frictionbench.results.files import ResultsError, cleaned
from frictionbench.solvers import executable, plugins

SYSTEM = tuple(map(Path, ("/usr/lib", "/usr/lib64", "/lib", "/lib64", "/usr/bin", "/bin", "/etc", "/proc", "/sys", "/dev")))
MOST_READ = 20_000  # files read that are recorded for a plug-in: several times what large frameworks read
OPENED = ("open", "ctypes.dlopen", "import")  # audit events that state a file; an import only of a compiled module
STARTED = ("subprocess.Popen", "os.posix_spawn", "os.exec", "os.system")  # audit events whose first argument is a program
MOST_HASHED = 50_000  # files of a package to hash: more than any has
VERSION = "version:"  # prefix of the version of a library, given in place of a path; `quoted` leaves it as it is
UNKNOWN = {"what could not be recorded": VERSION}  # has no hash, so that it is equal to nothing
KERNELS = Path(config.CACHE_DIR)  # the cache of this suite, instead of which a plug-in's worker is given another
Loaded = dict[str, str]  # name to a path, or to VERSION followed by a version


class LoadWatch:
    """The modules and libraries loaded when this process, a worker of the run in folder, began to watch, and the files that it
    has opened since. One per process: an audit hook cannot be removed."""

    def __init__(self, folder: Path) -> None:
        self.known = {name.partition(".")[0] for name in sys.modules}
        self.before, self.libraries = set(sys.modules), set(_mapped())
        self.left_out = {folder.resolve(), *_left_out(self.known)}
        self.read: set[str] = set()
        self.written: set[str] = set()
        self.reported: set[str] = set()  # of what was read
        self.worker, self.forked = os.getpid(), os.memfd_create("opened by forked children")
        self.identity = os.fstat(self.forked)
        SourceFileLoader.path_stats = _stats  # type: ignore[method-assign]
        sys.addaudithook(self._heard)

    def _heard(self, event: str, arguments: tuple[Any, ...]) -> None:
        with suppress(Exception):  # as where the current folder is gone: it would reach the plug-in
            if event in OPENED:
                self._add_opened(event, arguments)
            elif event in STARTED and (program := _program(event, arguments)):
                self._add(program, self.read)

    def _add_opened(self, event: str, arguments: tuple[Any, ...]) -> None:
        named = arguments[event == "import"]
        if not isinstance(named, str | bytes | os.PathLike) or len(self.read) >= MOST_READ:
            return
        path = os.path.abspath(os.fsdecode(named))
        flags = arguments[2] if event == "open" and isinstance(arguments[2], int) else 0
        fresh = flags & os.O_TRUNC or (flags & os.O_CREAT and not os.path.exists(path))  # nothing in it can be read
        self._add(path, self.written if flags & os.O_WRONLY or fresh else self.read)

    def _add(self, path: str, known: set[str]) -> None:
        """Add a file read or written. A forked child reports it to its worker by a file in memory, unless it closed that."""
        if path in known:
            return
        known.add(path)
        if os.getpid() != self.worker and os.path.samestat(os.fstat(self.forked), self.identity):
            os.write(self.forked, (b"w" if known is self.written else b"r") + os.fsencode(path) + b"\0")

    def loaded(self) -> Loaded:
        """Return what this process has loaded, and read since the last call. No error of it ends the call of a plug-in."""
        try:
            return self._loaded()
        except Exception:
            return UNKNOWN

    def _loaded(self) -> Loaded:
        named: Loaded = {}
        for name in sorted(set(sys.modules) - self.before, key=str):
            with suppress(Exception):  # of a module that computes its attributes; its file was read
                named |= _module(name, self.known)
        for entry in os.fsdecode(os.pread(self.forked, os.fstat(self.forked).st_size, 0)).split("\0")[:-1]:
            (self.written if entry.startswith("w") else self.read).add(entry[1:])  # or later children would report it again
        read = {*_mapped(), *self.read} - self.libraries - self.written - self.reported
        self.reported |= read
        places = {*self.left_out, *(Path(place).resolve() for place in named.values())}
        for name in read:
            with suppress(OSError, RuntimeError):  # a loop of links, or one that may not be followed: nothing was read there
                path = _source(Path(name))
                real, metadata = path.resolve(), path.parent.suffix in (".dist-info", ".egg-info")
                if real.is_file() and not metadata and places.isdisjoint((real, *real.parents)):
                    named[str(path)] = str(path)
        return {quoted(name): quoted(place) for name, place in named.items()}


_own_stats = SourceFileLoader.path_stats


def _stats(self: SourceFileLoader, path: str) -> Any:
    """Find no compiled file of a module that is not installed: it may be of another source of the same size and second."""
    if path.startswith(os.path.dirname(os.__file__)) or "/site-packages/" in path or "/dist-packages/" in path:
        return _own_stats(self, path)
    raise OSError


def _module(name: str, known: set[str]) -> Loaded:
    """Return the places of a module's top package, or the version of one that was known before."""
    top = name.partition(".")[0]
    module = sys.modules[top]
    if top in sys.stdlib_module_names or top == PACKAGE.name:
        return {}
    if top in known and getattr(module, "__file__", None):  # not a namespace package, which others may extend
        version = getattr(module, "__version__", None)
        return {top: f"{VERSION}{version}"} if version else {}
    named = {}
    for part, place in enumerate(getattr(module, "__path__", None) or [getattr(module, "__file__", None)], 1):
        if place and os.path.exists(place):  # a namespace package has several, or a name of its finder in place of a path
            folder = Path(place).name if name.startswith(plugins.MODULE) else top
            named[f"{folder}:{part}" if part > 1 else folder] = os.path.abspath(place)  # not resolved: a link may change
    return named


def _program(event: str, arguments: tuple[Any, ...]) -> str | None:
    """Return the path of the program started by an audit event in STARTED, or None if it is not found."""
    named, words, folder, environment = arguments if event == "subprocess.Popen" else (arguments[0], [], None, None)
    if "-c" in words[1:2]:  # a shell
        event, named = "os.system", words[2]
    words = shlex.split(os.fsdecode(named)) if event == "os.system" else [os.fsdecode(named)]
    place = os.path.join(os.fsdecode(folder or ""), words[0]) if "/" in words[0] else words[0]
    found = shutil.which(place, path=(environment or os.environ).get("PATH"))
    return os.path.abspath(found) if found else None


def _source(path: Path) -> Path:
    """Return the module's path for a compiled file: it may have been run, or removed from sys.modules after its import."""
    source = path.parent.parent / f"{path.name.partition('.')[0]}.py"
    return source if path.suffix == ".pyc" and path.parent.name == "__pycache__" and source.is_file() else path


def _mapped() -> list[str]:
    """Return the files from which this process has mapped code."""
    with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
        entries = [line.split(maxsplit=5) for line in maps]
    return [entry[5].rstrip("\n") for entry in entries if len(entry) == 6 and "x" in entry[1] and entry[5].startswith("/")]


def _left_out(known: set[str]) -> list[Path]:
    """Return the places of Python, the system, temporary files, numba's caches, this suite and the modules known so far."""
    standard = [place for place in Path(os.__file__).parent.iterdir() if place.name not in ("site-packages", "dist-packages")]
    modules = [sys.modules[top] for top in known if getattr(sys.modules.get(top), "__file__", None)]
    suite = [Path(place) for module in modules for place in getattr(module, "__path__", [module.__file__])]
    caches = [Path(tempfile.gettempdir()), KERNELS, Path(config.CACHE_DIR)]
    return [place.resolve() for place in (PACKAGE, Path(sys.executable), *caches, *SYSTEM, *suite, *standard)]


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
    files = {name: place_hash(quoted(name)) for source in plan.sources for name in (source.file, source.before) if name}
    loaded = {}
    for source in (plugin.source for plugin in plan.plugins):
        loaded[source] = {quoted(path.name): quoted(str(path)) for path in plugins.files(source)}
        if executable.is_command(source):
            loaded[source][executable.COMMAND] = f"{VERSION}{executable.command_hash(source)}"
    content = files | {place: place_hash(place) for known in loaded.values() for place in known.values()}
    return {"loaded": loaded, "content": {place: digest for place, digest in sorted(content.items()) if digest}}


def quoted(path: str) -> str:
    """Return the path percent-encoded (RFC 3986), so that any name can be written, and no two become one."""
    return quote(os.fsencode(path), safe=punctuation.translate({ord("%"): "", ord(";"): ""}))


def unquoted(text: str) -> str:
    """Return the path that is `quoted` as this text."""
    return os.fsdecode(unquote_to_bytes(text))


def place_hash(place: str) -> str:
    """Return the hash of a file or folder, or the version if `place` is one; empty if it cannot be read or is too large, since
    a worker may report any path, `quoted`."""
    if place.startswith(VERSION):
        return place.removeprefix(VERSION)
    path = Path(unquoted(place))
    try:
        files = [path] if path.is_file() else list(islice(filter(Path.is_file, path.rglob("*")), MOST_HASHED + 1))
        if not files or len(files) > MOST_HASHED or sum(each.stat().st_size for each in files) > plugins.LARGEST_HASHED:
            return ""
        return plugins.content_of(path)
    except (OSError, ValueError):
        return ""
