"""Tasks in isolated worker processes.

Each worker runs one task at a time on its own core. A task that crashes its worker, hangs, or leaves processes running affects
no other task: a supervisor (harness.workers.supervisor) ends it, and ends everything when this process ends. If a worker or its
supervisor is killed from outside, the task is run again, up to TRIES times in all.
"""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from multiprocessing.connection import Connection, wait
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any

from frictionbench.harness import machine, process
from frictionbench.harness.dependencies import Loaded
from frictionbench.harness.plans.plan import MEMORY_LIMIT, Plugin
from frictionbench.problems import InputError
from frictionbench.problems.compiled import PACKAGE
from frictionbench.problems.verdicts import Verdict
from frictionbench.results.files import ResultsError, cleaned

# Bytes, and lists and objects in them: bound the memory of the main process. The longest row, with curves, is far shorter.
LONGEST_REPLY, MOST_LISTS = 32 * 2**20, 2**20
DURING = {"loaded", "compiling"}  # what a worker reports while it runs a task
TRIES = 3  # one kill may be an accident, such as a moment's lack of memory, but not three in a row
# Workers inherit sys.argv, in which a plug-in must not find these arguments and take them for its own.
START = """import sys; sys.path.insert(0, sys.argv.pop(1))
from frictionbench.harness.workers.supervisor import serve; serve(int(sys.argv.pop(1)))"""
Settings = tuple[Path, tuple[Plugin, ...], int]


@dataclass(frozen=True)
class Task:
    """A call of function(*arguments) in a worker, whose value is sent back as JSON.

    limit: seconds. whole: whether the limit applies to the whole call, or to a part of it that the function limits itself, such
    as the solver's call. owner: the plug-in's solver that it runs, or empty.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float
    owner: str = ""
    whole: bool = True


@dataclass(frozen=True)
class Outcome:
    """The value that a task returned or, if it failed, the verdict (TIMEOUT or CRASHED) and the reason.

    refused: whether it raised InputError, whose message is the reason. loaded: what the worker of a plug-in has loaded so far,
    see harness.dependencies.
    """

    task: Task
    value: Any = None
    failure: Verdict | None = None
    reason: str = ""
    refused: bool = False
    loaded: Loaded = field(default_factory=dict)

    def result(self, otherwise: str) -> Any:
        """Return the task's value. Errors: InputError as the task raised it, or of `otherwise` and the reason if it failed."""
        if self.failure:
            raise InputError(self.reason if self.refused else f"{otherwise} ({self.reason})")
        return self.value


class _Server:
    """The process that forks the supervisors. It is started once, ends with this process and imports nothing from its folder.

    sandbox: the plug-ins' sandbox, see harness.workers.sandbox. scratch: a folder that it removes when it
    ends. Errors: ConnectionError with the reason if it ends before it reports its code, ResultsError if it runs other code.
    """

    def __init__(self) -> None:
        os.environ.update(dict.fromkeys(process.ONE_THREAD, "1"))
        self._control, far_end = socket.socketpair()
        command = [sys.executable, "-P", "-c", START, str(PACKAGE.parent), str(far_end.fileno())]
        with TemporaryFile() as errors:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                pass_fds=[far_end.fileno()],
                start_new_session=True,
            )
            far_end.close()
            with self._control.makefile("rb") as report:
                line = report.readline(2**16)
            if not line:
                self.close()
                errors.seek(0)
                errors_printed = errors.read().decode(errors="replace").strip().splitlines()
                raise ConnectionError(errors_printed[-1] if errors_printed else "it was killed")
        theirs, ours = json.loads(line), machine.code()
        self.sandbox, self.scratch = str(theirs["sandbox"]), str(theirs["scratch"])
        if theirs["code"] != ours:
            self.close()
            raise ResultsError(
                f"workers: they run other code, {json.dumps(theirs['code'])}, than this process, {json.dumps(ours)}"
            )

    def supervisor(self, settings: Settings) -> Connection:
        """Start a supervisor and return the connection to it. Errors: OSError if the server has ended."""
        near, far = socket.socketpair()
        with far:
            socket.send_fds(self._control, [b"k"], [far.fileno()])
        channel = Connection(near.detach())
        channel.send(settings)
        return channel

    def close(self) -> None:
        """End the server, which ends all its descendants."""
        self._control.close()
        self._process.wait()


_server: _Server | None = None


def _asked(question: Callable[[_Server], Any]) -> Any:
    """Return the server's answer; it is started if it does not run. Errors: ResultsError with the reason if it cannot be."""
    process.require_linux()
    global _server  # noqa: PLW0603  # one per process, so that the workers' modules are imported once
    reason = ""
    for _ in range(TRIES):  # the server may be killed at any moment, even while it starts
        try:
            _server = _server or _Server()
            return question(_server)
        except OSError as error:
            reason = str(error)
        if _server is not None:
            _server.close()
            _server = None
    raise ResultsError(f"workers: their server did not start in {TRIES} attempts ({reason})")


