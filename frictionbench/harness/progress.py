"""Progress bars on a terminal; plain lines at intervals where the output is not a terminal."""

import textwrap
import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

from rich import progress
from rich.console import Console

from frictionbench.harness.workers.cluster import Cluster
from frictionbench.harness.workers.pool import Outcome, Pool, Task

T = TypeVar("T")
COLUMNS = (
    progress.TextColumn("{task.description}"),
    progress.BarColumn(20),  # characters
    progress.MofNCompleteColumn(),
    progress.TimeElapsedColumn(),
    progress.TimeRemainingColumn(),
)
FEW_ITEMS = 100  # items up to which the time left is not shown: the first items may have compiled kernels for others
INTERVAL = 20.0  # seconds between plain lines: under two hundred lines per hour


class Progress:
    """Progress bars on stderr, one stage after another. quiet: print nothing."""

    def __init__(self, quiet: bool = False) -> None:
        self._console = Console(stderr=True, quiet=quiet)
        self._drawn = self._console.is_terminal and not quiet

    def tell(self, text: str) -> None:
        """Print a line, or on a terminal a paragraph."""
        if self._console.is_terminal:  # wrapped between words; a path stays whole
            text = textwrap.fill(text, self._console.width, break_long_words=False, break_on_hyphens=False)
        self._console.print(text, highlight=False, markup=False, soft_wrap=True)

    def follow(self, name: str, engine: Pool | Cluster, tasks: list[Task], done: int = 0) -> Iterator[Outcome]:
        """Yield the outcomes of the tasks as they arrive, and show how many. done: the number of tasks done by earlier runs."""
        return self.counted(name, engine.run(tasks), done + len(tasks), done) if tasks else iter(())

    def counted(self, name: str, items: Iterable[T], total: int, done: int = 0) -> Iterator[T]:
        """Yield the items and show how many of the total there have been. done: the number before the first item."""
        printed = time.monotonic()
        shown = COLUMNS if total > FEW_ITEMS else COLUMNS[:-1]
        with progress.Progress(*shown, console=self._console, disable=not self._drawn) as bar:
            task = bar.add_task(name, total=total, completed=done)
            for count, item in enumerate(items, done + 1):
                bar.update(task, completed=count)
                if count < total and not self._drawn and time.monotonic() - printed > INTERVAL:
                    printed = time.monotonic()
                    self.tell(f"{name}: {count} of {total}")
                yield item
        if not self._drawn:
            self.tell(f"{name}: {'all ' * (total > 1)}{total} done")
