"""`frictionbench solve` and `frictionbench rerun`: solve one problem with every solver, and run one cell again.

Both use isolated workers and verification, like any run.
"""

import json
import time
from pathlib import Path

import numpy as np

from frictionbench.commands.stored_cell import stored_cell, trusted
from frictionbench.commands.table import columns, say
from frictionbench.harness.cells import worker
from frictionbench.harness.plans.plan import BatchCell, Cell, Plan, Plugin, SimulationCell, SolveCell, Source, origin
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import COLLECT_SECONDS, cell_task, row_of
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems.catalogue import require_known
from frictionbench.problems.check import InputError, require
from frictionbench.problems.spec import parse
from frictionbench.problems.verdicts import ACCEPTED, RANK, Verdict
from frictionbench.reports.drawing.text import seconds
from frictionbench.results import store
from frictionbench.results.cells import counts
from frictionbench.results.conventions import RankBy, count, ending, number, scene_title
from frictionbench.results.files import json_text, printable
from frictionbench.results.schema import PROBLEM_FACTS, TABLES
from frictionbench.results.store import Row
from frictionbench.solvers import available, find
from frictionbench.solvers.plugins import installed

PLANAR = 2  # dimensions
FIRST = ("nsgs", "hybrid")  # run first: one compiles within seconds, the other solves nearly every problem
ANNOUNCED_AFTER = 5.0  # seconds after which the first answer is announced before the table


def solve_one(
    problem: str,
    solver_specs: list[str],
    tol: float,
    time_limit: float,
    jobs: int,
    *,
    rank_by: RankBy | None = None,
    progress: Progress | None = None,
    as_json: bool = False,
) -> None:
    """Solve one problem with solvers (all if none are named), and print a table with the best first.

    rank_by: the time that ranks; by default from bodies if the problem has them, otherwise from the method's own form.
    Errors: InputError naming the field.
    """
    begun, progress = time.monotonic(), progress or Progress()
    source = _source(problem)
    variants, plugins, unusable = (*load_plugins(solver_specs), []) if solver_specs else all_variants()
    plan = Plan("solve", (), variants, (tol,), time_limit=time_limit, plugins=plugins)
    with scratch_pool(plugins, jobs=jobs) as pool:
        (outcome,) = pool.run([Task(worker.run_problem, (source,), COLLECT_SECONDS)])
        facts = outcome.result(f"problem: {problem} cannot be made")
        record = facts["record"]
        rank_by = rank_by or (RankBy.BODIES if facts["mechanical"] else RankBy.FORM)
        for text in (f"{problem}: {facts['summary']}", facts["contradiction"]):
            if text and not as_json:
                say(printable(text))
        cells = sorted(plan.solve_cells([record]), key=lambda cell: [cell.variant != name for name in FIRST])
        tasks, rows, waiting = [cell_task(cell, time_limit, plugins, record) for cell in cells], [], True
        for outcome in progress.follow("solvers", pool, tasks):
            rows.append(row_of(outcome, plugins))
            solved = [row for row in rows if row["verdict"] == Verdict.SOLVED]
            if waiting and solved and time.monotonic() - begun > ANNOUNCED_AFTER and len(rows) < len(tasks):
                waiting = False
                first = f"{solved[0]['variant']} solves it {rank_by.words} in {_time(_seconds(solved[0], rank_by))}"
                progress.tell(f"{first}; the table follows when all have ended")
    if solver_specs and all(row["verdict"] == Verdict.SKIPPED for row in rows):
        raise InputError("solver: " + "; ".join(f"{row['variant']}: {row['reason']}" for row in rows))
    rows.sort(key=lambda row: (RANK[row["verdict"]], _seconds(row, rank_by), row["variant"]))
    applicable = [row for row in rows if row["verdict"] != Verdict.SKIPPED or solver_specs]
    if as_json:
        data = {"problem": problem, **{name: facts[name] for name in ("summary", "contradiction")}, "tol": tol}
        data |= {"rank_by": rank_by, "solvers": [_data(row) for row in applicable], "advice": advice(rows, rank_by)}
        print(json_text(data))
        return
    title = f"tolerance {number(tol)}, ranked {rank_by.words} ({rank_by.parts})"
    if record["dimension"] == PLANAR:  # in space the exact problem is not an LCP, and of a bare LCP the summary tells the size
        title = f"LCP of {record['size']} unknowns, {title}"
    _show(title, {str(rank): row for rank, row in enumerate(applicable, start=1)}, rank_by)
    for text in (*refusals([row for row in rows if row not in applicable]), *unusable, advice(rows, rank_by)):
        say(text)


