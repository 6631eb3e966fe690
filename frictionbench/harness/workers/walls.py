"""The walls around a plug-in: what keeps it from the files and the processes of the run, by the best means of this kernel.

    namespaces             it sees no process but its own, and the run's files are read-only (harness.workers.namespaces)
    landlock               it can signal no process but its own, nor write to the run's files (harness.workers.landlock)
    landlock, files only   it cannot write to the run's files: Linux before 6.12
    process groups         signals that it sends to its own group reach no other process of the run; nothing more

The run's files are its folder, this package, its compiled kernels, Python with all that it imports, and the plug-ins.
"""

import os
import site
import sys
from collections.abc import Iterable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from numba.core import caching, config

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers import landlock, namespaces
from frictionbench.problems.compiled import PACKAGE
from frictionbench.solvers.plugins import files

NAMESPACES, LANDLOCK, FILES_ONLY, GROUPS = "namespaces", "landlock", "landlock, files only", "process groups"


def best() -> str:
    """The best walls on this machine, tried in a process of its own."""
    pid = os.fork()
    if pid == 0:
        try:
            namespaces.protect([Path(sys.prefix).resolve()], Path(config.CACHE_DIR))
        except OSError:
            os._exit(1)
        os._exit(0)
    if os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0:
        return NAMESPACES
    found = landlock.version()
    return LANDLOCK if found >= landlock.SCOPES else FILES_ONLY if found else GROUPS


def confine(walls: str, folder: Path, plugins: Iterable[Plugin], owner: str) -> None:
    """Confine the calling process, before it runs the owner's code; with namespaces it returns in another process.

    The plug-in's own compiled kernels are cached in a folder of its own. Errors: OSError.
    """
    if walls == GROUPS:
        return
    caches = Path(config.CACHE_DIR).parent / "plugins"
    own = caches / sha256(owner.encode()).hexdigest()[:16]
    own.mkdir(parents=True, exist_ok=True)
    named = [file for plugin in plugins for file in files(plugin.source)]
    protected = _outermost([folder, folder / "problems", Path(config.CACHE_DIR), caches, *_code(), *named])
    (namespaces if walls == NAMESPACES else landlock).protect(protected, own.resolve())
    config.CACHE_DIR = str(own)
    _tolerate_read_only_caches()


def _code() -> list[Path]:
    """Where Python finds code."""
    places: list[str | Path] = [PACKAGE.parent, sys.prefix, sys.base_prefix, site.getusersitepackages(), *sys.path]
    return [Path(place) for place in places if place]


def _outermost(paths: list[Path]) -> list[Path]:
    """The existing ones among the paths, links resolved, without those inside another."""
    found = {path.resolve() for path in paths if path.exists()}
    return sorted(path for path in found if not any(parent in found for parent in path.parents))


def _tolerate_read_only_caches() -> None:
    """A kernel that is compiled here, and whose cache is read-only, is not cached; numba would raise."""
    save = caching.Cache.save_overload

    def tolerant(self: caching.Cache, *compiled: object) -> None:
        with suppress(OSError):
            save(self, *compiled)

    caching.Cache.save_overload = tolerant
