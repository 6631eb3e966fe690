"""Supervisors: processes that run none but our own code, each with one worker that may do anything.

    main  ─  server  ─┬─  supervisor  ─  worker  ─  whatever its solver starts
                      └─  supervisor  ─  worker

The server imports what workers need, once, and forks a supervisor for every socket that the main process sends it. A supervisor
forks its worker, hands it tasks, kills it past its deadline, and after each task ends whatever else lives below itself, but for
libraries in child processes of our own (solvers.outside.children): it is the subreaper of all that its worker starts. Where
its socket to the main process ends, because that process is done or was killed, a supervisor ends all below it and itself; a
worker whose supervisor is killed is killed by the kernel. A worker that has run a solver from outside this repository
(Task.owner) runs no other.
"""

import json
import os
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any

from numba.core.registry import cpu_target

from frictionbench.harness import machine, process
from frictionbench.harness.cells import worker
from frictionbench.harness.deadline import COMPILING, OURS, Deadline
from frictionbench.harness.workers.task import LONGEST_REPLY, Task
from frictionbench.problems import InputError
from frictionbench.results.verdicts import Verdict
from frictionbench.solvers import plugins
from frictionbench.solvers.outside.children.child import living

LOOK = 0.25  # seconds between looks at a deadline, which the worker may have moved


def serve(control_fd: int) -> None:
    """Run the server: report whose code this is, then fork a supervisor for every socket that comes, until the last."""
    _stand_apart()
    process.adopt_orphans()
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # supervisors are not waited for
    supervisors: set[int] = set()
    with socket.socket(fileno=control_fd) as control:
        control.sendall(json.dumps(machine.code()).encode() + b"\n")
        for context in (cpu_target.typing_context, cpu_target.target_context):
            context.refresh()  # what numba imports at its first kernel, here for all workers
        while True:
            _, fds, _, _ = socket.recv_fds(control, 1, 1)
            if not fds:
                break
            supervisors &= set(process.descendants(os.getpid()))
            pid = os.fork()
            if pid == 0:
                control.close()
                _live(keep, Connection(fds[0]))
            os.close(fds[0])
            supervisors.add(pid)
    process.end_descendants()


def keep(channel: Connection) -> None:
    """A supervisor's life: tasks come through the channel, the replies of the worker go back."""
    process.adopt_orphans()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    core = process.hold_core()
    hand: _Worker | None = None
    with suppress(EOFError, OSError):
        settings = channel.recv()
        while (task := channel.recv()) is not None:
            if hand is None or not hand.may_run(task):
                process.end_descendants()
                core = process.hold_core() if core is None else core
                hand = _Worker(channel, core, settings)
            reply, reusable = hand.run(task, channel)
            if process.end_descendants(spare=_kept(hand, task, reply) if reusable else ()) or not reusable:
                process.end_descendants()
                hand = None
            channel.send_bytes(reply)
    process.end_descendants()


def _kept(hand: "_Worker", task: Task, reply: bytes) -> list[int]:
    """What goes on living after a task: the worker, and where only our own code ran in it the libraries that it keeps ready."""
    return [hand.pid, *([] if task.owner else json.loads(reply)["kept"])]