def _data(row: Row) -> Row:
    """Return what `solve --json` prints for a solver: columns of a run's table, see docs/columns.md."""
    names = ("variant", "verdict", "status", "residual", "model_residual", "form_time", "setup_time", "solve_time", "reason")
    return {name: row.get(name) for name in names} | {"work": counts(row.get("work"))}


def refusals(skipped: list[Row]) -> list[str]:
    """Return a line for each reason why solvers were skipped, with their names."""
    names: dict[str, list[str]] = {}
    for row in skipped:
        names.setdefault(row["reason"].removeprefix(f"{row['solver']} "), []).append(row["variant"])
    return [printable(f"not applicable to this problem: {', '.join(each)}: {reason}") for reason, each in names.items()]


def advice(rows: list[Row], rank_by: RankBy = RankBy.BODIES) -> str:
    """Return the fastest solver of this problem, from rows with the best first, and that by the other ranking if it differs."""
    if solved := [row for row in rows if row["verdict"] == Verdict.SOLVED]:
        best, others = solved[0], len(solved) - 1
        text = f"fastest on this problem: {best['variant']}, {rank_by.words} in {_time(_seconds(best, rank_by))}"
        text += f"; {count(others, 'other')} solve{'s' * (others == 1)} it as well" if others else ""
        other = min(solved, key=lambda row: _seconds(row, rank_by.other))
        if other is not best and _seconds(other, rank_by.other) < _seconds(best, rank_by.other):
            text += f"; {rank_by.other.words} {other['variant']} is faster: {_time(_seconds(other, rank_by.other))}"
        return text
    answered = [row for row in rows if row.get("residual") is not None and row["residual"] < np.inf]
    if not answered:
        return "no solver returned an answer that can be judged"
    nearest = min(answered, key=lambda row: row["residual"])
    return f"no answer is known to be right; the smallest residual is {number(nearest['residual'], 2)}, by {nearest['variant']}"


def _seconds(row: Row, rank_by: RankBy) -> float:
    times = [row.get(name) for name in rank_by.columns]
    return sum(filter(None, times)) if times[-1] is not None else np.inf


def all_variants() -> tuple[tuple[str, ...], tuple[Plugin, ...], list[str]]:
    """Return the variants of all available solvers, including installed plug-ins; the plug-ins; and a line for each installed
    plug-in that cannot be used."""
    variants = [spec for _, info in sorted(available().items()) for spec in info.specs if not find(spec)[0].missing]
    plugins: list[Plugin] = []
    unusable = []
    for name in installed():
        try:
            named, loaded = load_plugins([name])
        except InputError as error:
            unusable.append(f"skipped: {error}")
        else:
            variants += named
            plugins += loaded
    return tuple(variants), tuple(plugins), unusable


def rerun_row(folder: Path, key: str, named: list[str]) -> tuple[Row, Row]:
    """Run the cell of a row again; return the row and the new one. named: outside solvers that the user trusts.

    Errors: as for store.find_row, and InputError if the row has no problem, or its solver is neither ours nor in `named`.
    """
    table, row, settings, memory_limit = stored_cell(folder, key)
    require(table != "solves" or bool(row["problem"]), "row", f"{row['key']} has no problem to run again: {row['reason']}")
    plugins = trusted(row, settings, named)
    with scratch_pool(plugins, memory_limit, folder=folder) as pool:
        (outcome,) = pool.run([_task_again(row, table, plugins)])
    return row, row_of(outcome, plugins)


