"""Problem files may come from anybody: how they are opened, and which arrays of them are read.

Files are opened only if they are regular and not too large: at a pipe or a device, or a link to one, reading would wait for
ever or never end. results.files does the same for results: what compares and reports them does without this package, which
takes longer to load than all else that they need.

An archive (.npz) is refused by its headers, before anything is unpacked: pickled objects, text, more than MAX_BYTES bytes, more
than MOST arrays, and methods of compression other than numpy's. An array of a name that no reader knows is refused too, since
what it holds would be left out of the problem.
"""

import os
import re
import stat
import zipfile
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from scipy import sparse

from frictionbench.problems.check import REAL, Array, InputError, require, require_consistent

COMPRESSION = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # those of numpy; others can need much memory to unpack
MOST = 1000  # arrays: far more than a problem has
LONGEST_HEADER = 2**16  # bytes of an array's header, which is read before its size is known
ENTRY = b"PK\x01\x02"  # begins each entry of an archive's directory
CHUNK = 2**24
MAX_BYTES = 4 * 2**30  # bytes unpacked; a larger archive is refused without unpacking it
ANSWERS = re.compile(r"[ru](_\w+)?")  # impulses and velocities that somebody found: not part of a problem


@contextmanager
def opened(path: Path, most: int) -> Iterator[BinaryIO]:
    """A regular file of at most `most` bytes, open for reading. Errors: InputError naming the file."""
    try:
        _require_regular(path, os.stat(path), most)  # to open a device can have effects
        file = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")  # does not wait for a pipe's writer
    except OSError as error:
        raise InputError(f"{path}: {'no such file' if isinstance(error, FileNotFoundError) else error.strerror}") from None
    with file:
        found = os.fstat(file.fileno())
        _require_regular(path, found, most)
        require(found.st_size > 0 or not file.read(1), str(path), "not a regular file: it states no size")  # as in /proc
        yield file


def _require_regular(path: Path, found: os.stat_result, most: int) -> None:
    require(stat.S_ISREG(found.st_mode), str(path), "not a regular file")
    require(found.st_size <= most, str(path), f"larger than the limit of {most / 2**30:g} GiB")


def read_arrays(path: Path) -> dict[str, Array]:
    """All arrays by name. Errors: InputError naming the file, or the array that cannot be used."""
    try:
        with opened(path, MAX_BYTES) as file:
            require(_listed(file) <= 2 * MOST, "archive", f"holds more than {MOST} arrays")
            archive = zipfile.ZipFile(file)
            names = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
            require(len(names) == len(archive.infolist()), "names", "several arrays have the same name")
            require(all(map(str.isprintable, names)), "names", "hold control characters")
            require(len(names) <= MOST, "archive", f"holds more than {MOST} arrays")
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
        raise InputError(f"{path}: not a problem file, or damaged") from None


def _listed(file: BinaryIO) -> int:
    """How often the mark of an entry of the archive's directory occurs in the file, about as often as there are entries.

    zipfile reads the whole directory before it tells their number.
    """
    found, end = 0, b""
    while part := file.read(CHUNK):
        found += (end + part).count(ENTRY)
        end = part[1 - len(ENTRY) :]
    return found


def _claimed(name: str, stream: IO[bytes]) -> int:
    """The size in bytes that an array's header states; an error where the data are shorter follows when it is read."""
    version = npy.read_magic(stream)
    require(version in ((1, 0), (2, 0)), name, f"has the unknown .npy format version {version}")
    shape, _, kind = (npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0)(stream)
    require(kind.kind in REAL, name, f"not an array of real numbers, but of {kind}")
    require(len(shape) <= 2 and min(shape, default=0) >= 0, name, f"expected a number, a vector or a matrix, got shape {shape}")
    return int(np.prod(shape, dtype=object)) * kind.itemsize


def require_known(names: Collection[str], known: Collection[str]) -> None:
    """Errors: InputError naming the first array that is neither known nor an answer, and all that are known."""
    for name in names:
        if name not in known and not ANSWERS.fullmatch(name):
            raise InputError(f"{name}: unknown array; known are {', '.join(sorted(known, key=str.lower))}")


@contextmanager
def in_letters(letters: dict[str, str]) -> Iterator[None]:
    """Errors within name the array that was given in place of the field that it was read as."""
    try:
        yield
    except InputError as error:
        field, _, reason = str(error).partition(": ")
        raise InputError(f"{letters.get(field, field)}: {reason}") from None


def sparse_matrix(field: str, kind: type[sparse.sparray], parts: Any, shape: Iterable[Any]) -> sparse.csr_array:
    """The matrix of the parts of a file, in the format of scipy that `kind` is. Errors: InputError naming the field."""
    try:
        matrix = kind(parts, shape=tuple(int(n) for n in shape))
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        raise InputError(f"{field}: not a sparse matrix ({error})") from None
    require_consistent(field, matrix)
    return sparse.csr_array(matrix)
