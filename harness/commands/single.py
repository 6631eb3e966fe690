"""One problem with every solver, and one cell again: both in isolated workers, both verified like any run."""

import json
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from harness.cells import worker
from harness.cells.collect import Entry, Met, collect, facts
from harness.cells.rows import PROBLEM_FACTS
from harness.commands.trusted import trusted
from harness.plans.plan import COLD, DriveCell, Plan, Plugin, SolveCell, Source, origin
from harness.plans.spec import parse
from harness.plans.suites import RELAXED
from harness.run import row_of_the_dead
from harness.workers.introduce import introduce
from harness.workers.pool import Pool
from harness.workers.task import Task
from problems import scene
from problems.recorded.own import load, save
from results import store
from results.store import ResultsError, Row
from solvers import available


def solve_one(problem: str, solver_specs: list[str], tol: float, time_limit: float, jobs: int) -> None:
    """Put solvers (all, if none are named) to one problem and print a table. Errors: InputError naming the field."""
    variants, plugins = introduce(solver_specs) if solver_specs else (_everyone(), ())
    plan = Plan("solve", (), variants, (tol,), time_limit=time_limit, plugins=plugins)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        entry = _stage(problem, folder)
        cells = plan.solve_cells([entry])
        tasks = [
            Task(cell.variant, worker.run_solve, (cell, entry, time_limit), time_limit, plan.owner(cell.variant))
            for cell in cells
        ]
        with Pool(folder, jobs, plugins, plan.memory_limit) as pool:
            rows = {outcome.task.name: outcome.value or row_of_the_dead(outcome, plugins) for outcome in pool.run(tasks)}
    title = f"{problem}: {entry['contacts']} contacts, LCP of {entry['size']} unknowns, tolerance {tol:g}"
    _show(title, [rows[cell.variant] for cell in cells])


def _everyone() -> tuple[str, ...]:
    """All solvers, the outside ones with each backend."""
    outside = {variant.partition("[")[0] for variant in RELAXED}
    return (*(name for name in sorted(available()) if name not in outside), *RELAXED)


def rerun_row(folder: Path, key: str, files: list[str]) -> tuple[Row, Row]:
    """Run the cell of a row again; the row and the new one. files: of solvers, which the user trusts.

    Errors: ResultsError where there is no such row, InputError where its solver is in none of the files and not ours.
    """
    settings = store.read_manifest(folder)["settings"]
    for table in ("solves", "drives"):
        row = store.read_rows(folder, table).get(key)
        if row is not None:
            break
    else:
        raise ResultsError(f"{folder}: no row has the key {key!r}")
    plugins = trusted(row, settings, files)
    task = _task_again(row, table, plugins)
    with tempfile.TemporaryDirectory() as name:
        if table == "solves":
            (Path(name) / "problems").symlink_to((folder / "problems").resolve())
        with Pool(Path(name), 1, plugins, settings["memory_limit"]) as pool:
            (outcome,) = pool.run([task])
    return row, outcome.value or row_of_the_dead(outcome, plugins)


def show_rerun(folder: Path, key: str, files: list[str]) -> None:
    """Run the cell of a row again and print both rows. Errors: as rerun_row."""
    row, again = rerun_row(folder, key, files)
    _show(f"{key}: {row['scene']} {row['parameters']}, tolerance {row['tol']:g}", [row, again])


def _stage(problem: str, folder: Path) -> Entry:
    """Store the problem of a file or the first problem of a scene under folder."""
    if Path(problem).is_file() or Path(problem.partition("[")[0]).suffix:
        loaded = load(Path(problem))
        (folder / "problems").mkdir()
        save(loaded, folder / "problems" / f"{loaded.hash}.npz")
        return facts(Source(Path(problem).name), Met(0, "step", loaded)) | {"starts": [COLD]}
    name, settings = parse("scene", problem)
    scene(name, **settings)
    return collect(folder, Source(name, settings))[0]


def _task_again(row: Row, table: str, plugins: tuple[Plugin, ...]) -> Task:
    limit, owner = row["time_limit"], row["variant"] if plugins else ""
    if table == "solves":
        entry = {name: row[name] for name in PROBLEM_FACTS if name in row}
        cell = SolveCell(row["problem"], origin(row), row["variant"], row["tol"], row["start"])
        return Task(row["variant"], worker.run_solve, (cell, entry, limit), limit, owner)
    facts = json.loads(row["parameters"]), row["variant"], row["tol"], row["scheme"], row["steps"], row["after_failure"]
    drive = DriveCell(row["scene"], *facts)
    return Task(row["variant"], worker.run_drive, (drive, limit), limit, owner)


def _show(title: str, rows: list[Row]) -> None:
    table = Table(title=Text(title), title_justify="left", box=None, pad_edge=False, header_style="bold")
    for name in ("solver", "claims", "verdict", "residual", "of its model", "form", "setup", "solve", "work", "remark"):
        table.add_column(name, overflow="fold")
    for row in rows:
        numbers = [_number(row.get(name)) for name in ("residual", "model_residual")]
        times = [_time(row.get(name)) for name in ("form_time", "setup_time", "solve_time")]
        work = ", ".join(f"{key} {value}" for key, value in json.loads(row.get("work") or "{}").items())
        table.add_row(
            row["variant"], (row.get("status") or "").lower(), row["verdict"], *numbers, *times, work, row.get("reason") or ""
        )
    Console().print(table, markup=False)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"


def _time(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f"{seconds * 1e6:.0f} µs" if seconds < 1e-3 else f"{seconds * 1e3:.1f} ms" if seconds < 1 else f"{seconds:.2f} s"
