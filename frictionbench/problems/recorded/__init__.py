"""Reading of problems from files, one module per format. The format is recognised by the content of the file.

FCLIB's HDF5              problems.recorded.fclib       read and written
Siconos's text            problems.recorded.siconos     friction problems, local and global, and LCPs
the package's own .npz    problems.recorded.native      read and written
arrays in an .npz         problems.recorded.plain       M, N, T, mu, v or W, q, mu, d; an LCP's M, q; ContactBench's G, g, mus
"""

from pathlib import Path

from frictionbench.problems.check import Array, InputError, require
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded import fclib, native, plain, siconos
from frictionbench.problems.recorded.archive import MAX_BYTES, opened, read_arrays

HDF5, ZIP, NUMPY = b"\x89HDF\r\n\x1a\n", b"PK\x03\x04", b"\x93NUMPY"


def read(path: Path) -> FrictionProblem | LCP:
    """The problem in a file of any of these formats. Errors: InputError naming the file and the invalid field."""
    return read_recording(path)[0]


def read_recording(path: Path) -> tuple[FrictionProblem | LCP, tuple[Array, ...]]:
    """The problem and the initial guesses (nc, d) of its impulses, which FCLIB's files may contain. Errors: as in read."""
    with opened(path, MAX_BYTES) as file:
        head = file.read(8)
    if head[:4] == ZIP:
        return _archive(path), ()
    require(bool(head), str(path), "is empty")
    require(not head.startswith(NUMPY), str(path), "holds one array; numpy.savez writes an .npz with those of a problem")
    hdf5 = head == HDF5
    require(hdf5 or head.lstrip()[:1].isdigit(), str(path), "no problem file; known are .npz, FCLIB's .hdf5, Siconos' text")
    try:
        return fclib.read(path) if hdf5 else (siconos.read(path), ())
    except InputError as error:
        raise InputError(f"{path}: {'' if hdf5 else 'read as the text of Siconos: '}{error}") from None


def _archive(path: Path) -> FrictionProblem | LCP:
    arrays = read_arrays(path)
    if native.holds(arrays):
        return native.read(path, arrays)[0]
    reader = plain.kind(arrays)
    try:
        if reader is None:
            names = ", ".join(list(arrays)[:8])[:80]
            raise InputError(f"holds {names}; expected M, N, T, mu, v, or W, q, mu, d, or an LCP's M, q")
        return reader(arrays)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
