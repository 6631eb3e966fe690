"""A run: collect the problems, run the cells that have no row yet, merge the tables.

The folder holds the whole state of the run. After an interruption at any moment the same command resumes it. A folder of
another plan, machine or code is refused with a list of the differences.
"""

import json
import os
import re
import secrets
import sys
from collections.abc import Callable
from contextlib import ExitStack, nullcontext
from datetime import UTC, datetime
from importlib.metadata import version
from inspect import cleandoc
from pathlib import Path

from frictionbench.harness import dependencies, machine
from frictionbench.harness.cells import worker
from frictionbench.harness.cells.rows import known_row, no_problem
from frictionbench.harness.cells.stored import Record
from frictionbench.harness.convergence import record_histories
from frictionbench.harness.plans.plan import Cell, Plan, Plugin, SolveCell, origin, owner, plugin_of
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.cluster import Cluster
from frictionbench.harness.workers.pool import Outcome, Pool, Task
from frictionbench.problems.verdicts import Verdict
from frictionbench.results import store
from frictionbench.results.conventions import DEFAULT_SCHEME, count, scene_title
from frictionbench.results.files import ResultsError, cleaned
from frictionbench.results.schema import TABLES
from frictionbench.results.store import Row, new_shard
from frictionbench.solvers import find

Rows = dict[str, dict[str, Row]]  # rows by table and key
RUNS: dict[str, Callable[..., Row]] = {
    "solves": worker.run_solve,
    "simulations": worker.run_simulation,
    "batches": worker.run_batch,
}
SMALL_CELL = 0.04  # seconds that a worker takes for a cell of a few contacts, repeats included
COLLECT_SECONDS = 600.0  # time limit in seconds for one source's problems, in case reference answers take too long


def run(plan: Plan, folder: Path, jobs: int, progress: Progress, cluster: str | None = None) -> None:
    """Run the cells of the plan that have no row in folder, on this machine or on a Dask cluster. cluster: its address.

    Errors: ResultsError if folder holds a different run, InputError if the cluster cannot be used.
    """
    folder = folder.absolute()
    with Cluster(cluster, folder, plan.plugins, plan.memory_limit) if cluster else nullcontext() as distant:
        open_folder(plan, folder)
        rows = {table: store.rows(folder, table) for table in TABLES}
        known = {name: value for name, value in store.read_manifest(folder).items() if name != "finished"}
        if "workers" not in known:  # the run has just begun
            progress.tell(f"results are written to {folder}")
            if plan.expects:
                progress.tell(f"{plan.suite} takes {plan.expects} with one worker on two cores, without compiling kernels")
        with Pool(folder, 1 if cluster else jobs, plan.plugins, plan.memory_limit) as pool:
            store.write_manifest(folder, known | {"workers": None if cluster else jobs, "isolation": pool.sandbox})
            for table in TABLES:  # merged at an earlier end; reports read the shards until the next
                if store.shards(folder, table):  # which the folder of a published run lacks
                    (folder / f"{table}.parquet").unlink(missing_ok=True)
            records = _collect(plan, pool, progress)
            cells: list[Cell] = [*plan.solve_cells(records.values()), *plan.simulation_cells(), *plan.batch_cells()]
            # All solvers take a problem in turn, because the machine's speed changes from minute to minute. Cells of plug-ins
            # come last, because a worker that has run a plug-in is used for nothing else.
            left = [cell for cell in cells if cell.key not in rows[cell.table]]
            left.sort(key=lambda cell: owner(cell.variant, plan.plugins))
            done = len(cells) - len(left)
            if left and not plan.expects:
                progress.tell(_announced(plan, left, len(records)))
            if done and not left:
                progress.tell(f"{count(done, 'cell')} had been run before, and none is left")
            if not distant:
                _run(left, done, records, plan, folder, pool, progress, rows)
                record_histories(plan, folder, records.values(), rows["solves"].values(), pool, progress)
        if distant:  # after the pool has released its cores, which workers on this machine need
            _run(left, done, records, plan, folder, distant, progress, rows)
    if changed := dependencies.changed_content(plan, store.read_manifest(folder).get("content", {})):
        raise ResultsError(f"{folder}: {changed[0]}: has another content than when the run began; begin another run")
    for table, table_rows in rows.items():
        store.write_table(folder, table, [table_rows[cell.key] for cell in cells if cell.table == table])
    if not plan.maps:  # harness.maps may add points
        store.write_manifest(folder, store.read_manifest(folder) | {"finished": now()})


