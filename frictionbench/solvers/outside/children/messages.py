"""Messages between parent and child process through pipes: named numbers, texts and arrays of doubles, without pickle.

A message is the length of its header (4 bytes), the header in JSON, and the arrays' bytes in the header's order. The script of
a child calls serve(answer): the reply to each message is what answer(**message) returns.
"""

import ctypes
import json
import os
import signal
import sys
from collections.abc import Callable, Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
