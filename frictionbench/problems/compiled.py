"""The cache of compiled kernels: a folder for every version of the kernels' source.

Numba's cache detects changes in the file of a kernel, but not in kernels that it calls from other files: outdated code would
run and be measured as the current code. Therefore the cache folder is named by a hash of all files with kernels, so that every
checkout uses its own folder. If the user's cache folder is not writable, a folder of the user in the system's temporary folder
is used. NUMBA_CACHE_DIR, if set, replaces the user's cache folder.
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

PACKAGE = Path(__file__).absolute().parents[1]
FOLDERS = ("problems", "solvers")

# A kernel is called from Python and cached on disk. A loop processes many problems and releases the interpreter's lock. An
# inlined function is inserted into its caller before type inference, because it takes less time than a call.
kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
loop = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, nogil=True)
inlined = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, inline="always")
# A kernel that neither creates nor returns arrays. References to arrays are not counted: the atomic counts for the tuples of
# arrays that it passes on would take two thirds of the time of a pivot on ten unknowns. Numba refuses code that needs counts.
lean_kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, _nrt=False)

# A loop without reference counts. Otherwise all threads that read an array would write its count in turn, which takes longer
# than to solve a problem of few contacts.
lean_loop = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, nogil=True, _nrt=False)


def part(function: Callable[..., Any], counted: bool = True) -> Any:
    """A compiled function that only kernels call. It has no wrapper for Python, which would take longer to compile than it."""
    compiled = njit(error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, _nrt=counted)(function)
    if isinstance(compiled, CPUDispatcher):  # with NUMBA_DISABLE_JIT it is the Python function
        compiled.__class__ = _Part
    return compiled


def lean(function: Callable[..., Any]) -> Any:
    """A part that neither creates nor returns arrays; see lean_kernel."""
    return part(function, counted=False)


class _Part(CPUDispatcher):
    def __call__(self, *_: object) -> NoReturn:
        raise TypeError(f"{self.py_func.__name__} can only be called from a compiled kernel: it has no wrapper for Python")


def state(package: Path) -> str:
    """A hash of the names and contents of all files of a package with kernels."""
    digest = sha256()
    for path in sorted(path for folder in FOLDERS for path in (package / folder).rglob("*.py")):
        text = path.read_bytes()
        if any(word in text for word in (b"njit", b"frictionbench.problems.compiled")):
            digest.update(f"{path.relative_to(package).as_posix()}\0{len(text)}\0".encode() + text)
    return digest.hexdigest()[:16]


def _writable(name: str) -> Path:
    """The cache folder for this version. Its files are executed, so in a shared place the folder must belong to this user."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    usual = Path(chosen) if chosen else user_cache_path("frictionbench") / "compiled"
    spare = Path(tempfile.gettempdir()) / f"frictionbench-{getpass.getuser()}"
    for above in (usual, spare):
        with suppress(OSError):
            (above / name).mkdir(parents=True, exist_ok=True)
            if above is spare:
                spare.chmod(0o700)  # fails if the folder belongs to another user
            if os.access(above / name, os.W_OK):
                return above / name
    return usual / name


config.CACHE_DIR = str(_writable(state(PACKAGE)))  # before the first kernel is declared
