"""Where compiled kernels are kept between runs: a folder for every state of the kernels' source.

numba's cache notices that the file of a kernel has changed, but not that a kernel it calls, in another file, has: the old code
would go on running, and be measured under the new code's name. So the cache lies in a folder named by the content of all files
that hold kernels; an older checkout finds its own again. Where the user's cache folder cannot be written, one of the user's own
in the system's temporary folder takes its place. NUMBA_CACHE_DIR, where it is set, says under which folder instead.
"""

import getpass
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any, NoReturn

from numba import njit
from numba.core import config
from numba.core.registry import CPUDispatcher
from platformdirs import user_cache_path

PACKAGE = Path(__file__).absolute().parents[1]  # links are not resolved: in a checkout its subpackages are links
FOLDERS = ("problems", "solvers")

# What Python calls is a kernel, kept from run to run. What is inlined becomes the caller's own code before that is typed: where
# a call would cost more than what it does.
kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
inlined = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, inline="always")


def part(function: Callable[..., Any]) -> Any:
    """Called by kernels only: a way in from Python would, for a tuple of arrays, take longer to compile than the part."""
    compiled = njit(error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True)(function)
    if isinstance(compiled, CPUDispatcher):  # and not the function itself, where numba is told to compile nothing
        compiled.__class__ = _Part
    return compiled


class _Part(CPUDispatcher):
    def __call__(self, *_: object) -> NoReturn:
        raise TypeError(f"{self.py_func.__name__} is a part of kernels, to be called from one: there is no way in from Python")


def keep_compiled() -> None:
    """Tell numba where to keep what it compiles; to be called before the first kernel is declared."""
    config.CACHE_DIR = str(_writable(state(PACKAGE)))


def state(package: Path) -> str:
    """A hash of all files with kernels of a package, by name and content."""
    digest = sha256()
    for path in sorted(path for folder in FOLDERS for path in (package / folder).rglob("*.py")):
        text = path.read_bytes()
        if any(word in text for word in (b"njit", b"frictionbench.problems.compiled")):
            digest.update(f"{path.relative_to(package).as_posix()}\0{len(text)}\0".encode() + text)
    return digest.hexdigest()[:16]


def _writable(name: str) -> Path:
    """The folder for this state; what lies in it is executed, so one in a place open to all must be the user's own."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    usual = Path(chosen) if chosen else user_cache_path("frictionbench") / "compiled"
    spare = Path(tempfile.gettempdir()) / f"frictionbench-{getpass.getuser()}"
    for above in (usual, spare):
        with suppress(OSError):
            (above / name).mkdir(parents=True, exist_ok=True)
            if above is spare:
                spare.chmod(0o700)  # fails where it is somebody else's
            if os.access(above / name, os.W_OK):
                return above / name
    return usual / name
