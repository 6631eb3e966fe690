"""Run studies: compute the tables that are missing, each in a worker, then the solver runs, one study after the other."""

from collections.abc import Sequence
from pathlib import Path

from frictionbench.harness.cells import worker
from frictionbench.harness.plans.plan import MEMORY_LIMIT
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.studies import STUDIES, Study
from frictionbench.harness.studies.study import LIMIT
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Task
from frictionbench.problems.catalogue import near
from frictionbench.problems.check import require
from frictionbench.results.files import ResultsError
from frictionbench.results.studies import RECORDED, RUNS, finished, open_study, write_rows, written

ALL = "all"


def named(name: str) -> list[Study]:
    """The study of this name, or all. Errors: InputError where there is none."""
    known = f"known are {', '.join(STUDIES)} and {ALL}"
    require(name == ALL or name in STUDIES, "study", f"unknown study {name!r}{near(name, STUDIES)}; {known}")
    return list(STUDIES.values()) if name == ALL else [STUDIES[name]]


def run_studies(studies: Sequence[Study], folder: Path, jobs: int, progress: Progress, locations: Sequence[str] = ()) -> None:
    """Complete these studies in folder. locations: of recorded problems, for the studies that compare them.

    Errors: ResultsError where folder holds a study by other code, where a table could not be computed, and as of harness.run;
    InputError where none of the studies takes recorded problems, or there are none at a location.
    """
    takers = [study.name for study in STUDIES.values() if study.recorded]
    require(not locations or any(study.recorded for study in studies), "data", f"recorded problems are for {', '.join(takers)}")
    recorded = {study.name: study.recorded(locations) for study in studies if study.recorded and locations}
    for study in studies:
        open_study(folder, study.description)
    _compute(studies, folder, jobs, progress)
    for study in studies:
        if study.plan and not finished(folder, study.name):
            run(study.plan(), folder / study.name / RUNS, jobs, progress)
        if study.name in recorded:
            run(recorded[study.name], folder / study.name / RECORDED, jobs, progress)


def _compute(studies: Sequence[Study], folder: Path, jobs: int, progress: Progress) -> None:
    tables = {f"{study.name}, {table.name}": (study.description, table) for study in studies for table in study.tables}
    tasks = [
        Task(name, worker.run_table, (table.rows, LIMIT), LIMIT)
        for name, (about, table) in tables.items()
        if table.name not in written(folder, about)
    ]
    if not tasks:
        return
    failed = []
    with (
        Pool(folder, jobs, (), MEMORY_LIMIT) as pool,
        progress.stage("tables", len(tables), len(tables) - len(tasks)) as stage,
    ):
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            about, table = tables[outcome.task.name]
            if outcome.failure:
                failed.append(f"{outcome.task.name}: {outcome.failure} ({outcome.reason})")
            else:
                write_rows(folder, about, table.name, outcome.value)
            stage.finished(outcome.task)
    if failed:
        raise ResultsError("tables could not be computed:\n  " + "\n  ".join(failed))
