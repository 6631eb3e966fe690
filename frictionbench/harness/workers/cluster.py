"""Running tasks on a Dask cluster: one cell per task, isolated on its Dask worker as on this machine.

A Dask worker must run the same code of this project as the main process (docs/cluster.md has the commands). This is checked
with every outcome too, because workers may join later. If a Dask worker ends, Dask runs its task again on another worker, as
often as the scheduler's setting distributed.scheduler.allowed-failures allows, by default three times.
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from frictionbench.harness import machine
from frictionbench.harness.cells.stored import files_of
from frictionbench.harness.plans.plan import Plugin, SolveCell
from frictionbench.harness.workers.pool import Outcome, Pool, Task
from frictionbench.problems import InputError
from frictionbench.problems.verdicts import Verdict
from frictionbench.results.files import ResultsError
from frictionbench.solvers.plugins import is_file

AHEAD = 4  # tasks submitted per worker: enough that no worker waits for the network, few enough for a balanced end
ANSWER_SECONDS = 10.0  # seconds for a scheduler to answer: a reachable one takes far less
LOST = "cluster: lost the connection to its scheduler; run the same command again to resume"
Files = dict[str, bytes]
Settings = tuple[tuple[tuple[Plugin, Files], ...], int]
_pools: dict[tuple[Any, ...], Pool] = {}  # pools of a Dask worker process, by the plug-ins' content and the memory limit


class Cluster(AbstractContextManager["Cluster"]):
    """Runs tasks like harness.workers.pool.Pool; use as a context manager. Errors: InputError naming `cluster`."""

    def __init__(self, address: str, folder: Path, plugins: tuple[Plugin, ...], memory_limit: int) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise InputError("cluster: dask is not installed; pip install 'frictionbench[cluster]'") from None
        try:
            self._client = Client(address, timeout=ANSWER_SECONDS)
        except (OSError, ValueError, TypeError) as error:  # TypeError: TLS without certificates
            raise InputError(f"cluster: no scheduler answers at {address} ({error})") from None
        self._folder = folder
        # Plug-in files are sent. Installed plug-ins must be installed on the Dask workers too, with the same content.
        files = [{Path(each.source).name: Path(each.source).read_bytes()} if is_file(each.source) else {} for each in plugins]
        self._settings = tuple(zip(plugins, files, strict=True)), memory_limit
        codes = self._client.run(machine.content)
        if not codes or set(codes.values()) != {machine.content()}:
            self._client.close()
            found = f"its workers run {codes}" if codes else "it has no workers"
            raise InputError(f"cluster: {found}; they must run {machine.content()}")

    def __exit__(self, *_: object) -> None:
        with suppress(Exception):  # the scheduler may not answer
            self._client.close(timeout=1.0)

    def run(self, tasks: Iterable[Task]) -> Iterator[Outcome]:
        """Yield the outcomes of the tasks as they arrive.

        Errors: ResultsError if the scheduler ends or does not answer, or a Dask worker runs other code.
        """
        queue = iter(tasks)
        done: SimpleQueue[Any] = SimpleQueue()
        waiting: dict[Any, tuple[Any, Task]] = {}  # the scheduler forgets a future that is not referenced

        def submit(most: int) -> None:
            for task in islice(queue, most):
                future = self._client.submit(_isolated, task, self._files(task), self._settings, pure=False)
                waiting[future.key] = future, task
                future.add_done_callback(done.put)

        submit(AHEAD * max(1, len(self._identity()["workers"])))  # the first task waits where the last worker has left
        while waiting:
            try:
                future = done.get(timeout=ANSWER_SECONDS)
            except Empty:
                self._identity()
                continue
            _, task = waiting.pop(future.key)
            if future.status in ("cancelled", "lost"):
                raise ResultsError(LOST)
            yield self._outcome(task, future)
            submit(1)

    def _outcome(self, task: Task, future: Any) -> Outcome:
        """Return the outcome of a finished task. Errors: ResultsError as for run."""
        if future.status == "error":
            return Outcome(task, failure=Verdict.CRASHED, reason=f"on the cluster: {self._answer(future._exception)}"[:500])
        code, host, outcome = self._answer(future._result)
        if code != machine.content():
            raise ResultsError(
                f"cluster: a dask worker on {host} runs other code, {code}, than this process, {machine.content()}; "
                "update or end it, and run the same command again to resume"
            )
        return outcome

    def _identity(self) -> Any:
        """Return the scheduler's description of itself and its workers. Errors: ResultsError if it does not answer."""
        assert self._client.scheduler is not None
        return self._answer(self._client.scheduler.identity)

    def _answer(self, ask: Callable[..., Any]) -> Any:
        """Return the result of a coroutine of the client. Errors: ResultsError if the scheduler does not answer."""
        try:
            return self._client.sync(ask, callback_timeout=ANSWER_SECONDS)
        except (CancelledError, OSError, TimeoutError):
            raise ResultsError(LOST) from None

    def _files(self, task: Task) -> Files:
        """Return the files that the task reads: its problem, its reference answer and its starts, if there are any."""
        cell = task.arguments[0]
        if not isinstance(cell, SolveCell) or not cell.problem:
            return {}
        return {path.name: path.read_bytes() for path in files_of(self._folder, cell.problem, cell.origin)}


def _isolated(task: Task, files: Files, settings: Settings) -> tuple[str, str, Outcome]:
    """Run a task on a Dask worker, in a pool of one process that is reused. Return the worker's code, its host, the outcome."""
    sent, memory_limit = settings
    folder = _scratch()
    _write(folder / "problems", files)
    plugins = []
    for plugin, content in sent:
        home = folder / "plugins" / plugin.content
        _write(home, content)
        plugins.append(replace(plugin, source=str(home / next(iter(content)))) if content else plugin)
    key = (*(plugin.content for plugin in plugins), memory_limit)
    if key not in _pools:
        _pools[key] = Pool(folder, 1, tuple(plugins), memory_limit)
    (outcome,) = _pools[key].run([task])
    outcome = replace(outcome, loaded={})  # these paths are only valid on this machine
    return machine.content(), machine.host(), outcome


@cache
def _scratch() -> Path:
    from distributed import get_worker

    return Path(get_worker().local_directory) / "frictionbench"


def _write(folder: Path, files: Files) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        if not (folder / name).exists() or (folder / name).read_bytes() != content:
            (folder / name).write_bytes(content)
