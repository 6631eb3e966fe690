"""`frictionbench compare --accept`: write a run's verdicts and counters as the baseline, a text file."""

from collections import Counter
from pathlib import Path

from frictionbench.problems.verdicts import Verdict
from frictionbench.results import baseline, cells
from frictionbench.results.cells import Cells, rounded
from frictionbench.results.compare import Comparison, Limits, compare
from frictionbench.results.files import ResultsError


def accept(folder: Path, path: Path | None) -> tuple[Comparison | None, str]:
    """Write the run in folder as the baseline at path; its comparison with the previous baseline, if any, and a summary.

    path: baselines/SUITE.tsv if None. Errors: ResultsError where the run is not finished or has no cell to compare, or path is
    not a baseline or one that the run cannot be compared with.
    """
    run, before = cells.read(folder), None
    if unusable := compare(folder, folder, Limits(times=False)).unusable:
        raise ResultsError(f"{folder}: cannot be a baseline: {unusable}")
    path = path or Path("baselines") / f"{_name(run.suite)}.tsv"
    if path.exists():
        baseline.read(path)  # refuses to overwrite a file that is not a baseline
        before = compare(path, folder, Limits(times=False))
        if before.unusable:
            raise ResultsError(f"{path}: {before.unusable}; delete the file to accept a run that cannot be compared with it")
    tolerances = " ".join(f"{tol:g}" for tol in run.tolerances)
    facts = {"suite": run.suite, "tolerances": tolerances, "code": run.code, "made": run.made}
    for variant, loaded in run.loaded.items():
        facts[f"{baseline.LOADED}{variant}"] = "; ".join(f"{name} {digest}" for name, digest in sorted(loaded.items()))
    baseline.write(path, facts, _rows(run))
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(run.table["verdict"]).most_common())
    told = f"accepted: {path}, {len(run.table)} cells: {verdicts}"
    if (run.table["verdict"] == Verdict.TIMEOUT).any():
        told += "\ntimeouts may be the machine's doing: `frictionbench run --retake` repeats them"
    return before, told


def _name(suite: str) -> str:
    """The suite as the name of a file. Errors: ResultsError where a manifest of someone else's names another folder."""
    if Path(suite).name != suite or suite == "..":
        raise ResultsError(f"suite: {suite!r} is not the name of a file; name the baseline's file")
    return suite


def _rows(run: Cells) -> list[tuple[str, ...]]:
    table = run.table.assign(
        tol=[f"{tol:g}" for tol in run.table["tol"]],
        residual=[rounded(value, 2) for value in run.table["residual"]],
        seconds=[rounded(value, 1) for value in run.table["seconds"]],
        limit=[f"{limit:g}" for limit in run.table["limit"]],
    )
    return [(*row[1:], row[0]) for row in table[list(baseline.COLUMNS)].itertuples()]
