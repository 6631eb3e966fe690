"""A failing cell made small: contacts removed while the solver still fails, kept as a problem file of its own.

Delta debugging (Zeller and Hildebrandt 2002): try to do without each of n parts of the contacts, n growing as parts turn out
to be needed, until no single contact can go. Bodies go with their last contact. Every trial runs isolated and is verified,
like any cell; it fails as long as its verdict is the row's own.
"""

import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from harness.cells import worker
from harness.cells.collect import Met, facts, stored_friction
from harness.commands.trusted import trusted
from harness.plans.plan import COLD, Plugin, SolveCell, Source
from harness.run import row_of
from harness.workers.pool import Pool
from harness.workers.task import Task
from problems import FrictionProblem, InputError
from problems.recorded.own import save
from problems.reduce import keep_contacts
from results import store
from results.files import replaced, room
from results.schema import SKIPPED, SOLVED
from results.store import Row


def shrink(folder: Path, key: str, named: list[str]) -> tuple[Path, FrictionProblem, int]:
    """Shrink the problem of a failing solve row into folder/shrunk; the file, the problem, and how many trials it took.

    named: solvers from outside, which the user trusts. Errors: as store.find_row's, and InputError where it did not
    fail, or its solver is in none of them and not ours.
    """
    settings = store.read_manifest(folder)["settings"]
    _, row = store.find_row(folder, key, ["solves"])
    key = row["key"]
    if row["verdict"] in (SOLVED, SKIPPED):
        raise InputError(f"row: {key} is {row['verdict']}; there is no failure to keep")
    plugins = trusted(row, settings, named)
    problem = stored_friction(folder, row["problem"])
    trials = 0
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        (scratch / "problems").mkdir()
        with Pool(scratch, 1, plugins, settings["memory_limit"]) as pool:

            def fails(kept: list[int]) -> bool:
                nonlocal trials
                trials += 1
                return _verdict(keep_contacts(problem, kept), row, trials, scratch, pool, plugins) == row["verdict"]

            everything = list(range(problem.contacts))
            if not fails(everything):
                raise InputError(f"row: {key} does not fail again from a cold start; it is not shrunk")
            kept = smallest(everything, fails)
    small = keep_contacts(problem, kept)
    path = room(folder, "shrunk") / f"{row['solver']}-{row['verdict']}-{small.contacts}-contacts-{small.hash}.npz"
    with replaced(path) as file:
        save(small, file)
    return path, small, trials


def smallest(parts: list[int], fails: Callable[[list[int]], bool]) -> list[int]:
    """A sublist that fails and from which no single part can be taken without ending the failure."""
    pieces = 2
    while len(parts) >= 2:
        bounds = [round(i * len(parts) / pieces) for i in range(pieces + 1)]
        for a, b in pairwise(bounds):
            rest = parts[:a] + parts[b:]
            if rest and fails(rest):
                parts, pieces = rest, max(pieces - 1, 2)
                break
        else:
            if pieces >= len(parts):
                break
            pieces = min(2 * pieces, len(parts))
    return parts


def _verdict(problem: FrictionProblem, row: Row, trial: int, scratch: Path, pool: Pool, plugins: tuple[Plugin, ...]) -> str:
    save(problem, scratch / "problems" / f"{problem.hash}.npz")
    entry = facts(Source(row["scene"]), Met(trial, "step", problem))
    cell = SolveCell(problem.hash, f"shrink {trial}", row["variant"], row["tol"], COLD)
    task = Task(
        row["variant"], worker.run_solve, (cell, entry, row["time_limit"]), row["time_limit"], row["variant"] if plugins else ""
    )
    (outcome,) = pool.run([task])
    return (row_of(outcome, plugins))["verdict"]
