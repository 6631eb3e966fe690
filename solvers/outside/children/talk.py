"""What parent and child say to each other through pipes: numbers and texts by name, and arrays of doubles. No pickle.

A message is the length of its head (4 bytes), the head in JSON, and the arrays' bytes in the head's order. A child's script
calls serve(answer): every message is answered by what answer(**message) returns.
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
    head = json.dumps([plain, {name: array.shape for name, array in arrays.items()}]).encode()
    stream.write(b"".join([len(head).to_bytes(4, "little"), head, *(array.tobytes() for array in arrays.values())]))
    stream.flush()


def receive(stream: IO[bytes]) -> dict[str, Any] | None:
    """Read a message; None where the other side has ended."""
    size = stream.read(4)
    head = stream.read(int.from_bytes(size, "little"))
    if len(size) < 4 or not head:
        return None
    message, shapes = json.loads(head)
    for name, shape in shapes.items():
        message[name] = np.frombuffer(bytearray(stream.read(8 * int(np.prod(shape))))).reshape(shape)
    return message


def serve(answer: Callable[..., Mapping[str, Any]]) -> None:
    """Answer the parent's messages until it ends; the parent's process id is the script's first argument.

    The kernel ends this process with its parent, whatever native code it is in (Linux). What the library prints goes nowhere.
    """
    if hasattr(libc := ctypes.CDLL(None), "prctl"):
        libc.prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    if os.getppid() != int(sys.argv[1]):
        return
    replies = os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    while (message := receive(sys.stdin.buffer)) is not None:
        send(replies, answer(**message))
