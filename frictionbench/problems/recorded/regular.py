"""Problem files may come from anybody: they are opened only if they are regular files and not too large.

At a pipe or a device, or a link to one, reading would wait for ever or never end. results.files does the same for results:
what compares and reports them does without this package, which takes longer to load than all else that they need.
"""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from frictionbench.problems.check import InputError, require


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