def show_rerun(folder: Path, key: str, named: list[str]) -> None:
    """Run the cell of a row again and print both rows; without a key print all that failed. Errors: as for rerun_row,
    and InputError naming a column that a row lacks."""
    if not key:
        store.read_manifest(folder)
        rows = [row for table in TABLES for row in store.rows(folder, table).values()]
        for name in ("variant", "scene", "parameters", "tol", "verdict"):
            require(all(name in row for row in rows), name, f"a row of {folder} has none")
        failed = [row for row in rows if row["verdict"] not in (*ACCEPTED, Verdict.SKIPPED)]
        how = "; add a key to run it again, and --shrink to reduce its problem" if failed else ""
        _show(f"{count(len(failed), 'row')} failed{how}", {_cell_name(row): row for row in failed})
        return
    row, again = rerun_row(folder, key, named)
    _show(printable(_cell_name(row)), {"stored": row, "rerun": again})


def _cell_name(row: Row) -> str:
    step = "" if row.get("step") is None else f" step {row['step']:.0f}"
    return f"{row['key']} {scene_title(row['scene'], row['parameters'])}{step} to {number(row['tol'])}"


def _source(problem: str) -> Source:
    """Return the file, instance or scene that the command line names. Errors: InputError naming `problem` for a folder, and for
    a name that is neither a file nor known."""
    path = Path(problem)
    if path.is_dir():
        each, steps = (f"`frictionbench run {suite} --data {problem}`" for suite in ("recorded", "replay"))
        raise InputError(f"problem: {problem} is a folder; {each} solves each problem, {steps} a sequence of steps")
    if path.is_file() or Path(problem.partition("[")[0]).suffix:
        return Source(path.name, file=str(path.absolute()))
    name, settings = parse("scene", problem)
    require_known(name, settings)
    return Source(name, settings)


def _task_again(row: Row, table: str, plugins: tuple[Plugin, ...]) -> Task:
    limit, variant, tol = row["time_limit"], row["variant"], row["tol"]
    if table == "solves":
        record = {name: row[name] for name in PROBLEM_FACTS}
        return cell_task(SolveCell(row["problem"], origin(row), variant, tol, row["start"]), limit, plugins, record)
    scene, parameters = row["scene"], json.loads(row["parameters"])
    if table == "batches":
        cell: Cell = BatchCell(scene, parameters, row["problems"], variant, row["way"], tol, row["start"])
    else:
        cell = SimulationCell(scene, parameters, variant, tol, row["scheme"], row["steps"])
    return cell_task(cell, limit, plugins)


def _show(title: str, rows: dict[str, Row], rank_by: RankBy = RankBy.BODIES) -> None:
    """Print a table of rows with their labels, and the rows' reasons below."""
    lines = []
    for label, row in rows.items():
        times = [_time(row.get(name)) for name in ("form_time", "setup_time", "solve_time")]
        work = ", ".join(f"{key} {value}" for key, value in counts(row.get("work")).items())
        residuals = ["" if (size := row.get(name)) is None else number(size, 2) for name in ("residual", "model_residual")]
        verdict = ending(row["verdict"], row.get("model", ""))
        results = (verdict, residuals[0], _time(_seconds(row, rank_by)), residuals[1])
        cells = (label, row["variant"], *results, *times, (row.get("status") or "").lower(), work)
        lines.append(tuple(map(printable, cells)))
    header = ("", "solver", "verdict", "residual", "time", "model residual", "form", "setup", "solve", "status", "work")
    spare = ("work", "status", "model residual", "setup", "form", "solve")
    say(title)
    print(*columns(header, lines, spare), sep="\n")
    for label, row in rows.items():
        if row.get("reason"):
            say(printable(f"{label} {row['variant']}: {row['reason']}"), "  ")


def _time(value: float | None) -> str:
    """Format a time, s, with three digits and a unit; empty if it is unknown."""
    return "" if value is None or value == np.inf else seconds(value, 3)
