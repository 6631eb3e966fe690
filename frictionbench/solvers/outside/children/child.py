"""A child process that has a library loaded, and the messages to it through pipes.

The child is started by the first request and used for all that follow. It runs on its parent's core and under its memory limit,
and the kernel kills it when the parent ends. If the child dies, only the current request fails; the next one starts another.

A message consists of named numbers, texts and arrays of doubles, encoded without pickle: the length of its header (4 bytes),
the header in JSON, and the arrays' bytes in the header's order. The script of a child calls serve(answer); the reply to each
message is answer(**message). It imports only this file, in a Python in which this package may be missing.
"""

import ctypes
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_FOLDER = Path(__file__).parent


def send(stream: IO[bytes], message: Mapping[str, Any]) -> None:
    """Write a message, a mapping of numbers, texts and arrays."""
    arrays = {
        name: np.ascontiguousarray(value, dtype=float) for name, value in message.items() if isinstance(value, np.ndarray)
    }
    plain = {name: value for name, value in message.items() if name not in arrays}
    header = json.dumps([plain, {name: array.shape for name, array in arrays.items()}]).encode()
    stream.write(b"".join([len(header).to_bytes(4, "little"), header, *(array.tobytes() for array in arrays.values())]))
    stream.flush()


def receive(stream: IO[bytes]) -> dict[str, Any] | None:
    """Read a message; None if the other process has ended."""
    size = stream.read(4)
    header = stream.read(int.from_bytes(size, "little"))
    if len(size) < 4 or not header:
        return None
    message, shapes = json.loads(header)
    for name, shape in shapes.items():
        message[name] = np.frombuffer(bytearray(stream.read(8 * int(np.prod(shape))))).reshape(shape)
    return message


def serve(answer: Callable[..., Mapping[str, Any]]) -> None:
    """Reply to the parent's messages until the parent ends; the parent's process id is the script's first argument.

    On Linux the kernel kills this process when the parent ends, even in native code. Output of the library is discarded.
    """
    if hasattr(libc := ctypes.CDLL(None), "prctl"):
        libc.prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    if os.getppid() != int(sys.argv[1]):
        return
    replies = os.fdopen(os.dup(1), "wb")
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    while (message := receive(sys.stdin.buffer)) is not None:
        send(replies, answer(**message))


class DiedError(RuntimeError):
    """The child ended without a reply."""


class Child:
    """A script of this folder, or any script by its absolute path, in a process of the given Python."""

    def __init__(self, script: str, python: str) -> None:
        self._command = [python, str(_FOLDER / script), str(os.getpid())]
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, **message: Any) -> dict[str, Any]:
        """The reply to a message. Errors: DiedError, with the signal or exit code."""
        if self.pid is None:
            self.end()
            environment = os.environ | {"PYTHONPATH": str(_FOLDER)}  # scripts import this file
            self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        process: Any = self._process
        answer = None
        try:
            with suppress(BrokenPipeError):
                send(process.stdin, message)
                answer = receive(process.stdout)
        except BaseException:  # interrupted: a late reply would be taken for that to the next message
            self.end()
            raise
        if answer is None:
            code = process.wait()
            self.end()
            how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            raise DiedError(f"the library's process died: {how}")
        return answer

    def end(self) -> None:
        """Kill the child if it is running."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout):
                with suppress(BrokenPipeError):
                    pipe.close()  # type: ignore[union-attr]
        self._process = None

    @property
    def pid(self) -> int | None:
        """Its process id while it is running, or None."""
        return self._process.pid if self._process is not None and self._process.poll() is None else None


_children: dict[tuple[str, str], Child] = {}


def child(script: str, python: str = sys.executable) -> Child:
    """This process's child that runs a script; started by its first request."""
    return _children.setdefault((script, python), Child(script, python))


def living() -> list[int]:
    """The process ids of this process's running children."""
    return [child.pid for child in _children.values() if child.pid is not None]
