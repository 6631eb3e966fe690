"""The deadline of a worker, in memory that it shares with its supervisor.

The worker writes the time until which it may run. Its supervisor, another process, kills it after that time; a solver cannot
block this as it could block a signal. Times are read from the monotonic clock, which does not change when the date is set.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from mmap import mmap
from time import monotonic
from typing import Any

from frictionbench.problems.compiled import PACKAGE

COMPILE_SECONDS = 600.0  # seconds in which our code may compile in a block: far more than any kernel takes, in case one hangs
HARNESS_SECONDS = 600.0  # seconds for the harness's own work, such as reading and verifying: also a bound in case it hangs


class Deadline:
    """Created by the supervisor before it forks the worker, so that both share the memory."""

    def __init__(self) -> None:
        self._moment = memoryview(mmap(-1, 8)).cast("d")
        self._met: set[Any] = set()
        self.allow(HARNESS_SECONDS)

    @property
    def left(self) -> float:
        """Seconds until the deadline."""
        return self._moment[0] - monotonic()

    def allow(self, seconds: float) -> None:
        """Set the deadline to this many seconds from now."""
        self._moment[0] = monotonic() + seconds

    @contextmanager
    def within(self, seconds: float, compiling: float = COMPILE_SECONDS, ours: bool = False) -> Iterator[None]:
        """End this process if the block takes longer.

        compiling: the seconds spent by numba in compiling or reading its cache that are not counted; those beyond are. ours:
        whether only functions of this package stop the clock in this way, each once for its argument types. Otherwise any
        code that sends numba's event could stop it.
        """
        from numba.core import event

        deadline, outer = self, self._moment[0]

        class Pause(event.Listener):
            depth, left, begun, budget, stops = 0, 0.0, 0.0, compiling, False  # compilations nest

            def on_start(self, _: object) -> None:
                if not self.depth:
                    self.stops = self.budget > 0 and (not ours or deadline._met_first())
                if not self.depth and self.stops:
                    self.left, self.begun = deadline.left, monotonic()
                    deadline.allow(self.left + self.budget)
                self.depth += 1

            def on_end(self, _: object) -> None:
                self.depth -= 1
                if not self.depth and self.stops:
                    self.budget -= monotonic() - self.begun
                    deadline.allow(self.left + min(self.budget, 0.0))

        try:
            with event.install_listener("numba:compiler_lock", Pause()):
                self.allow(seconds)
                yield
        finally:
            self._moment[0] = max(outer, monotonic() + HARNESS_SECONDS)

    def _met_first(self) -> bool:
        """Return whether numba is compiling or loading a function of this package for the first time for its argument types."""
        from numba.core.dispatcher import Dispatcher

        frame = sys._getframe(1)
        while frame.f_back is not None and frame.f_code is not Dispatcher.compile.__code__:
            frame = frame.f_back
        function, types = frame.f_locals.get("self"), str(frame.f_locals.get("sig"))
        if not isinstance(function, Dispatcher) or (function, types) in self._met:
            return False
        self._met.add((function, types))
        return function.py_func.__code__.co_filename.startswith(f"{PACKAGE}{os.sep}")
