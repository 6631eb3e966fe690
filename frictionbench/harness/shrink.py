"""Shrinking the problems of failing cells: contacts are removed while the solver still fails, and the rest is saved as a file.

Delta debugging (Zeller and Hildebrandt 2002): leave out each of n parts of the contacts in turn, with n growing as parts turn
out to be needed, until no single contact can be removed. A body is removed with its last contact. Every trial runs isolated
and is verified like any cell; it fails if its verdict is the row's own and its residual is above the rounding floor. Several
rows are shrunk concurrently, one trial each in turn.
"""

from collections.abc import Generator, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from frictionbench.harness import process
from frictionbench.harness.cells.collect import stored_friction
from frictionbench.harness.cells.rows import no_problem
from frictionbench.harness.plans.plan import Plugin, SolveCell, Source
from frictionbench.harness.run import cell_task, row_of
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems import FrictionProblem
from frictionbench.problems.recorded.own import save
from frictionbench.problems.subproblems import keep_contacts
from frictionbench.results.conventions import COLD
from frictionbench.results.extras import SHRUNK, Shrunk
from frictionbench.results.files import replaced, subfolder
from frictionbench.results.store import Row

ENOUGH = 10.0  # seconds of trials for each of many rows, so that a map's MOST_SHRUNK failures take a quarter of an hour at most


class Search:
    """The search for one row's smallest failing problem.

    candidate: the contacts of the next trial. smallest: the fewest contacts that have failed, None before any did. minimal:
    whether no single contact can be removed. done: whether the search has ended.
    """

    def __init__(self, row: Row, problem: FrictionProblem, seconds: float) -> None:
        self.row, self.problem = row, problem
        self.candidate = list(range(problem.contacts))
        self.smallest: list[int] | None = None
        self.trials, self.minimal, self.done = 0, False, False
        self._left, self._reduction = seconds, reduction(self.candidate)

    def update(self, found: Row) -> None:
        """Take the row of the trial into account."""
        self.trials += 1
        self._left -= found.get("wall_time") or self.row["time_limit"]
        hidden = (found.get("residual_floor") or 0.0) > max(self.row["tol"], self.row.get("residual_floor") or 0.0)
        fails = found["verdict"] == self.row["verdict"] and not hidden
        if fails:
            self.smallest = self.candidate
        try:
            if self.trials == 1:
                self.candidate = next(self._reduction)
            else:
                self.candidate = self._reduction.send(fails)
        except StopIteration:
            self.minimal = self.done = True
        self.done = self.done or self.smallest is None or self._left <= 0


def shrink_rows(
    folder: Path, rows: Sequence[Row], plugins: tuple[Plugin, ...], memory_limit: int, jobs: int, seconds: float
) -> Iterator[tuple[Row, Shrunk]]:
    """Shrink the problems of failing solve rows into DIR/shrunk; yields each row with its result when it is known.

    seconds: of trials for each row, after which the smallest failing problem so far is saved.
    Errors: InputError where a problem is damaged.
    """
    if not rows:
        return
    with process.memory_within(memory_limit):
        searches = [Search(row, stored_friction(folder, row["problem"]), seconds) for row in rows]
    with scratch_pool(plugins, memory_limit, jobs) as pool:
        while searches:
            trials = [(search, _trial(search, pool.folder, plugins)) for search in searches]
            outcomes = {id(outcome.task): outcome for outcome in pool.run([task for _, task in trials])}
            for search, task in trials:
                search.update(row_of(outcomes[id(task)], plugins))
                if search.done:
                    yield search.row, _written(folder, search)
            searches = [search for search in searches if not search.done]


def reduction(parts: list[int]) -> Generator[list[int], bool, None]:
    """Yields sublists to try and receives whether each fails, until no single part of the last failing one can be removed.

    The whole list must fail.
    """
    pieces = 2
    while len(parts) >= 2:
        bounds = [round(i * len(parts) / pieces) for i in range(pieces + 1)]
        for a, b in pairwise(bounds):
            rest = parts[:a] + parts[b:]
            if rest and (yield rest):
                parts, pieces = rest, max(pieces - 1, 2)
                break
        else:
            if pieces >= len(parts):
                break
            pieces = min(2 * pieces, len(parts))


def _trial(search: Search, scratch: Path, plugins: tuple[Plugin, ...]) -> Task:
    row, problem = search.row, keep_contacts(search.problem, search.candidate)
    save(problem, subfolder(scratch, "problems") / f"{problem.hash}.npz")
    record = no_problem(Source(row["scene"]), "") | {"repeats": 1}
    cell = SolveCell(problem.hash, f"shrink {search.trials}", row["variant"], row["tol"], COLD)
    return cell_task(cell, row["time_limit"], plugins, record)


def _written(folder: Path, search: Search) -> Shrunk:
    if search.smallest is None:
        return Shrunk("", search.problem.contacts, search.trials, whole=False)
    small, row = keep_contacts(search.problem, search.smallest), search.row
    name = f"{row['solver']}-{row['verdict']}-{small.contacts}-contacts-{small.hash}.npz"
    with replaced(subfolder(folder, SHRUNK) / name) as file:
        save(small, file)
    return Shrunk(name, small.contacts, search.trials, search.minimal)
