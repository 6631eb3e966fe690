"""Supervisors: processes that run only this package's code. Each has one worker, which also runs solvers (see SECURITY.md).

The server imports the workers' modules once, and forks a supervisor for every socket that the main process sends. A supervisor
forks its worker, sends it tasks, and kills it at its deadline. It is the subreaper of all processes that its worker starts, and
ends them after each task, except for the package's helper processes (solvers.outside.children). When its socket to the main
process closes, a supervisor ends all its descendants and exits. If a supervisor is killed, the kernel kills its worker, and the
server what that worker had started. A worker of a plug-in (Task.owner) is sandboxed and runs no other solver.
"""

import json
import os
import signal
import socket
import tempfile
from collections.abc import Callable
from contextlib import nullcontext, suppress
from hashlib import sha256
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from numba.core import event
from numba.core.registry import cpu_target

from frictionbench.harness import dependencies, machine, process
from frictionbench.harness.cells import worker
from frictionbench.harness.deadline import COMPILE_SECONDS, HARNESS_SECONDS, Deadline
from frictionbench.harness.workers import sandbox
from frictionbench.harness.workers.pool import DURING, LONGEST_REPLY, MOST_LISTS, Settings, Task
from frictionbench.problems import InputError
from frictionbench.problems.compiled import PACKAGE
from frictionbench.problems.verdicts import Verdict
from frictionbench.solvers import plugins
from frictionbench.solvers.outside.children.child import living

POLL = 0.25  # seconds between checks of a deadline, which the worker may have moved
FOREIGN_SECONDS = 180.0  # seconds for a plug-in's task, in addition to three limits: to import, warm up and verify it
POLL_CLOSED = 0.01  # seconds between checks for the exit code of a worker that has closed its pipe and is about to exit


def serve(control_fd: int) -> None:
    """Run the server: report its code and its sandbox, then fork a supervisor for every socket received, until the last."""
    _detach()
    process.adopt_orphans()
    ended = _signalled(signal.SIGCHLD)
    supervisors: set[int] = set()
    sandbox_kind = sandbox.best()
    with socket.socket(fileno=control_fd) as control, tempfile.TemporaryDirectory(prefix="frictionbench-") as scratch:
        control.sendall(json.dumps({"code": machine.code(), "sandbox": sandbox_kind, "scratch": scratch}).encode() + b"\n")
        for context in (cpu_target.typing_context, cpu_target.target_context):
            context.refresh()  # imports numba's modules for the first kernel, once for all workers
        while True:
            if ended in (ready := wait([control, ended])):
                os.read(ended, 2**10)
                supervisors -= _reaped()
                process.end_children(spare=supervisors)  # processes that the worker of a killed supervisor had started
            if control not in ready:
                continue
            _, fds, _, _ = socket.recv_fds(control, 1, 1)
            if not fds:
                break
            pid = os.fork()
            if pid == 0:
                control.close()
                _run_and_exit(supervise, Connection(fds[0]), sandbox_kind, Path(scratch))
            os.close(fds[0])
            supervisors.add(pid)
        process.end_descendants()
        process.remove_folder(Path(scratch))


def _signalled(number: signal.Signals) -> int:
    """Return a descriptor that becomes readable when the signal arrives."""
    arrived, arrives = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(arrives, warn_on_full_buffer=False)
    return arrived


def _reaped() -> set[int]:
    """Wait for the children of this process that have ended, and return their ids."""
    pids = set()
    with suppress(ChildProcessError):
        while (pid := os.waitpid(-1, os.WNOHANG)[0]) != 0:
            pids.add(pid)
    return pids


def supervise(channel: Connection, sandbox_kind: str, scratch: Path) -> None:
    """Run a supervisor: receive tasks from the channel, and send the worker's replies back through it.

    Each worker has its own folder in scratch, which is removed with all its contents after the worker's end. A plug-in's
    kernels are compiled once for all workers of a run, and again in the next run, because numba notices a change of a kernel's
    own file only, not of the files of the functions that it calls.
    """
    process.adopt_orphans()
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    core = process.hold_core()
    child: _Worker | None = None
    with suppress(EOFError, OSError):
        settings = channel.recv()
        while (task := channel.recv()) is not None:
            if child is None or not child.may_run(task):
                _end(child)
                core = process.hold_core() if core is None else core
                try:
                    child = _Worker(channel, core, settings, Path(tempfile.mkdtemp(dir=scratch)), task.owner, sandbox_kind)
                except (OSError, ValueError) as error:
                    channel.send_bytes(_reply(unusable=str(error)))
                    break
            reply, reusable = child.run(task, channel)
            helpers = [] if task.owner or not reusable else json.loads(reply)["helpers"]  # only those of our own code
            if process.end_descendants(spare=[*child.processes, *helpers] if reusable else ()) or not reusable:
                _end(child)
                child = None
            channel.send_bytes(reply)
    _end(child)


