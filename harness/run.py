"""A run: collect the problems, run the cells that have no row yet, merge the tables.

The folder is the run's whole state. Stopped at any moment, by a key or a kill, the same command goes on where it stopped; a
folder that holds a run of another plan, machine or code is refused with what differs.
"""

import os
from collections.abc import Callable
from contextlib import nullcontext
from datetime import UTC, datetime
from pathlib import Path

from harness import machine
from harness.cells import worker
from harness.cells.collect import Entry
from harness.cells.rows import drive_row, solve_row
from harness.plans.plan import DriveCell, Plan, Plugin, SolveCell, origin
from harness.progress import Progress
from harness.workers.cluster import Cluster
from harness.workers.pool import Pool
from harness.workers.task import Outcome, Task
from problems import InputError
from results import store
from results.store import ResultsError, Row, ShardWriter

COLLECTING = 600.0  # seconds for one source's problems


def run(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run what of the plan folder does not hold yet, here or on the dask cluster at an address.

    Errors: ResultsError where folder holds an unlike run, InputError where the cluster cannot be used.
    """
    folder = folder.absolute()
    open_folder(plan, folder)
    with Pool(folder, 1 if cluster else jobs, plan.plugins, plan.memory_limit) as pool:
        entries = _collect(plan, pool, progress)
        _record(plan, pool, progress)
        solves, drives = plan.solve_cells(entries.values()), plan.drive_cells()
        tasks = [_solve_task(cell, entries[cell.origin], plan) for cell in solves]
        tasks += [_drive_task(cell, plan) for cell in drives]
        tasks.sort(key=lambda task: task.owner)  # a worker that has run code from outside runs nothing else after it
        done = store.read_rows(folder, "solves").keys() | store.read_rows(folder, "drives").keys()
        left = [task for task in tasks if task.arguments[0].key not in done]
        with (
            Cluster(cluster, folder, plan.plugins, plan.memory_limit) if cluster else nullcontext(pool) as engine,
            ShardWriter(folder, "solves", f"{os.getpid()}") as solved,
            ShardWriter(folder, "drives", f"{os.getpid()}") as driven,
            progress.stage("cells", len(tasks), len(tasks) - len(left)) as stage,
        ):
            shards = {"solves": solved, "drives": driven}
            for outcome in engine.run(left, stage.started):
                table, row = outcome.task.arguments[0].table, outcome.value
                shards[table].write(row if outcome.death is None else row_of_the_dead(outcome, plan.plugins))
                stage.finished(outcome.task)
    store.merge(folder, "solves", [cell.key for cell in solves])
    store.merge(folder, "drives", [cell.key for cell in drives])
    store.write_manifest(
        folder, store.read_manifest(folder) | {"problems": sorted({e["problem"] for e in entries.values()}), "finished": _now()}
    )


def open_folder(plan: Plan, folder: Path) -> None:
    """Make folder the home of this plan's run, or see that it is. Errors: ResultsError saying what differs."""
    manifest = {"settings": plan.settings(), "machine": machine.describe(), "versions": machine.versions()}
    if (folder / "manifest.json").exists():
        held = store.read_manifest(folder)
        if different := list(_differences(held, manifest)):
            listed = "\n  ".join(different[:12])
            raise ResultsError(f"{folder} holds another run; choose another --out. What differs:\n  {listed}")
        return
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ResultsError(f"{folder}: neither empty nor a results folder; nothing was written")
    store.write_manifest(folder, manifest | {"started": _now()})


def _differences(held: Row, wanted: Row) -> list[str]:
    found = []
    for part, values in wanted.items():
        old = held.get(part, {})
        names = (name for name in sorted(values.keys() | old.keys()) if old.get(name) != values.get(name))
        found += [f"{part}.{name}: {_brief(old.get(name))} there, {_brief(values.get(name))} now" for name in names]
    return found


def _brief(value: object) -> str:
    text = str(value)
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def _collect(plan: Plan, pool: Pool, progress: Progress) -> dict[str, Entry]:
    """The problems of all sources by their origin, in the plan's order."""
    tasks = [
        Task(f"{source.scene} {source.parameters or ''}", worker.run_source, (source, COLLECTING), COLLECTING)
        for source in (*plan.sources, *plan.placed)
    ]
    by_task: dict[int, list[Entry]] = {}
    with progress.stage("problems", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started):
            if outcome.death:
                raise InputError(f"scene: {outcome.task.name.strip()} yields no problems: {outcome.reason}")
            by_task[id(outcome.task)] = outcome.value
            stage.finished(outcome.task)
    return {origin(entry): entry for task in tasks for entry in by_task[id(task)]}


def _record(plan: Plan, pool: Pool, progress: Progress) -> None:
    """Record a motion of every scene, here; they are pictures, and one that cannot be made is no loss."""
    tasks = [
        Task(f"motion of {shown.scene}", worker.run_motion, (shown, plan.drive_limit), plan.drive_limit)
        for shown in plan.shown()
    ]
    if not tasks:
        return
    with progress.stage("motions", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started):
            stage.finished(outcome.task)


def _solve_task(cell: SolveCell, entry: Entry, plan: Plan) -> Task:
    name = f"{cell.variant} on {entry['scene']}, {entry['contacts']} contacts"
    limit = entry.get("time_limit", plan.time_limit)
    return Task(name, worker.run_solve, (cell, entry, limit), limit, plan.owner(cell.variant))


def _drive_task(cell: DriveCell, plan: Plan) -> Task:
    name = f"{cell.variant} drives {cell.scene}"
    return Task(name, worker.run_drive, (cell, plan.drive_limit), plan.drive_limit, plan.owner(cell.variant))


def row_of_the_dead(outcome: Outcome, plugins: tuple[Plugin, ...]) -> Row:
    """The row of a cell whose worker died."""
    cell, *facts = outcome.task.arguments
    make: Callable[..., Row] = solve_row if isinstance(cell, SolveCell) else drive_row
    known = make(cell, *facts, plugins=plugins)
    return known | {"verdict": outcome.death, "reason": outcome.reason}


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