def _announced(plan: Plan, cells: list[Cell], problems: int) -> str:
    """Return the line that announces a plan of unknown duration: its number of cells, its solvers, bounds of its duration."""
    solvers = dict.fromkeys(cell.variant for cell in cells)
    named = ", ".join(solvers) if len(solvers) <= 12 else f"{len(solvers)} solvers"
    bounds = (max(round(each), 1) for each in (SMALL_CELL * len(cells), sum(map(plan.limit, cells))))  # s
    takes, longest = (f"{each} s" if each < 60 else f"{each // 60:g} min" for each in bounds)
    cells_of = f"{count(len(cells), 'cell')} of {count(problems, 'problem')}"
    text = f"{cells_of} with {named}: about {takes} on one core where problems are small and solvers fast"
    return f"{text}, about {longest} where all reach their time limits"


def _run(
    cells: list[Cell],
    done: int,
    records: dict[str, Record],
    plan: Plan,
    folder: Path,
    engine: Pool | Cluster,
    progress: Progress,
    rows: Rows,
) -> None:
    """Run the cells, which have no row yet, in this order, and add their rows. done: the number of cells that have one."""
    solved = {cell.key: records[cell.origin] for cell in cells if isinstance(cell, SolveCell)}
    tasks = [cell_task(cell, plan.limit(cell), plan.plugins, solved.get(cell.key)) for cell in cells]
    writer, record = f"{os.getpid()}-{secrets.token_hex(4)}", dependencies.LoadRecord(folder)
    with ExitStack() as opened:
        shards = {table: opened.enter_context(new_shard(folder, table, writer)) for table in TABLES}
        for outcome in progress.follow("cells", engine, tasks, done):
            cell, row = outcome.task.arguments[0], row_of(outcome, plan.plugins)
            if plugin := plugin_of(cell.variant, plan.plugins):
                record.add(plugin.source, outcome.loaded)
            shards[cell.table](row)
            rows[cell.table][cell.key] = row


def open_folder(plan: Plan, folder: Path) -> None:
    """Begin the plan's run in folder, or check that folder holds it. Errors: ResultsError naming what differs."""
    manifest = {"settings": plan.settings(), "machine": machine.describe(), "versions": machine.versions()}
    if (folder / "manifest.json").exists():
        stored = store.read_manifest(folder)
        if different := _differences(stored, manifest) or [
            f"{place}: has another content" for place in dependencies.changed_content(plan, stored.get("content", {}))
        ]:
            listed = "\n  ".join(different[:12])
            raise ResultsError(f"{folder} holds another run; choose another --out. Differences:\n  {listed}")
        return
    # A process that was killed in write_manifest has left a temporary file.
    if folder.exists() and (not folder.is_dir() or any(not path.match(".manifest-*.json") for path in folder.iterdir())):
        raise ResultsError(f"{folder}: neither empty nor a results folder; nothing was written. Choose another --out")
    begun = {"release": version("frictionbench"), "solvers": _descriptions(plan), "started": now(), "options": plan.options}
    store.write_manifest(folder, manifest | begun | dependencies.initial_content(plan))


def _descriptions(plan: Plan) -> dict[str, str]:
    """Return the docstrings of our solvers' files and classes, for the report. Plug-ins are not imported in this process."""
    variants = [variant for variant in plan.variants if not plugin_of(variant, plan.plugins)]
    makes = {variant: find(variant)[0].make for variant in variants}
    docstrings = {variant: (sys.modules[make.__module__].__doc__, make.__doc__) for variant, make in makes.items()}
    return {variant: "\n\n".join(cleandoc(text) for text in texts if text) for variant, texts in docstrings.items()}