def _end(child: "_Worker | None") -> None:
    """End the worker with all that it started, and remove its folder."""
    process.end_descendants()
    if child is not None:
        process.remove_folder(child.scratch)


class _Worker:
    """A worker process, as seen by its supervisor."""

    def __init__(
        self, channel: Connection, core: int | None, settings: Settings, scratch: Path, owner: str, sandbox_kind: str
    ) -> None:
        """Start a worker, in the sandbox if it runs a plug-in, and wait until it is ready.

        Errors: OSError if it cannot be started, InputError with the reason that it gives.
        """
        self.deadline = Deadline()
        self.owner, self.scratch = owner, scratch
        tasks, self._tasks = Pipe(duplex=False)
        self._replies, replies = os.pipe()
        supervisor = os.getpid()
        self.pid = os.fork()
        if self.pid == 0:
            channel.close()
            self._tasks.close()
            os.close(self._replies)
            process.die_with_parent(supervisor)
            _run_and_exit(work, self, tasks, replies, core, settings, sandbox_kind)
        tasks.close()
        os.close(replies)
        ready = bytearray()
        while not ready.endswith(b"\n"):
            if not wait([self._replies], timeout=self.deadline.left) or not (received := os.read(self._replies, 2**16)):
                raise InputError("workers: a worker ended before it was ready")
            ready += received
        if reason := json.loads(ready).get("reason"):
            raise InputError(reason)
        self.processes = [self.pid, *process.descendants(self.pid)]  # the worker, with namespaces after its keeper and init

    def __del__(self) -> None:
        os.close(self._replies)

    def may_run(self, task: Task) -> bool:
        """Return whether it is alive, was started for the task's owner, and has sent nothing since its last reply."""
        silent = not wait([self._replies], timeout=0)
        return self.owner == task.owner and silent and self._ended() is None

    def run(self, task: Task, channel: Connection) -> tuple[bytes, bool]:
        """Return the reply, a line, and whether the worker can be reused. Errors: EOFError if the main process has ended."""
        self.deadline.allow(HARNESS_SECONDS)
        last = Deadline()  # applies even if the worker keeps extending its own
        last.allow(3 * task.limit + (FOREIGN_SECONDS if task.owner else 3 * COMPILE_SECONDS + HARNESS_SECONDS))
        with suppress(OSError):
            self._tasks.send(task)
        reply, poll = bytearray(), POLL
        open_ends: list[Any] = [self._replies, channel]
        while len(reply) < LONGEST_REPLY:
            left = min(self.deadline.left, last.left)
            if left <= 0:
                return _failure(Verdict.TIMEOUT, f"stopped at its limit of {task.limit:g} s"), False
            ready = wait(open_ends, timeout=min(left, poll))
            if channel in ready:  # closed, since nothing is sent while a task runs
                raise EOFError
            if self._replies in ready:
                received = os.read(self._replies, 2**20)
                reply += received
                if reply.endswith(b"\n"):
                    for line in bytes(reply).splitlines(keepends=True):
                        checked, reusable = _checked(line)
                        if not reusable or not json.loads(checked).keys() <= DURING:
                            return checked, reusable
                        channel.send_bytes(checked)  # at once, in case the worker is ended during the call
                    reply.clear()
                if not received:
                    open_ends, poll = [channel], POLL_CLOSED
            ended = self._ended()
            if ended is not None:  # SIGKILL comes from outside (lack of memory, an operator), and the task is tried again
                how = signal.Signals(-ended).name if ended < 0 else f"exit code {ended}"
                return _failure(Verdict.CRASHED, f"the process ended: {how}", retry=ended == -signal.SIGKILL), False
        return _failure(Verdict.CRASHED, f"the worker's reply was longer than {LONGEST_REPLY} bytes"), False

    def _ended(self) -> int | None:
        """Return its exit code if it has ended, -s for signal s, otherwise None."""
        try:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
        except ChildProcessError:
            return 0
        return os.waitstatus_to_exitcode(status) if pid else None


