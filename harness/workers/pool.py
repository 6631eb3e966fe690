"""Tasks in worker processes that may die.

Each worker runs one task at a time on a core of its own. A task that kills its worker costs itself alone: another worker
takes its place. The hard limit proper is the worker's own alarm (harness.machine.hard_limit); a process that escapes it is
killed from outside a grace period later. A worker's end is seen by its sentinel, whatever its exit code: a solver that calls
exit(0) has died too.
"""

import multiprocessing
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext
from pathlib import Path
from typing import Any

from harness import machine
from harness.cells import worker

GRACE = 120.0  # seconds beyond the limit for loading, compiling and repeats, before a worker is killed from outside


@dataclass(frozen=True)
class Task:
    """A call of function(*arguments) in a worker; limit in seconds; name for the screen."""

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float


@dataclass(frozen=True)
class Outcome:
    """What a task returned; or how it died: `death` is "timeout" or "crashed", with the reason."""

    task: Task
    value: Any = None
    death: str | None = None
    reason: str = ""


class _Hand:
    """One worker process, the pipe to it, and the task it is at."""

    def __init__(self, context: ForkServerContext, settings: tuple[Any, ...]) -> None:
        self.pipe, far_end = context.Pipe()
        self.process = context.Process(target=_work, args=(far_end, settings), daemon=True)
        self.process.start()
        far_end.close()
        self.task: Task | None = None
        self.deadline = float("inf")

    def give(self, task: Task) -> None:
        self.task, self.deadline = task, time.monotonic() + task.limit + GRACE
        self.pipe.send((task.function, task.arguments))

    def take(self) -> Outcome | None:
        """The outcome of the task, if there is one by now; a worker that is dead afterwards must be replaced."""
        assert self.task is not None
        task = self.task
        try:
            if self.pipe.poll():
                outcome = Outcome(task, **self.pipe.recv())
            elif not self.process.is_alive():
                outcome = self._died(task)
            elif time.monotonic() > self.deadline:
                self.kill()
                outcome = Outcome(task, death="timeout", reason=f"killed {GRACE:g} s past its limit of {task.limit:g} s")
            else:
                return None
        except (EOFError, OSError):
            outcome = self._died(task)
        self.task, self.deadline = None, float("inf")
        return outcome

    def _died(self, task: Task) -> Outcome:
        self.process.join()
        code = self.process.exitcode or 0
        if code == -signal.SIGALRM:
            return Outcome(task, death="timeout", reason=f"stopped at its limit of {task.limit:g} s")
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return Outcome(task, death="crashed", reason=f"the process died: {how}")

    def kill(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


class Pool:
    """Workers for one run; use as a context manager."""

    leaves_rows = True  # a worker writes the row of its cell itself, before anyone hears of it

    def __init__(self, folder: Path, jobs: int, plugins: tuple[str, ...], memory_limit: int) -> None:
        machine.pin_threads()
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(["harness.cells.worker"])
        self._settings = (folder, plugins, memory_limit)
        self._hands = [_Hand(self._context, self._settings) for _ in range(jobs)]

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        for hand in self._hands:
            hand.kill()

    def run(self, tasks: Iterable[Task], started: Callable[[Task], None] = lambda task: None) -> Iterator[Outcome]:
        """Every task's outcome as it comes; started is called when a task is handed out."""
        queue = iter(tasks)
        while True:
            for i, hand in enumerate(self._hands):
                if hand.task is None and (task := next(queue, None)) is not None:
                    if not hand.process.is_alive():
                        self._hands[i] = hand = _Hand(self._context, self._settings)  # noqa: PLW2901
                    hand.give(task)
                    started(task)
            busy = [hand for hand in self._hands if hand.task is not None]
            if not busy:
                return
            left = max(0.0, min(hand.deadline for hand in busy) - time.monotonic())
            wait([end for hand in busy for end in (hand.pipe, hand.process.sentinel)], timeout=left)
            yield from (outcome for hand in busy if (outcome := hand.take()) is not None)


def _work(pipe: Connection, settings: tuple[Any, ...]) -> None:
    """A worker's life: calls come through the pipe, what they return goes back; it ends with the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    worker.start(*settings)
    while True:
        try:
            function, arguments = pipe.recv()
        except EOFError:
            return
        try:
            sent = {"value": function(*arguments)}
        except Exception as error:
            sent = {"death": "crashed", "reason": f"{type(error).__name__}: {error}"[:500]}
        pipe.send(sent)
