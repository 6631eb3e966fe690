"""The time that `solve` may take, which compiled loops look at between their steps.

    with TimeLimit(seconds):             # holds for all solvers that are called inside, as by a portfolio
        until = deadline()               # s on the system's monotonic clock; infinity without a limit
        ...                              # in a kernel: stop with the best answer so far if late(until)

A step that takes long and cannot be interrupted, such as a factorisation, is not begun where it would not end in time:
deadline(operations) is earlier by the time that so many operations take.

Without a limit the clock is not read, and nothing but counts decides. Where the system has no clock_gettime, as Windows,
kernels run on to their limit of work.
"""

import time
from contextvars import ContextVar

import numpy as np
from numba import types

from frictionbench.problems.compiled import part

SPEED = 1e10  # operations a second of large factorisations: half of what one core with AVX-512 was measured to reach
_HAS_CLOCK = hasattr(time, "clock_gettime")
_MONOTONIC = int(time.CLOCK_MONOTONIC) if _HAS_CLOCK else 0
_deadline: ContextVar[float] = ContextVar("deadline", default=np.inf)
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.voidptr))


def _now() -> float:
    return time.clock_gettime(_MONOTONIC) if _HAS_CLOCK else time.monotonic()


class TimeLimit:
    """A block whose solvers may take so many seconds, infinity for no limit, and never more than a block around it leaves.

    A portfolio enters one for each member; a generator's context manager would take several times as long.
    """

    __slots__ = ("seconds", "token")

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def __enter__(self) -> None:
        self.token = _deadline.set(min(_deadline.get(), _now() + self.seconds))

    def __exit__(self, *_: object) -> None:
        _deadline.reset(self.token)


def deadline(operations: float = 0.0) -> float:
    """When the last step of so many operations may begin, s on the monotonic clock; infinity without a limit."""
    return _deadline.get() - operations / SPEED


def left() -> float:
    """Seconds until the deadline, infinity without a limit."""
    until = _deadline.get()
    return until - _now() if until < np.inf else until


def is_over() -> bool:
    """Whether the time has ended."""
    return left() <= 0


def is_past(until: float) -> bool:
    """Whether a deadline has passed."""
    return until < np.inf and _now() >= until


@part
def late(until: float) -> bool:
    """Whether the time has ended, for kernels."""
    if not (_HAS_CLOCK and until < np.inf):
        return False
    now = np.empty(2, np.int64)  # a struct timespec: seconds and nanoseconds
    _clock_gettime(_MONOTONIC, now.ctypes)
    return bool(now[0] + 1e-9 * now[1] >= until)