class _Slot:
    """The connection to one supervisor, and the task that its worker runs."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._connect()
        self.task: Task | None = None
        self._tries = 0
        self._loaded: Loaded = {}

    def _connect(self) -> None:
        self.connection: Connection = _asked(lambda server: server.supervisor(self._settings))

    def send(self, task: Task) -> None:
        """Give the worker a task; if its supervisor has ended, to the worker of a new one."""
        self.task = task
        self._tries += 1
        try:
            self.connection.send(task)
        except OSError:
            self._restart()

    def receive(self) -> Outcome | None:
        """Return the outcome of the task, or None if it was restarted or only reported what it does.

        Errors: InputError if the worker cannot start.
        """
        assert self.task is not None
        try:
            message: dict[str, Any] = cleaned(json.loads(self.connection.recv_bytes()))
        except (EOFError, OSError):
            if self._tries < TRIES:
                self._restart()
                return None
            self._connect()
            message = {"failure": Verdict.CRASHED.name, "reason": f"its processes were killed {TRIES} times"}
        except RecursionError:
            message = {"failure": Verdict.CRASHED.name, "reason": "the worker's reply is nested too deeply"}
        if "unusable" in message:
            raise InputError(message["unusable"])
        if message.keys() <= DURING:
            self._loaded |= message.get("loaded", {})
            if "compiling" in message:
                tell_of_kernels()
            return None
        if message.get("retry") and self._tries < TRIES:
            self.send(self.task)
            return None
        failure = Verdict[message["failure"]] if "failure" in message else None
        message["loaded"] = self._loaded | message.get("loaded", {})
        fields = {name: message[name] for name in ("value", "reason", "refused", "loaded") if name in message}
        outcome = Outcome(self.task, failure=failure, **fields)
        self.task, self._tries, self._loaded = None, 0, {}
        return outcome

    def _restart(self) -> None:
        assert self.task is not None
        self.connection.close()
        self._connect()
        self.send(self.task)

    def close(self) -> None:
        """Tell the supervisor to end, and wait until it and all its descendants have ended."""
        with suppress(OSError, EOFError):
            self.connection.send(None)
            while self.connection.poll(2 * process.KILL_SECONDS):
                self.connection.recv_bytes()
        self.connection.close()


@cache
def tell_of_kernels() -> None:
    """Say once, on stderr, that kernels are compiled, as results come late. Progress bars show it above them."""
    print("kernels are compiled for their first use: a minute for a few solvers, minutes for all of them", file=sys.stderr)


class Pool(AbstractContextManager["Pool"]):
    """Workers for one run; use as a context manager.

    folder: the run's. sandbox: the one that separates plug-ins from the files and processes of the run, see
    harness.workers.sandbox. Errors: InputError on a platform that cannot isolate workers and, from `run`, if a worker cannot
    start; ResultsError if workers run other code than this process.
    """

    def __init__(self, folder: Path, jobs: int, plugins: tuple[Plugin, ...], memory_limit: int) -> None:
        self.folder = folder.absolute()
        self._slots = [_Slot((self.folder, plugins, memory_limit)) for _ in range(jobs)]
        self.sandbox: str = _asked(lambda server: server.sandbox)

    def __exit__(self, *_: object) -> None:
        for slot in self._slots:
            slot.close()

    def run(self, tasks: Iterable[Task]) -> Iterator[Outcome]:
        """Yield the outcomes of the tasks as they arrive."""
        queue = iter(tasks)
        while True:
            for slot in self._slots:
                if slot.task is None and (task := next(queue, None)) is not None:
                    slot.send(task)
            busy = {slot.connection: slot for slot in self._slots if slot.task is not None}
            if not busy:
                return
            for connection in wait(list(busy)):
                if (outcome := busy[connection].receive()) is not None:  # type: ignore[index]
                    yield outcome


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Provide a folder, which the workers' server removes if this process is killed."""
    with TemporaryDirectory(dir=_asked(lambda server: server.scratch), ignore_cleanup_errors=True) as name:
        yield Path(name)


@contextmanager
def scratch_pool(
    plugins: tuple[Plugin, ...] = (), memory_limit: int = MEMORY_LIMIT, jobs: int = 1, folder: Path | None = None
) -> Iterator[Pool]:
    """Provide workers with a folder of their own. folder: a run whose problems they read."""
    with scratch_folder() as own:
        if folder is not None:
            (own / "problems").symlink_to((folder / "problems").resolve())
        with Pool(own, jobs, plugins, memory_limit) as pool:
            yield pool
