"""Files of others are opened only if they are regular and not too large.

At a pipe or a device, or a link to one, reading would wait for ever or never end.
"""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path


@contextmanager
def regular(path: Path, most: int) -> Iterator[BufferedReader]:
    """A regular file of at most `most` bytes, open for reading. Errors: OSError with the reason as its strerror."""
    _require(os.stat(path), most)  # to open a device can have effects
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC  # does not wait for a pipe's writer
    with os.fdopen(os.open(path, flags), "rb") as file:
        status = os.fstat(file.fileno())
        _require(status, most)
        if not status.st_size and file.read(1):
            raise OSError(errno.EINVAL, "not a regular file: it states no size")  # as in /proc
        yield file


def _require(status: os.stat_result, most: int) -> None:
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, "not a regular file")
    if status.st_size > most:
        raise OSError(errno.EFBIG, f"larger than the limit of {most / 2**20:g} MiB")
