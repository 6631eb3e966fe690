"""The arrays of an .npz file, if they are plain numbers and not too large.

An archive is refused by its headers, before anything is unpacked: pickled objects, text, more than MAX_BYTES bytes, more than
MOST arrays, and methods of compression other than numpy's.
"""

import zipfile
from io import BytesIO
from pathlib import Path
from typing import IO, BinaryIO

import numpy as np
from numpy.lib import format as npy

from frictionbench.problems.check import REAL, Array, InputError, require
from frictionbench.problems.recorded.regular import opened

COMPRESSION = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # those of numpy; others can need much memory to unpack
MOST = 1000  # arrays: far more than a problem has
LONGEST_HEADER = 2**16  # bytes of an array's header, which is read before its size is known
ENTRY = b"PK\x01\x02"  # begins each entry of an archive's directory
CHUNK = 2**24
MAX_BYTES = 4 * 2**30  # bytes unpacked; a larger archive is refused without unpacking it


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