class _Worker:
    """The worker as its supervisor sees it."""

    def __init__(self, channel: Connection, core: int | None, settings: tuple[Any, ...]) -> None:
        self.deadline = Deadline()
        self.owner = ""
        tasks, self._tasks = Pipe(duplex=False)
        self._replies, replies = os.pipe()
        supervisor = os.getpid()
        self.pid = os.fork()
        if self.pid == 0:
            channel.close()
            self._tasks.close()
            os.close(self._replies)
            process.die_with_parent(supervisor)
            _live(work, tasks, replies, self.deadline, core, settings)
        tasks.close()
        os.close(replies)

    def __del__(self) -> None:
        os.close(self._replies)

    def may_run(self, task: Task) -> bool:
        """Whether it is alive, and has run nothing from outside but what the task is about."""
        silent = not wait([self._replies], timeout=0)  # what is said now answers nothing
        return self.owner in ("", task.owner) and silent and self._ended() is None

    def run(self, task: Task, channel: Connection) -> tuple[bytes, bool]:
        """The reply to a task, a line, and whether the worker can go on. Errors: EOFError where the main process is gone."""
        self.owner = task.owner
        self.deadline.allow(OURS)
        last = Deadline()  # whatever the worker does with its own
        last.allow(3 * (task.limit + COMPILING) + OURS)
        with suppress(OSError):
            self._tasks.send(task)
        reply, look, compiling = bytearray(), LOOK, False
        open_ends: list[Any] = [self._replies, channel]
        while len(reply) < LONGEST_REPLY:
            left = min(self.deadline.left, last.left)
            if left <= 0:
                return _failure(Verdict.TIMEOUT, f"stopped at its limit of {task.limit:g} s"), False
            ready = wait(open_ends, timeout=min(left, look))
            if channel in ready:  # nothing is sent while a task runs: this is the end
                raise EOFError
            if self._replies in ready:
                said = os.read(self._replies, 2**20)
                reply += said
                if reply.endswith(b"\n"):
                    return _understood(bytes(reply))
                if not said:  # closed: it is dying
                    open_ends, look = [channel], 0.01
            if (ended := self._ended()) is not None:
                return _obituary(ended), False
            if not ready and self.deadline.compiling != compiling:  # for some time, not just reading its cache
                compiling = not compiling
                channel.send_bytes(_reply(compiling=compiling))
        return _failure(Verdict.CRASHED, f"the process sent more than {LONGEST_REPLY} bytes"), False

    def _ended(self) -> int | None:
        """Its exit code once it has ended, -s for signal s."""
        try:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
        except ChildProcessError:
            return 0
        return os.waitstatus_to_exitcode(status) if pid else None


def work(tasks: Connection, replies: int, deadline: Deadline, core: int | None, settings: tuple[Any, ...]) -> None:
    """A worker's life: tasks come through one pipe, what they return goes back through another as a line of JSON."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    me, home = os.getpid(), os.getcwd()
    worker.start(deadline, core, *settings)
    while True:
        try:
            task: Task = tasks.recv()
        except EOFError:
            return
        deadline.allow(OURS)
        try:
            value = task.function(*task.arguments)
            reply = _reply(value=value, kept=living())
        except Exception as error:
            why = str(error) if isinstance(error, InputError) else plugins.describe_error(error)
            reply = _failure(Verdict.CRASHED, why, kept=living())
        if os.getpid() != me:  # a solver forked, and its child came back too
            os._exit(0)
        os.chdir(home)
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        while reply:
            reply = reply[os.write(replies, reply) :]


def _understood(line: bytes) -> tuple[bytes, bool]:
    """A reply as it is sent on, and whether its worker can go on. Whatever runs there may have said it."""
    with suppress(ValueError, RecursionError):
        said = json.loads(line) if line.count(b"\n") == 1 else None
        if (
            isinstance(said, dict)
            and said.keys() <= {"value", "failure", "reason", "kept"}
            and said.get("failure") in (None, Verdict.CRASHED.name)
        ):
            return line, True
    return _failure(Verdict.CRASHED, "the process sent what is no reply"), False


def _obituary(code: int) -> bytes:
    """SIGKILL comes from outside (a machine short of memory, an operator) and says nothing of the solver."""
    how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    return _failure(Verdict.CRASHED, f"the process died: {how}", again=code == -signal.SIGKILL)


def _failure(verdict: Verdict, reason: str, **said: Any) -> bytes:
    return _reply(failure=verdict.name, reason=reason, **said)


def _reply(**said: Any) -> bytes:
    return json.dumps(said).encode() + b"\n"


def _live(life: Callable[..., None], *arguments: Any) -> None:
    """Spend a forked process's life, and leave without the parent's exit handlers."""
    code = 1
    try:
        life(*arguments)
        code = 0
    finally:
        os._exit(code)


def _stand_apart() -> None:
    """Silent, and deaf to the keys and the terminal of the main process, whose end is seen by its socket."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nowhere, stream)


if __name__ == "__main__":
    serve(int(sys.argv[1]))
