"""Tasks in worker processes that may die.

Each worker runs one task at a time on a core of its own. A task that kills its worker, hangs, or leaves processes behind
affects no other: its supervisor (harness.workers.supervisor) ends it, and ends everything when this process ends. The death of
a worker that was killed from outside, or whose supervisor was, says nothing about the solver: the task is begun again, TRIES
times in all.
"""

import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from frictionbench.harness import machine, process
from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.workers.task import Outcome, Task
from frictionbench.results.store import ResultsError
from frictionbench.results.verdicts import Verdict

TRIES = 3
START = """import sys; sys.path.insert(0, sys.argv[1])
from frictionbench.harness.workers.supervisor import serve; serve(int(sys.argv[2]))"""
Settings = tuple[Path, tuple[Plugin, ...], int]


class _Server:
    """The process that forks the supervisors: started once, it ends with this process. It never looks into the current folder.

    Errors: ConnectionError where it ends before it says a word, ResultsError where it runs other code.
    """

    def __init__(self) -> None:
        process.pin_threads()
        self._control, far_end = socket.socketpair()
        command = [sys.executable, "-P", "-c", START, str(machine.PACKAGE.parent), str(far_end.fileno())]
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, pass_fds=[far_end.fileno()], start_new_session=True
        )
        far_end.close()
        with self._control.makefile("rb") as said:
            theirs, ours = said.readline(2**16), machine.code()
        if not theirs or json.loads(theirs) != ours:
            self.close()
            if not theirs:
                raise ConnectionError
            raise ResultsError(f"workers: they run {theirs.decode().strip()}, not {json.dumps(ours)}")

    def supervisor(self, settings: Settings) -> Connection:
        """The line to a new supervisor. Errors: OSError where the server is gone."""
        near, far = socket.socketpair()
        with far:
            socket.send_fds(self._control, [b"k"], [far.fileno()])
        channel = Connection(near.detach())
        channel.send(settings)
        return channel

    def close(self) -> None:
        """End the server and, by its hand, all that is below it."""
        self._control.close()
        self._process.wait()


_server: _Server | None = None


def _supervisor(settings: Settings) -> Connection:
    global _server  # noqa: PLW0603  # one a process: what workers need is imported once
    for _ in range(TRIES):  # it may be killed at any moment, as it starts too
        with suppress(OSError):
            _server = _server or _Server()
            return _server.supervisor(settings)
        if _server is not None:
            _server.close()
            _server = None
    raise ResultsError(f"workers: they do not start, tried {TRIES} times")


class _Hand:
    """One supervisor with its worker, the line to it, and the task it is at."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self.line = _supervisor(settings)
        self.task: Task | None = None
        self._tries = 0

    def give(self, task: Task) -> None:
        self.task = task
        self._tries += 1
        try:
            self.line.send(task)
        except OSError:
            self._begin_again()

    def take(self, compiling: Callable[[Task, bool], None]) -> Outcome | None:
        """The outcome of the task; None where it was begun again, or is compiling, which is told."""
        assert self.task is not None
        try:
            said: dict[str, Any] = json.loads(self.line.recv_bytes())
            said.pop("kept", None)  # its supervisor's business
        except (EOFError, OSError):
            if self._tries < TRIES:
                self._begin_again()
                return None
            self.line = _supervisor(self._settings)
            said = {"failure": Verdict.CRASHED.name, "reason": f"its processes were killed {TRIES} times"}
        if "compiling" in said:
            compiling(self.task, bool(said["compiling"]))
            return None
        if said.pop("again", False) and self._tries < TRIES:
            self.give(self.task)
            return None
        failure = Verdict[said["failure"]] if "failure" in said else None
        outcome = Outcome(self.task, said.get("value"), failure, said.get("reason", ""))
        self.task, self._tries = None, 0
        return outcome

    def _begin_again(self) -> None:
        assert self.task is not None
        self.line.close()
        self.line = _supervisor(self._settings)
        self.give(self.task)

    def dismiss(self) -> None:
        """Tell the supervisor to end, and wait until everything below it has."""
        with suppress(OSError, EOFError):
            self.line.send(None)
            while self.line.poll(2 * process.PATIENCE):
                self.line.recv_bytes()
        self.line.close()


class Pool:
    """Workers for one run; use as a context manager.

    Errors: InputError on a platform that cannot isolate them, ResultsError where they would not run this very code.
    """

    def __init__(self, folder: Path, jobs: int, plugins: tuple[Plugin, ...], memory_limit: int) -> None:
        process.require_linux()
        self._hands = [_Hand((folder.absolute(), plugins, memory_limit)) for _ in range(jobs)]

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        for hand in self._hands:
            hand.dismiss()

    def run(
        self,
        tasks: Iterable[Task],
        started: Callable[[Task], None] = lambda task: None,
        compiling: Callable[[Task, bool], None] = lambda task, now: None,
    ) -> Iterator[Outcome]:
        """Every task's outcome as it comes; started is called when a task is handed out, compiling when its worker begins to
        compile and when it is done with that."""
        queue = iter(tasks)
        while True:
            for hand in self._hands:
                if hand.task is None and (task := next(queue, None)) is not None:
                    hand.give(task)
                    started(task)
            busy = {hand.line: hand for hand in self._hands if hand.task is not None}
            if not busy:
                return
            for line in wait(list(busy)):
                if (outcome := busy[line].take(compiling)) is not None:  # type: ignore[index]
                    yield outcome
