"""The moment after which a worker is killed, in memory that it shares with its supervisor.

The worker writes until when it may run; its supervisor (harness.workers.supervisor), another process, kills it past that. No
signal is involved that a solver could block, and native code is stopped like any other. The clock is the system's monotonic
one: setting the date does nothing.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from mmap import mmap
from time import monotonic

COMPILING = 600.0  # seconds numba may take at a time, whatever the limit
OURS = 600.0  # seconds for what is not a solver's: reading a problem, verifying


class Deadline:
    """Made by the supervisor before it forks the worker, so that both see the same bytes."""

    def __init__(self) -> None:
        self._moment = memoryview(mmap(-1, 16)).cast("d")
        self.allow(OURS)

    @property
    def compiling(self) -> bool:
        """Whether numba is at work in a block within a limit; it is, for a moment, when it reads its cache."""
        return bool(self._moment[1])

    @property
    def left(self) -> float:
        """Seconds."""
        return self._moment[0] - monotonic()

    def allow(self, seconds: float) -> None:
        """The process may run for so long from now."""
        self._moment[0] = monotonic() + seconds

    @contextmanager
    def within(self, seconds: float) -> Iterator[Callable[[float], None]]:
        """End this process where the block takes longer; the clock stands still while numba compiles or reads its cache.

        Yields a function that sets the time left anew, in seconds.
        """
        from numba.core import event

        deadline = self

        class Pause(event.Listener):
            depth, left = 0, 0.0  # compilations nest

            def on_start(self, _: object) -> None:
                if not self.depth:
                    self.left = deadline.left
                    deadline.allow(COMPILING)
                    deadline._moment[1] = 1.0
                self.depth += 1

            def on_end(self, _: object) -> None:
                self.depth -= 1
                if not self.depth:
                    deadline._moment[1] = 0.0
                    deadline.allow(self.left)

        try:
            with event.install_listener("numba:compiler_lock", Pause()):
                self.allow(seconds)
                yield self.allow
        finally:
            self._moment[1] = 0.0
            self.allow(OURS)
