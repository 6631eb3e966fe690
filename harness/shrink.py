"""Failing cells made small: contacts removed while the solver still fails, what is left kept as a problem file.

Delta debugging (Zeller and Hildebrandt 2002): try to do without each of n parts of the contacts, n growing as parts turn out
to be needed, until no single contact can go. Bodies go with their last contact. Every trial runs isolated and is verified,
like any cell; it fails as long as its verdict is the row's own, and rounding does not hide the residual. Several rows are
shrunk side by side, a trial each in turn.
"""

import tempfile
from collections.abc import Generator, Iterator, Sequence
from itertools import pairwise
from pathlib import Path

from frictionbench.harness.cells import worker
from frictionbench.harness.cells.collect import stored_friction
from frictionbench.harness.cells.rows import nothing
from frictionbench.harness.plans.plan import Plugin, SolveCell, Source
from frictionbench.harness.run import row_of
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Task
from frictionbench.problems import FrictionProblem
from frictionbench.problems.recorded.own import save
from frictionbench.problems.reduce import keep_contacts
from frictionbench.results.conventions import COLD
from frictionbench.results.files import replaced, subfolder
from frictionbench.results.shrunk import FOLDER, Shrunk
from frictionbench.results.store import Row

ENOUGH = 10.0  # seconds of trials that one row may cost where it is one of many


class Search:
    """One row's way to a smaller problem. asked: the contacts of the trial that is due; kept: the fewest that fail so far."""

    def __init__(self, row: Row, problem: FrictionProblem, seconds: float) -> None:
        self.row, self.problem = row, problem
        self.asked = list(range(problem.contacts))
        self.kept: list[int] | None = None
        self.trials, self.whole, self.over = 0, False, False
        self._left, self._way = seconds, smallest(self.asked)

    def hear(self, found: Row) -> None:
        """What became of the trial."""
        self.trials += 1
        self._left -= found.get("wall_time") or self.row["time_limit"]
        hidden = (found.get("residual_floor") or 0.0) > max(self.row["tol"], self.row.get("residual_floor") or 0.0)
        fails = found["verdict"] == self.row["verdict"] and not hidden
        if fails:
            self.kept = self.asked
        try:
            if self.trials == 1:
                self.asked = next(self._way)
            else:
                self.asked = self._way.send(fails)
        except StopIteration:
            self.whole = self.over = True
        self.over = self.over or self.kept is None or self._left <= 0


def shrink_rows(
    folder: Path, rows: Sequence[Row], plugins: tuple[Plugin, ...], memory_limit: int, jobs: int, seconds: float
) -> Iterator[tuple[Row, Shrunk]]:
    """Shrink the problems of failing solve rows into DIR/shrunk; each row with what became of it, as soon as it is known.

    seconds: of trials for each row, after which the smallest so far counts. Errors: InputError where a problem is damaged.
    """
    if not rows:
        return
    searches = [Search(row, stored_friction(folder, row["problem"]), seconds) for row in rows]
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        (scratch / "problems").mkdir()
        with Pool(scratch, jobs, plugins, memory_limit) as pool:
            while searches:
                asked = [(search, _trial(search, scratch, plugins)) for search in searches]
                heard = {id(outcome.task): outcome for outcome in pool.run([task for _, task in asked])}
                for search, task in asked:
                    search.hear(row_of(heard[id(task)], plugins))
                    if search.over:
                        yield search.row, _written(folder, search)
                searches = [search for search in searches if not search.over]


def smallest(parts: list[int]) -> Generator[list[int], bool, None]:
    """Asks about one sublist after another, and is told whether it fails, until no single part of the last that did can go.

    The whole list fails.
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
    row, problem = search.row, keep_contacts(search.problem, search.asked)
    save(problem, scratch / "problems" / f"{problem.hash}.npz")
    entry = nothing(Source(row["scene"]), "") | {"repeats": 1}
    cell = SolveCell(problem.hash, f"shrink {search.trials}", row["variant"], row["tol"], COLD)
    owner = row["variant"] if any(row["variant"] in plugin.solvers for plugin in plugins) else ""
    return Task(row["variant"], worker.run_solve, (cell, entry, row["time_limit"]), row["time_limit"], owner)


def _written(folder: Path, search: Search) -> Shrunk:
    if search.kept is None:
        return Shrunk("", search.problem.contacts, search.trials, whole=False)
    small, row = keep_contacts(search.problem, search.kept), search.row
    name = f"{row['solver']}-{row['verdict']}-{small.contacts}-contacts-{small.hash}.npz"
    with replaced(subfolder(folder, FOLDER) / name) as file:
        save(small, file)
    return Shrunk(name, small.contacts, search.trials, search.whole)