def drop_disturbed(plan: Plan, folder: Path) -> None:
    """Drop the rows of cells that shared their core or ended at their time limit, for which sharing is unknown. The next run
    measures them again. Errors: as for open_folder."""
    open_folder(plan, folder)
    for table in TABLES:
        store.drop(folder, table, lambda row: row.get("disturbed") is True or row.get("verdict") == Verdict.TIMEOUT)


def _differences(stored: Row, wanted: Row) -> list[str]:
    differences = []
    for part, values in cleaned(wanted).items():  # in the form in which they are stored
        old = stored.get(part, {})
        for name in sorted(name for name in values.keys() | old.keys() if old.get(name) != values.get(name)):
            there, here = old.get(name), values.get(name)
            if isinstance(there, list) and isinstance(here, list):  # show only the entries that the other list lacks
                there, here = [entry for entry in there if entry not in here], [entry for entry in here if entry not in there]
            sides = ((there, "in the folder"), (here, "now"))
            words = [f"{_words(side):.250} {where}" for side, where in sides if side not in (None, [])]
            text = (", ".join(words) or "in another order") + " only" * (len(words) == 1)
            differences.append(f"{part}.{name}: {text}")
    return differences


def _words(value: object) -> str:
    """Return a JSON value as text without punctuation and empty entries, with hashes cut to their first 12 digits. Of a list
    it has three entries. A source of problems is named as on the page, without defaults and the folders of its files."""
    if isinstance(value, dict) and {"scene", "parameters", "pick"} <= value.keys():
        known = ("scene", "parameters")
        more = {name: entry for name, entry in value.items() if entry and entry != DEFAULT_SCHEME and name not in known}
        return f"{scene_title(value['scene'], json.dumps(value['parameters']))} {re.sub('[^ ]*/', '', _words(more))}".strip()
    if isinstance(value, dict) and {"source", "content"} <= value.keys():  # a plug-in
        return f"{value['source']} (content {value['content'][:8]})"
    if isinstance(value, dict):
        return " ".join(f"{name} {_words(entry)}" for name, entry in value.items() if entry not in ("", None, [], {}))
    if isinstance(value, list):
        return ", ".join(map(_words, value[:3])) + f" and {len(value) - 3} more" * (len(value) > 3)
    return re.sub("([0-9a-f]{12})[0-9a-f]{52}", r"\1", str(value))


def _collect(plan: Plan, pool: Pool, progress: Progress) -> dict[str, Record]:
    """Return the records of all problems by origin, in the plan's order. A source that fails has one record with the reason.

    Errors: ResultsError if problems cannot be stored."""
    tasks = [Task(worker.run_source, (source,), COLLECT_SECONDS) for source in (*plan.sources, *plan.map_sources)]
    by_task: dict[int, list[Record]] = {}
    for outcome in progress.follow("sources of problems", pool, tasks):
        (source,) = outcome.task.arguments
        if isinstance(outcome.value, str):
            raise ResultsError(f"{pool.folder}: {outcome.value}")
        by_task[id(outcome.task)] = [no_problem(source, outcome.reason)] if outcome.failure else outcome.value
    return {origin(record): record for task in tasks for record in by_task[id(task)]}


def cell_task(cell: Cell, limit: float, plugins: tuple[Plugin, ...], record: Record | None = None) -> Task:
    """Return the task of a cell. record: the problem's record, for a solve cell."""
    arguments = (cell, limit) if record is None else (cell, record, limit)
    return Task(RUNS[cell.table], arguments, limit, owner(cell.variant, plugins), whole=False)


def row_of(outcome: Outcome, plugins: tuple[Plugin, ...]) -> Row:
    """Return the row of a cell: what its worker returned, or how it failed. Facts known beforehand take precedence."""
    cell, *record, limit = outcome.task.arguments
    row = {"verdict": outcome.failure, "reason": outcome.reason} if outcome.failure else outcome.value
    if not isinstance(row, dict) or row.get("verdict") not in list(Verdict):
        row = {"verdict": Verdict.CRASHED, "reason": "the worker returned a malformed row"}
    return row | known_row(cell, limit, plugins, *record) | {"host": row.get("host", machine.host())}


def now() -> str:
    """Return the time as it is written into the manifest."""
    return datetime.now(UTC).isoformat(timespec="seconds")
