"""`frictionbench rerun --shrink`: contacts are removed while the solver still fails, and the rest is saved as a file.

Delta debugging (Zeller and Hildebrandt 2002): leave out each of n parts of the contacts in turn, and increase n while all parts
are needed, until no single contact can be removed. A body is removed with its last contact. Every trial runs isolated and is
verified like any cell. It fails if it has the verdict of the row, and if rounding does not hide its residual (`fails_as`).
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from frictionbench.commands.stored_cell import stored_cell, trusted
from frictionbench.harness import process
from frictionbench.harness.cells.rows import no_problem
from frictionbench.harness.cells.stored import stored_friction
from frictionbench.harness.plans.plan import SolveCell, Source
from frictionbench.harness.run import cell_task, row_of
from frictionbench.harness.workers.pool import scratch_pool
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.recorded.native import save
from frictionbench.problems.spec import split
from frictionbench.problems.subproblems import keep_contacts
from frictionbench.problems.verdicts import Verdict
from frictionbench.results import commands
from frictionbench.results.files import replaced, subfolder
from frictionbench.results.store import Row


def shrink(
    folder: Path, key: str, named: list[str], tell: Callable[[str], None] = lambda _: None
) -> tuple[Path, FrictionProblem, int, str]:
    """Shrink the problem of a failing solve row into DIR/shrunk. Return the file, the problem in it, the number of trials, and
    the command that shows the failure.

    named: outside solvers that the user trusts. tell: prints a line of progress. Errors: as for store.find_row, and InputError
    if the row did not fail or does not fail again from a cold start, its problem is damaged, or its solver is neither ours nor
    in `named`.
    """
    _, row, settings, memory_limit = stored_cell(folder, key, ["solves"])
    if row["verdict"] in (Verdict.SOLVED, Verdict.SKIPPED):
        raise InputError(f"row: {row['key']} is {row['verdict']}; only failing rows can be shrunk")
    plugins = trusted(row, settings, named)
    with process.memory_within(memory_limit):
        problem = stored_friction(folder, row["problem"])
    trials = 0
    with scratch_pool(plugins, memory_limit) as pool:

        def fails(contacts: list[int]) -> bool:
            nonlocal trials
            trials += 1
            part = keep_contacts(problem, contacts)
            save(part, subfolder(pool.folder, "problems") / f"{part.hash}.npz")
            cell = SolveCell(part.hash, f"shrink {trials}", row["variant"], row["tol"])
            record = no_problem(Source(row["scene"]), "") | {"repeats": 1}
            (outcome,) = pool.run([cell_task(cell, row["time_limit"], plugins, record)])
            again = row_of(outcome, plugins)
            if failed := fails_as(row, again):
                tell(f"trial {trials}: fails with {len(contacts)} contacts")
            elif trials == 1:
                now = f"{again['verdict']} ({again['reason']})" if again.get("reason") else again["verdict"]
                longer = "; run it with a longer --time-limit" if again["verdict"] == Verdict.TIMEOUT else ""
                change = f"row: {row['key']} was {row['verdict']} and is {now} from a cold start"
                raise InputError(f"{change}; only what fails again alike can be shrunk{longer}")
            return failed

        whole = list(range(problem.contacts))
        fails(whole)
        small = keep_contacts(problem, reduced(whole, fails))
    solver, _ = split("solver", row["variant"])  # not the column, which nobody has checked
    path = subfolder(folder, "shrunk") / f"{solver}-{row['verdict']}-{small.contacts}-contacts-{small.hash}.npz"
    with replaced(path) as file:
        save(small, file)
    return path, small, trials, commands.solve(path, row["variant"], row["tol"], commands.sources(settings))


def fails_as(row: Row, again: Row) -> bool:
    """Return whether a trial has the row's verdict, and a rounding floor within the row's tolerance or its rounding floor."""
    hidden = (again.get("residual_floor") or 0.0) > max(row["tol"], row.get("residual_floor") or 0.0)
    return again["verdict"] == row["verdict"] and not hidden


def reduced(parts: list[int], fails: Callable[[list[int]], bool]) -> list[int]:
    """Return the parts that are left when no single one can be removed. The whole list must fail."""
    pieces = 2
    while len(parts) >= 2:
        bounds = [round(i * len(parts) / pieces) for i in range(pieces + 1)]
        rests = (parts[:a] + parts[b:] for a, b in pairwise(bounds))
        if rest := next((rest for rest in rests if rest and fails(rest)), None):
            parts, pieces = rest, max(pieces - 1, 2)
        elif pieces >= len(parts):
            break
        else:
            pieces = min(2 * pieces, len(parts))
    return parts
