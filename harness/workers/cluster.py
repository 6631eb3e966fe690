"""The same tasks on a dask cluster: a cell a task, isolated on its worker as it would be here, its row sent back.

A dask worker needs this project installed at the same revision and must be allowed to have child processes:

    dask scheduler --port 8786
    DASK_DISTRIBUTED__WORKER__DAEMON=False dask worker tcp://127.0.0.1:8786 --nthreads 1        (as many as there are cores)
    frictionbench run standard --cluster tcp://127.0.0.1:8786

A task whose dask worker dies goes to another one. Rows carry the host that timed them.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

from harness import machine
from harness.plans.plan import SolveCell
from harness.workers.pool import Outcome, Pool, Task
from problems import InputError

AHEAD = 4  # tasks handed out per worker, so that none waits for the network
Files = dict[str, bytes]


class Cluster:
    """Stands in for harness.workers.pool.Pool; use as a context manager. Errors: InputError naming `cluster`."""

    leaves_rows = False

    def __init__(self, address: str, folder: Path, plugins: tuple[str, ...], memory_limit: int) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise InputError("cluster: dask is not installed; pip install 'frictionbench[cluster]'") from None
        try:
            self._client = Client(address, timeout=10)
        except (OSError, ValueError) as error:
            raise InputError(f"cluster: no scheduler answers at {address} ({error})") from None
        self._folder = folder
        self._settings = ({Path(path).name: Path(path).read_bytes() for path in plugins}, memory_limit)
        revisions = self._client.run(machine.revision)
        if not revisions or set(revisions.values()) != {machine.revision()}:
            self._client.close()
            raise InputError(f"cluster: workers {revisions or 'are missing; none'} run this revision, {machine.revision()}")

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def run(self, tasks: Iterable[Task], started: Callable[[Task], None] = lambda task: None) -> Iterator[Outcome]:
        """Every task's outcome as it comes; started is called when a task is handed out."""
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
            error = future.exception()
            yield future.result() if error is None else Outcome(task, death="crashed", reason=f"on the cluster: {error}"[:500])
            if (following := next(queue, None)) is not None:
                completed.add(submit(following))

    def _files(self, task: Task) -> Files:
        """What the task reads: its problem, and its starts where it has any."""
        cell = task.arguments[0]
        if not isinstance(cell, SolveCell):
            return {}
        return {path.name: path.read_bytes() for path in (self._folder / "problems").glob(f"{cell.problem}*.npz")}


def _isolated(task: Task, files: Files, settings: tuple[Files, int]) -> Outcome:
    """Run a task on a dask worker in a process of its own, which is kept for the next task."""
    plugins, memory_limit = settings
    folder = _scratch()
    _write(folder / "problems", files)
    _write(folder / "plugins", plugins)
    pool = _pool(tuple(str(folder / "plugins" / name) for name in plugins), memory_limit)
    (outcome,) = pool.run([task])
    return outcome


@cache
def _scratch() -> Path:
    from distributed import get_worker

    return Path(get_worker().local_directory) / "frictionbench"


@cache
def _pool(plugins: tuple[str, ...], memory_limit: int) -> Pool:
    return Pool(_scratch(), 1, plugins, memory_limit)


def _write(folder: Path, files: Files) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        if not (folder / name).exists():
            (folder / name).write_bytes(content)
