"""The standard streams of a command, set up so that a failure to write is not mistaken for a result.

Exit code 1 means a regression, but Python and typer also exit with 1 if a pipe is closed early, a disk is full or a terminal
cannot encode a character. Here, a stream that cannot be written raises Unwritable, for which the command has its own exit code.
Characters that a stream cannot encode are replaced by question marks. A closed stream is replaced by the null device.
"""

import io
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EPIPE
from typing import Any

UNUSABLE = 2  # exit code


class Unwritable(Exception):  # noqa: N818  # not an error of the input
    """A standard stream that cannot be written. number: its file descriptor; reason: the operating system's error."""

    def __init__(self, number: int, reason: OSError) -> None:
        super().__init__(f"{'standard output' if number == 1 else 'standard error'}: {reason.strerror}")
        self.number, self.reason = number, reason


class _Stream(io.FileIO):
    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            raise Unwritable(self.fileno(), error) from None


@contextmanager
def standard_streams() -> Iterator[None]:
    """Run a command's block with these streams. If one cannot be written, exit with 141 (128 + SIGPIPE) and no message if its
    reader has ended, otherwise with 2 and a line on the other stream."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:  # closed: the next file that is opened would be given its number
            os.dup2(os.open(os.devnull, os.O_RDWR), number)
    for number, name in ((1, "stdout"), (2, "stderr")):
        if getattr(sys, name) is getattr(sys, f"__{name}__"):  # unless a caller has redirected it
            setattr(sys, name, _stream(number, getattr(sys, name)))
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except Unwritable as unwritable:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, unwritable.number)  # takes what is still buffered, or the interpreter would report the error again
        if unwritable.reason.errno == EPIPE:
            sys.exit(128 + signal.SIGPIPE)
        with suppress(Unwritable):
            print(f"frictionbench: {unwritable}", file=sys.stderr, flush=True)
        sys.exit(UNUSABLE)


def _stream(number: int, replaced: Any) -> io.TextIOWrapper:
    encoding = getattr(replaced, "encoding", None) or "utf-8"
    lines = number == 2 or os.isatty(number)
    written = io.BufferedWriter(_Stream(number, "w", closefd=False))
    return io.TextIOWrapper(written, encoding, errors="replace", line_buffering=lines)
