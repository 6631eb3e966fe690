"""`frictionbench rerun --shrink`: reduce the problem of one failing row (harness.shrink)."""

from math import inf
from pathlib import Path
from typing import NamedTuple

from frictionbench.commands.stored_cell import stored_cell
from frictionbench.commands.trusted import trusted
from frictionbench.harness.shrink import shrink_rows
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.recorded.own import load
from frictionbench.problems.verdicts import Verdict
from frictionbench.results.commands import solve, sources
from frictionbench.results.extras import SHRUNK


class Reduced(NamedTuple):
    """The file of the reduced problem, the problem, the number of trials, and the command that shows the failure."""

    path: Path
    problem: FrictionProblem
    trials: int
    command: str


def shrink(folder: Path, key: str, named: list[str]) -> Reduced:
    """Shrink the problem of a failing solve row into folder/shrunk.

    named: outside solvers that the user trusts. Errors: as of store.find_row, and InputError where the row did not fail, or its
    solver is neither ours nor among the named.
    """
    _, row, settings, memory_limit = stored_cell(folder, key, ["solves"])
    key = row["key"]
    if row["verdict"] in (Verdict.SOLVED, Verdict.SKIPPED):
        raise InputError(f"row: {key} is {row['verdict']}; only failing rows can be shrunk")
    ((_, found),) = shrink_rows(folder, [row], trusted(row, settings, named), memory_limit, 1, inf)
    if not found.file:
        raise InputError(f"row: {key} does not fail again from a cold start; it was not shrunk")
    path = folder / SHRUNK / found.file
    small = load(path)
    assert isinstance(small, FrictionProblem)
    command = solve(path, row["variant"], row["tol"], sources(settings))
    return Reduced(path, small, found.trials, command)
