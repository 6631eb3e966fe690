"""Safe opening of problem files, which may come from untrusted sources, and reading of their arrays.

The headers of an archive (.npz) are checked before anything is unpacked. Pickled objects, text, more than MAX_BYTES bytes, more
than MOST_ARRAYS and compression methods other than numpy's are refused. An array with an unknown name is refused too, because
its data would be missing in the problem.
"""

import re
import zipfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from scipy import sparse

from frictionbench.problems.check import REAL, Array, InputError, require, require_consistent
from frictionbench.regular import regular

COMPRESSION = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the methods of numpy; unpacking others can need much memory
MOST_ARRAYS = 1000  # arrays: far more than a problem has
LONGEST_HEADER = 2**16  # bytes of an array's header, which is read before its size is known
ENTRY = b"PK\x01\x02"  # the start of each entry in an archive's directory
CHUNK = 2**24
MAX_BYTES = 4 * 2**30  # bytes unpacked; a larger archive is refused without unpacking it
ANSWERS = re.compile(r"[ru](_\w+)?")  # impulses and velocities of answers, which are not part of a problem


@contextmanager
def opened(path: Path, most: int) -> Iterator[BinaryIO]:
    """A regular file of at most `most` bytes, open for reading. Errors: InputError naming the file."""
    with ExitStack() as stack:
        try:
            file = stack.enter_context(regular(path, most))
        except OSError as error:
            reason = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
            raise InputError(f"{path}: {reason}") from None
        yield file


def read_arrays(path: Path) -> dict[str, Array]:
    """All arrays by name. Errors: InputError naming the file, or the array that cannot be used."""
    try:
        with opened(path, MAX_BYTES) as file:
            require(_listed(file) <= 2 * MOST_ARRAYS, "archive", f"holds more than {MOST_ARRAYS} arrays")
            archive = zipfile.ZipFile(file)
            names = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
            require(len(names) == len(archive.infolist()), "names", "several arrays have the same name")
            require(all(map(str.isprintable, names)), "names", "hold control characters")
            require(len(names) <= MOST_ARRAYS, "archive", f"holds more than {MOST_ARRAYS} arrays")
            left = MAX_BYTES
            for name, entry in names.items():
                require(entry.compress_type in COMPRESSION, name, "is compressed by another method than deflate")
                with archive.open(entry) as stream:
                    left -= _claimed(name, BytesIO(stream.read(LONGEST_HEADER)))
                require(left >= 0, name, f"unpacks to more than {MAX_BYTES / 2**30:g} GiB")
            arrays = {}
            for name, entry in names.items():
                with archive.open(entry) as stream:
                    arrays[name] = npy.read_array(stream, allow_pickle=False)
            return arrays
    except InputError as error:
        raise InputError(str(error) if str(error).startswith(str(path)) else f"{path}: {error}") from None
    except Exception:  # a damaged archive raises errors of zipfile, zlib, struct, tokenize and others
        raise InputError(f"{path}: not an .npz file, or damaged") from None


def _listed(file: BinaryIO) -> int:
    """The number of occurrences of ENTRY in the file, which is about the number of entries.

    zipfile reads the whole directory before it gives their number.
    """
    entries, end = 0, b""
    while part := file.read(CHUNK):
        entries += (end + part).count(ENTRY)
        end = part[1 - len(ENTRY) :]
    return entries


def _claimed(name: str, stream: IO[bytes]) -> int:
    """The size in bytes that an array's header states. If the data are shorter, reading the array raises an error."""
    version = npy.read_magic(stream)
    require(version in ((1, 0), (2, 0)), name, f"has the unknown .npy format version {version}")
    shape, _, kind = (npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0)(stream)
    require(kind.kind in REAL, name, f"not an array of real numbers, but of {kind}")
    require(len(shape) <= 2 and min(shape, default=0) >= 0, name, f"expected a number, a vector or a matrix, got shape {shape}")
    return int(np.prod(shape, dtype=object)) * kind.itemsize


def require_known(names: Collection[str], known: Collection[str]) -> None:
    """Errors: InputError naming the first array that is neither known nor an answer, and all known names."""
    for name in names:
        if name not in known and not ANSWERS.fullmatch(name):
            raise InputError(f"{name}: unknown array; known are {', '.join(sorted(known, key=str.lower))}")


@contextmanager
def in_letters(letters: dict[str, str]) -> Iterator[None]:
    """In errors raised within, replace the name of a field by that of the array in the file. letters: field: array."""
    try:
        yield
    except InputError as error:
        field, _, reason = str(error).partition(": ")
        raise InputError(f"{letters.get(field, field)}: {reason}") from None


def sparse_matrix(field: str, kind: type[sparse.sparray], parts: Any, shape: Iterable[Any]) -> sparse.csr_array:
    """The matrix with these parts, given in SciPy's sparse format `kind`. Errors: InputError naming the field."""
    try:
        matrix = kind(parts, shape=tuple(int(n) for n in shape))
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise InputError(f"{field}: not a sparse matrix ({error})") from None
    require_consistent(field, matrix)
    return sparse.csr_array(matrix)
