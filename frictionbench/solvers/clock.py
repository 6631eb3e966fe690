"""The time limit of `solve`, which compiled loops check between their steps.

    with TimeLimit(seconds):             # holds for all solvers that are called inside, as by a portfolio
        until = deadline()               # s on the system's monotonic clock; infinity without a limit
        ...                              # in a kernel: stop with the best answer so far if late(until)

A long step that cannot be interrupted, such as a factorisation, is not begun if it would not end in time: deadline(operations)
is earlier by the time that so many operations take.

Without a time limit the clock is not read, and only counts decide. On systems without clock_gettime, such as Windows, kernels
run to their work limit.
"""

import time
from contextvars import ContextVar

import numpy as np
from numba import types

from frictionbench.problems.compiled import part

SPEED = 1e10  # operations per second of large factorisations: half of the rate measured on one core with AVX-512
_HAS_CLOCK = hasattr(time, "clock_gettime")
_MONOTONIC = int(time.CLOCK_MONOTONIC) if _HAS_CLOCK else 0
_deadline: ContextVar[float] = ContextVar("deadline", default=np.inf)
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.voidptr))


def _now() -> float:
    return time.clock_gettime(_MONOTONIC) if _HAS_CLOCK else time.monotonic()


class TimeLimit:
    """A context in which solvers may take `seconds`, infinity for no limit, within what an enclosing TimeLimit leaves.

    A portfolio enters one for each member; a context manager made from a generator would take several times as long.
    """

    __slots__ = ("seconds", "token")

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        limited = self.seconds < np.inf
        self.token = _deadline.set(min(_deadline.get(), _now() + self.seconds)) if limited else None

    def __exit__(self, *_: object) -> None:
        if self.token is not None:
            _deadline.reset(self.token)


def deadline(operations: float = 0.0) -> float:
    """The latest time at which a step of so many operations may begin, s on the monotonic clock; infinity without a limit."""
    return _deadline.get() - operations / SPEED


def left() -> float:
    """Seconds until the deadline, infinity without a limit."""
    until = _deadline.get()
    return until - _now() if until < np.inf else until


def is_over() -> bool:
    """Whether the deadline has passed."""
    return left() <= 0


def is_past(until: float) -> bool:
    """Whether the deadline `until` has passed."""
    return until < np.inf and _now() >= until


@part
def late(until: float) -> bool:
    """Whether the deadline `until` has passed, for kernels."""
    if not (_HAS_CLOCK and until < np.inf):
        return False
    now = np.empty(2, np.int64)  # a struct timespec: seconds and nanoseconds
    _clock_gettime(_MONOTONIC, now.ctypes)
    return bool(now[0] + 1e-9 * now[1] >= until)
