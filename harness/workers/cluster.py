"""The same tasks on a dask cluster: a cell a task, isolated on its worker as it would be here, its row sent back.

A dask worker needs the very code of this project that the main process runs:

    dask scheduler --host 127.0.0.1 --port 8786
    dask worker tcp://127.0.0.1:8786 --nthreads 1        (as many as there are cores)
    frictionbench run standard --cluster tcp://127.0.0.1:8786

A task whose dask worker dies goes to another one. Rows carry the host that timed them.
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

from frictionbench.harness import machine
from frictionbench.harness.plans.plan import Plugin, SolveCell
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Outcome, Task
from frictionbench.problems import InputError
from frictionbench.results.store import ResultsError
from frictionbench.results.verdicts import Verdict
from frictionbench.solvers.plugins import is_file

AHEAD = 4  # tasks handed out per worker, so that none waits for the network
ANSWERING = 10.0  # seconds a scheduler has to answer
Files = dict[str, bytes]
Settings = tuple[tuple[tuple[Plugin, Files], ...], int]
_pools: dict[tuple[Any, ...], Pool] = {}  # of a dask worker, by plug-ins' content and bound on memory


class Cluster:
    """Stands in for harness.workers.pool.Pool; use as a context manager. Errors: InputError naming `cluster`."""

    def __init__(self, address: str, folder: Path, plugins: tuple[Plugin, ...], memory_limit: int) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise InputError("cluster: dask is not installed; pip install 'frictionbench[cluster]'") from None
        try:
            self._client = Client(address, timeout=ANSWERING)
        except (OSError, ValueError) as error:
            raise InputError(f"cluster: no scheduler answers at {address} ({error})") from None
        self._folder = folder
        self._settings = tuple((plugin, _sent(plugin)) for plugin in plugins), memory_limit
        codes = self._client.run(machine.content)
        if not codes or set(codes.values()) != {machine.content()}:
            self._client.close()
            raise InputError(f"cluster: workers {codes or 'are missing; none'} run this code, {machine.content()}")

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def run(
        self, tasks: Iterable[Task], started: Callable[[Task], None] = lambda task: None, _: object = None
    ) -> Iterator[Outcome]:
        """Every task's outcome as it comes; started is called when a task is handed out. Who compiles is not known here.

        Errors: ResultsError where the scheduler dies.
        """
        from distributed import as_completed

        queue = iter(tasks)
        waiting: dict[Any, Task] = {}

        def submit(task: Task) -> Any:
            started(task)
            future = self._client.submit(_isolated, task, self._files(task), self._settings, pure=False, retries=3)
            waiting[future.key] = task
            return future

        ahead = AHEAD * len(self._client.scheduler_info(n_workers=-1)["workers"])
        completed = as_completed([submit(task) for task in islice(queue, ahead)])
        for future in completed:
            task = waiting.pop(future.key)
            try:
                error = future.exception()
                outcome = future.result() if error is None else None
            except (CancelledError, OSError):
                raise ResultsError("cluster: its scheduler is gone; the same command goes on where it stopped") from None
            yield outcome or Outcome(task, failure=Verdict.CRASHED, reason=f"on the cluster: {error}"[:500])
            if (following := next(queue, None)) is not None:
                completed.add(submit(following))

    def _files(self, task: Task) -> Files:
        """What the task reads: its problem, and its starts where it has any."""
        cell = task.arguments[0]
        if not isinstance(cell, SolveCell):
            return {}
        return {path.name: path.read_bytes() for path in (self._folder / "problems").glob(f"{cell.problem}*.npz")}


def _sent(plugin: Plugin) -> Files:
    """The plug-in's file; nothing of an installed distribution, which must be there, of the same content."""
    return {Path(plugin.source).name: Path(plugin.source).read_bytes()} if is_file(plugin.source) else {}


def _isolated(task: Task, files: Files, settings: Settings) -> Outcome:
    """Run a task on a dask worker in a process of its own, which is kept for the next task."""
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
    return outcome


@cache
def _scratch() -> Path:
    from distributed import get_worker

    return Path(get_worker().local_directory) / "frictionbench"


def _write(folder: Path, files: Files) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        if not (folder / name).exists() or (folder / name).read_bytes() != content:
            (folder / name).write_bytes(content)
