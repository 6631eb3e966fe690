"""The problem of one failing row made small: see harness.shrink."""

from math import inf
from pathlib import Path

from frictionbench.harness.commands.trusted import trusted
from frictionbench.harness.shrink import shrink_rows
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.recorded.own import load
from frictionbench.results import store
from frictionbench.results.shrunk import FOLDER
from frictionbench.results.verdicts import Verdict


def shrink(folder: Path, key: str, named: list[str]) -> tuple[Path, FrictionProblem, int]:
    """Shrink the problem of a failing solve row into folder/shrunk; the file, the problem, and how many trials it took.

    named: solvers from outside, which the user trusts. Errors: as store.find_row's, and InputError where it did not
    fail, or its solver is in none of them and not ours.
    """
    settings = store.read_manifest(folder)["settings"]
    _, row = store.find_row(folder, key, ["solves"])
    key = row["key"]
    if row["verdict"] in (Verdict.SOLVED, Verdict.SKIPPED):
        raise InputError(f"row: {key} is {row['verdict']}; there is no failure to keep")
    ((_, found),) = shrink_rows(folder, [row], trusted(row, settings, named), settings["memory_limit"], 1, inf)
    if not found.file:
        raise InputError(f"row: {key} does not fail again from a cold start; it is not shrunk")
    path = folder / FOLDER / found.file
    small = load(path)
    assert isinstance(small, FrictionProblem)
    return path, small, found.trials
