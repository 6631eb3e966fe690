"""`frictionbench accept`: what a run found becomes the baseline, as text."""

from collections import Counter
from pathlib import Path

from frictionbench.results import baseline, cells, store
from frictionbench.results.cells import Cells, rounded
from frictionbench.results.compare import Comparison, Limits, compare
from frictionbench.results.store import ResultsError


def accept(folder: Path, path: Path | None) -> tuple[Comparison | None, str]:
    """Make the run in folder the baseline at path; what changes against the one that was there, and what is accepted.

    path: baselines/SUITE.tsv where it is None.

    Errors: ResultsError where the run is not finished, or the path holds something else.
    """
    if not store.read_manifest(folder).get("finished"):
        raise ResultsError(f"{folder}: the run is not finished; the same command goes on where it stopped")
    run, before = cells.read(folder), None
    path = path or Path("baselines") / f"{run.suite}.tsv"
    if path.exists():
        baseline.read(path)  # nothing else is written over
        before = compare(path, folder, Limits(times=False))
    tolerances = " ".join(f"{tol:g}" for tol in run.tolerances)
    facts = {"suite": run.suite, "tolerances": tolerances, "code": run.code, "made": run.made}
    baseline.write(path, facts, _rows(run))
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in Counter(run.table["verdict"]).most_common())
    return before, f"accepted: {path}, {len(run.table)} cells: {verdicts}"


def _rows(run: Cells) -> list[tuple[str, ...]]:
    table = run.table.assign(
        tol=[f"{tol:g}" for tol in run.table["tol"]],
        residual=[rounded(value, 2) for value in run.table["residual"]],
        seconds=[rounded(value, 1) for value in run.table["seconds"]],
        limit=[f"{limit:g}" for limit in run.table["limit"]],
    )
    return [(*row[1:], row[0]) for row in table[list(baseline.COLUMNS)].itertuples()]
