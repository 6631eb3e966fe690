"""Progress bars on a terminal; plain lines at intervals where the output is not a terminal."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from frictionbench.harness.workers.cluster import Cluster
from frictionbench.harness.workers.pool import Outcome, Pool, Task

BAR = 20  # characters
BESIDE = BAR + 2 * len("0:00:00") + len("/") + 5  # characters of a line but its name, its counts and what is running
INTERVAL = 20.0  # seconds between plain lines: a log of an hour's run has under two hundred


class Stage:
    """One bar: the tasks that are running and the number that are done."""

    def __init__(self, console: Console, bar: Bar, name: str, total: int, done: int) -> None:
        self._console, self._bar, self._name, self._total, self._done = console, bar, name, total, done
        self._id = bar.add_task(name, total=total, completed=done, running="")
        self._room = max(console.width - len(name) - 2 * len(str(total)) - BESIDE, 0)
        self._running: list[str] = []
        self._printed = time.monotonic()

    def started(self, task: Task) -> None:
        self._running.append(task.name)
        self._show()

    def finished(self, task: Task) -> None:
        self._running.remove(task.name)
        self.advance()

    def advance(self) -> None:
        """One more is done."""
        self._done += 1
        self._show()

    def _show(self) -> None:
        running = next(iter(self._running), "")
        self._bar.update(self._id, completed=self._done, running=escape(running[: self._room]))
        if not self._console.is_terminal and time.monotonic() - self._printed > INTERVAL:
            self._printed = time.monotonic()
            self._console.print(f"{self._name}: {self._done} of {self._total}", highlight=False)


class Progress:
    """Bars on a console, stderr by default, one stage after another; quiet: nothing at all."""

    def __init__(self, console: Console | None = None, quiet: bool = False) -> None:
        self._console = console or Console(stderr=True, quiet=quiet)

    def tell(self, text: str) -> None:
        """Print a line."""
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)

    def follow(self, name: str, engine: Pool | Cluster, tasks: list[Task], done: int = 0) -> Iterator[Outcome]:
        """The outcomes of the tasks as they arrive, shown in a stage if there are any. done: tasks of earlier runs."""
        if not tasks:
            return
        with self.stage(name, done + len(tasks), done) as stage:
            for outcome in engine.run(tasks, stage.started):
                stage.finished(outcome.task)
                yield outcome

    @contextmanager
    def stage(self, name: str, total: int, done: int) -> Iterator[Stage]:
        columns = (
            TextColumn("{task.description}"),
            BarColumn(BAR),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        running = TextColumn("[dim]{task.fields[running]}")
        with Bar(*columns, running, console=self._console, disable=not self._console.is_terminal) as bar:
            yield Stage(self._console, bar, name, total, done)
        if not self._console.is_terminal and total > done:
            self._console.print(f"{name}: all {total} done", highlight=False)