def work(child: "_Worker", tasks: Connection, replies: int, core: int | None, settings: Settings, sandbox_kind: str) -> None:
    """Run a worker: receive tasks from one pipe, and write their results to another, each as a line of JSON.

    The first line says that it is ready, or why it cannot start.
    """
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
    try:
        os.setsid()
        process.close_all_but(tasks.fileno(), replies)
        folder, plugin_files, _ = settings
        loaded: Callable[[], dependencies.Loaded] = dict
        sandbox.tolerate_unusable_caches()
        os.environ["TMPDIR"] = tempfile.tempdir = str(child.scratch)
        if child.owner:
            kernels = child.scratch.with_name(sha256(f"{folder}\0{child.owner}".encode()).hexdigest())
            kernels.mkdir(exist_ok=True)
            sandbox.confine(sandbox_kind, folder, plugin_files, kernels, child.scratch)
            sandbox.use_scratch(child.scratch, kernels)
            loaded = dependencies.LoadWatch(folder).loaded
        worker.start(child.deadline, core, settings, lambda: _write(replies, loaded=loaded()))
    except (OSError, ValueError) as error:
        _write(replies, reason=str(error) if isinstance(error, InputError) else f"workers: {error}")
        return
    _write(replies)
    event.register("numba:compile", _Compilation(replies))
    pid, home = os.getpid(), os.getcwd()
    while True:
        try:
            task: Task = tasks.recv()
        except EOFError:
            return
        child.deadline.allow(HARNESS_SECONDS)
        try:
            with child.deadline.within(task.limit) if task.whole else nullcontext():
                reply = {"value": task.function(*task.arguments)}
        except BaseException as error:  # a plug-in may also call sys.exit
            refused = isinstance(error, InputError)
            reason = str(error) if refused else plugins.describe_error(error)
            reply = {"failure": Verdict.CRASHED.name, "reason": reason, "refused": refused}
        if os.getpid() != pid:  # a child that a solver forked and that returned from the call as well
            os._exit(0)
        os.chdir(home)
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        _write(replies, **reply, helpers=living(), loaded=loaded())


class _Compilation(event.Listener):
    """Reports that this worker compiles kernels of this package."""

    def __init__(self, replies: int) -> None:
        self._replies = replies

    def on_start(self, begun: event.Event) -> None:
        if begun.data["dispatcher"].py_func.__module__.startswith(f"{PACKAGE.name}."):
            _write(self._replies, compiling=True)

    def on_end(self, _: object) -> None:
        pass


def _write(replies: int, **fields: Any) -> None:
    """Write a reply, as a line, to the pipe of this worker."""
    reply = _reply(**fields)
    while reply:
        reply = reply[os.write(replies, reply) :]


def _checked(line: bytes) -> tuple[bytes, bool]:
    """Return the reply to forward, and whether its worker can be reused. A solver may have written anything to the pipe."""
    with suppress(ValueError, RecursionError):
        simple = line.count(b"\n") == 1 and line.count(b"[") + line.count(b"{") <= MOST_LISTS
        reply = json.loads(line) if simple else None
        if (
            isinstance(reply, dict)
            and reply.keys() <= {"value", "failure", "reason", "refused", "helpers", *DURING}
            and reply.get("failure") in (None, Verdict.CRASHED.name)
            and isinstance(reply.setdefault("loaded", {}), dict)
            and all(isinstance(place, str) for place in reply["loaded"].values())
        ):
            return line, True
    return _failure(Verdict.CRASHED, "the worker returned a malformed reply"), False


def _failure(verdict: Verdict, reason: str, **fields: Any) -> bytes:
    return _reply(failure=verdict.name, reason=reason, **fields)


def _reply(**fields: Any) -> bytes:
    return json.dumps(fields).encode() + b"\n"


def _run_and_exit(main: Callable[..., None], *arguments: Any) -> None:
    """Run the main function of a forked process, and exit without the parent's exit handlers."""
    code = 1
    try:
        main(*arguments)
        code = 0
    finally:
        os._exit(code)


def _detach() -> None:
    """Ignore the terminal's signals and discard all output. The main process's end is detected by its socket."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)
