"""A run: collect the problems, run the cells that have no row yet, merge the tables.

The folder is the run's whole state. Stopped at any moment, by a key or a kill, the same command goes on where it stopped; a
folder that holds a run of another plan, machine or code is refused with what differs.
"""

import os
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from inspect import cleandoc
from pathlib import Path

from frictionbench.harness import machine
from frictionbench.harness.cells import worker
from frictionbench.harness.cells.collect import Entry
from frictionbench.harness.cells.rows import nothing, simulation_row, solve_row
from frictionbench.harness.convergence import record_histories
from frictionbench.harness.plans.plan import Cell, Plan, Plugin, SolveCell, origin
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.cluster import Cluster
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Outcome, Task
from frictionbench.results import store
from frictionbench.results.schema import TABLES
from frictionbench.results.store import ResultsError, Row, ShardWriter
from frictionbench.results.verdicts import RANK, Verdict
from frictionbench.solvers import find

COLLECTING = 600.0  # seconds for one source's problems


def run(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run what of the plan folder does not hold yet, here or on the dask cluster at an address.

    Errors: ResultsError where folder holds an unlike run, InputError where the cluster cannot be used.
    """
    folder = folder.absolute()
    open_folder(plan, folder)
    store.write_manifest(folder, store.read_manifest(folder) | {"workers": None if cluster else jobs})
    with Pool(folder, 1 if cluster else jobs, plan.plugins, plan.memory_limit) as pool:
        entries = _collect(plan, pool, progress)
        _record(plan, pool, progress)
        cells: list[Cell] = [*plan.solve_cells(entries.values()), *plan.simulation_cells()]
        if not cluster:
            _run(cells, entries, plan, folder, pool, progress)
            record_histories(plan, folder, entries.values(), pool, progress)
    if cluster:  # whose workers want the cores that ours held
        with Cluster(cluster, folder, plan.plugins, plan.memory_limit) as engine:
            _run(cells, entries, plan, folder, engine, progress)
    lost = _merge(plan, folder, cells, entries)
    names = sorted({entry["problem"] for entry in entries.values()} - {""})
    store.write_manifest(folder, store.read_manifest(folder) | {"problems": names, "finished": _now()})
    if lost:
        raise ResultsError(f"{folder}: {lost} rows were lost; the tables say which. The same command runs their cells again")


def _run(
    cells: list[Cell], entries: dict[str, Entry], plan: Plan, folder: Path, engine: Pool | Cluster, progress: Progress
) -> None:
    """Run the cells that have no row yet.

    Those of plug-ins come last: a worker that has run one runs nothing else. A library's come together, to load it once.
    """
    done = store.stored_keys(folder, "solves") | store.stored_keys(folder, "simulations")
    left = sorted((cell for cell in cells if cell.key not in done), key=lambda cell: _place(plan, cell))
    with (
        ShardWriter(folder, "solves", f"{os.getpid()}") as solved,
        ShardWriter(folder, "simulations", f"{os.getpid()}") as simulated,
        progress.stage("cells", len(cells), len(cells) - len(left)) as stage,
    ):
        shards = {"solves": solved, "simulations": simulated}
        tasks = []
        for task in (_task(cell, entries, plan) for cell in left):
            if reason := _nothing_there(task):
                stage.started(task)
                solved.write(row_of(Outcome(task, failure=Verdict.SKIPPED, reason=reason), plan.plugins))
                stage.finished(task)
            else:
                tasks.append(task)
        for outcome in engine.run(tasks, stage.started, stage.compiling):
            shards[outcome.task.arguments[0].table].write(row_of(outcome, plan.plugins))
            stage.finished(outcome.task)


def _merge(plan: Plan, folder: Path, cells: list[Cell], entries: dict[str, Entry]) -> int:
    """Merge the tables, rows in the plan's order; of how many planned cells the row is not there."""

    def row_of_the_lost(key: str) -> Row:
        reason = "its row was lost: the shard is gone or damaged"
        return row_of(Outcome(_task(planned[key], entries, plan), failure=Verdict.CRASHED, reason=reason), plan.plugins)

    lost = 0
    for table in TABLES:
        planned = {cell.key: cell for cell in cells if cell.table == table}
        lost += store.merge(folder, table, list(planned), row_of_the_lost)
    return lost


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
    store.write_manifest(folder, manifest | {"solvers": _in_their_words(plan), "started": _now()})


def _in_their_words(plan: Plan) -> dict[str, str]:
    """What our solvers' files and classes say of them, for the report; a plug-in is not asked outside its worker."""
    variants = dict.fromkeys(variant for variant in (*plan.solvers, *plan.simulation_solvers) if not plan.owner(variant))
    makes = {variant: find(variant)[0].make for variant in variants}
    words = {variant: (sys.modules[make.__module__].__doc__, make.__doc__) for variant, make in makes.items()}
    return {variant: "\n\n".join(cleandoc(text) for text in texts if text) for variant, texts in words.items()}


def drop_disturbed(plan: Plan, folder: Path) -> None:
    """Drop the rows of cells that shared their core: the next run measures them again. Errors: as of open_folder."""
    open_folder(plan, folder)
    for table in TABLES:
        store.drop(folder, table, lambda row: row.get("disturbed") is True)


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
    """The problems of all sources by their origin, in the plan's order; of one that yields none, what says so."""
    tasks = [
        Task(f"{source.scene} {source.parameters or ''}", worker.run_source, (source, COLLECTING), COLLECTING)
        for source in (*plan.sources, *plan.map_sources)
    ]
    by_task: dict[int, list[Entry]] = {}
    with progress.stage("problems", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            source, _ = outcome.task.arguments
            by_task[id(outcome.task)] = [nothing(source, outcome.reason)] if outcome.failure else outcome.value
            stage.finished(outcome.task)
    return {origin(entry): entry for task in tasks for entry in by_task[id(task)]}


def _record(plan: Plan, pool: Pool, progress: Progress) -> None:
    """Record a motion of every scene, here, and what a polygon makes of one; a picture that cannot be made is no loss."""
    tasks = [
        Task(f"motion of {shown.scene}", worker.run_motion, (shown, plan.simulation_limit), plan.simulation_limit)
        for shown in plan.shown()
    ]
    if plan.polygons:
        tasks.append(Task("polygon's error", worker.run_polygon, (plan.simulation_limit,), plan.simulation_limit))
    if not tasks:
        return
    with progress.stage("motions", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            stage.finished(outcome.task)


def _place(plan: Plan, cell: Cell) -> tuple[str, str]:
    """The plug-in and the outside library that a cell runs, each empty where it runs none."""
    if owner := plan.owner(cell.variant):
        return owner, ""
    info, _ = find(cell.variant)
    return "", info.name if info.needs else ""


def _task(cell: Cell, entries: dict[str, Entry], plan: Plan) -> Task:
    owner = plan.owner(cell.variant)
    if isinstance(cell, SolveCell):
        entry = entries[cell.origin]
        name = f"{cell.variant} on {entry['scene']}, {entry['contacts']} contacts"
        limit = entry.get("time_limit", plan.time_limit)
        return Task(name, worker.run_solve, (cell, entry, limit), limit, owner)
    return Task(
        f"{cell.variant} in {cell.scene}", worker.run_simulation, (cell, plan.simulation_limit), plan.simulation_limit, owner
    )


def _nothing_there(task: Task) -> str:
    """Why there is no problem to solve, where the source yielded none."""
    cell, facts, *_ = task.arguments
    return str(facts.get("reason", "")) if isinstance(cell, SolveCell) else ""


def row_of(outcome: Outcome, plugins: tuple[Plugin, ...]) -> Row:
    """The row of a cell: what its worker found or how it died, and what is known without it, which no worker can change."""
    cell, *facts = outcome.task.arguments
    make: Callable[..., Row] = solve_row if isinstance(cell, SolveCell) else simulation_row
    found = {"verdict": outcome.failure, "reason": outcome.reason} if outcome.failure else outcome.value
    if not isinstance(found, dict) or found.get("verdict") not in RANK:
        found = {"verdict": Verdict.CRASHED, "reason": "the process sent what is no row"}
    return found | make(cell, *facts, plugins=plugins) | {"host": found.get("host", machine.host())}


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
