"""What happens inside a worker process: one core, one thread, bounded memory, silence, and a shard of its own.

A worker dies with a solver that takes too long, crashes or eats the memory; nothing else is lost with it, for every row is
on disk before the next cell begins.
"""

import gc
import json
import os
import time
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from harness import machine
from harness.cells.collect import Entry, collect, stored, stored_start
from harness.cells.drive import drive, refusal
from harness.cells.record import keep
from harness.cells.rows import drive_row, solve_row
from harness.cells.timing import Timing, time_solver
from harness.plans.plan import COLD, DriveCell, SolveCell, Source
from harness.verify import Finding, verify
from problems import FrictionProblem, scene
from problems.nature.stability import backward_error
from results.schema import CRASHED, SKIPPED, TIMEOUT, WRONG
from results.store import Row, ShardWriter
from solvers import Answer, Solver, Status, find, plugins


@dataclass
class _Worker:
    folder: Path
    core: int
    shards: dict[str, ShardWriter]
    warm: set[tuple[str, int, bool]] = field(default_factory=set)


_worker: _Worker


def start(folder: Path, plugin_files: tuple[str, ...], memory_limit: int) -> None:
    """Make this process a worker of the run in folder."""
    global _worker  # noqa: PLW0603  # a worker process has one state, set once
    machine.pin_threads()
    _be_silent()
    core = machine.hold_core()
    for path in plugin_files:
        plugins.load(Path(path))
    shards = {table: ShardWriter(folder, table, f"{os.getpid()}-{time.time_ns()}") for table in ("solves", "drives")}
    _worker = _Worker(folder, core, shards)
    machine.bound_memory(memory_limit)


def run_source(source: Source) -> list[Entry]:
    """Collect a source's problems."""
    return collect(_worker.folder, source)


def run_solve(cell: SolveCell, entry: Entry, limit: float) -> Row:
    """Run one solve cell and leave its row."""
    begun = time.perf_counter()
    row = solve_row(cell, entry, limit)
    info, solver = find(cell.variant)
    problem = _problem(cell.problem)
    takes_start = info.warm_start or cell.start == COLD
    if reason := info.missing or info.refuses(problem) or (None if takes_start else f"{info.name} takes no start"):
        return _leave("solves", begun, row | {"verdict": SKIPPED, "reason": reason})
    begun += _warm_up(cell.variant, problem.dimension, problem.joints.shape[0] > 0)
    machine.forget_peak_memory()
    try:
        answer, timing = _timed(solver, problem, cell, limit)
    except Exception as error:  # whatever a solver raises is its row, not our end
        return _leave("solves", begun, row | {"verdict": CRASHED, "reason": f"{type(error).__name__}: {error}"[:500]})
    row["peak_memory"] = machine.peak_memory()
    if problem.fresh().hash != cell.problem:
        row |= {"verdict": WRONG, "reason": "the solver changed its input", "claimed": True}
        _leave("solves", begun, row)
        os._exit(1)  # nothing in this process can be trusted any more
    finding = verify(problem, answer, info, cell.tol)
    row |= _found(problem, answer, finding, timing, limit)
    return _leave("solves", begun, row | {"overhead": time.perf_counter() - begun - timing.spent})


def run_drive(cell: DriveCell, limit: float) -> Row:
    """Drive one scene with one solver and leave the row."""
    begun = time.perf_counter()
    row = drive_row(cell, limit)
    info, solver = find(cell.variant)
    if reason := refusal(cell, info):
        return _leave("drives", begun, row | {"verdict": SKIPPED, "reason": reason})
    begun += _warm_up(cell.variant, 2, bool(scene(cell.scene, **cell.parameters).hinges))
    machine.forget_peak_memory()
    try:
        with machine.hard_limit(limit):
            driven = drive(cell, info, solver)
    except Exception as error:
        return _leave("drives", begun, row | {"verdict": CRASHED, "reason": f"{type(error).__name__}: {error}"[:500]})
    return _leave("drives", begun, row | driven | {"peak_memory": machine.peak_memory()})


def run_motion(source: Source) -> None:
    """Record the motion of a driven scene."""
    keep(_worker.folder, source)


def _timed(solver: Solver, problem: FrictionProblem, cell: SolveCell, limit: float) -> tuple[Answer, Timing]:
    """The answer and its times, the first call under the hard limit; repeats have ten times as long, for noise."""
    start = stored_start(_worker.folder, cell.problem, cell.start)
    with machine.hard_limit(limit) as alarm:
        return time_solver(
            solver,
            problem,
            solve=lambda prepared: solver.solve(prepared, cell.tol, None, start),
            answered=lambda: alarm(10 * limit),
        )


def _found(problem: FrictionProblem, answer: Answer, finding: Finding, timing: Timing, limit: float) -> Row:
    free = problem.free_velocity
    energy = float(free @ (problem.mass @ free)) / 2 or 1.0
    row: Row = {
        "status": answer.status.name,
        "claimed": answer.status is Status.SOLVED,
        "verdict": finding.verdict,
        "reason": finding.reason,
        "residual": finding.residual,
        "model_residual": finding.model_residual,
        "residual_floor": finding.floor,
        "fclib_error": finding.fclib_error,
        "backward_error": backward_error(problem, np.asarray(answer.impulse, dtype=float)),
        "energy_defect": abs(finding.energy_defect) / energy,
        "work": json.dumps(answer.work, sort_keys=True),
    }
    if not timing.solve:
        return row | {"reason": "; ".join(filter(None, (finding.reason, "every call compiled or loaded something: no times")))}
    for step, times in (("form", timing.form), ("setup", timing.setup), ("solve", timing.solve)):
        row |= {f"{step}_time": float(np.median(times)), f"{step}_times": times}
    if row["form_time"] + row["setup_time"] + row["solve_time"] > limit:
        row |= {"verdict": TIMEOUT, "reason": "its median time is past the limit"}
    return row


@lru_cache(maxsize=8)
def _problem(name: str) -> FrictionProblem:
    return stored(_worker.folder, name)


def _leave(table: str, begun: float, row: Row) -> Row:
    row |= {"core": _worker.core, "wall_time": time.perf_counter() - begun}
    _worker.shards[table].write(row)
    return row


def _warm_up(variant: str, dimension: int, jointed: bool) -> float:
    """Load and compile what the solver needs, once a worker, on a sliding contact; the seconds it took.

    What goes wrong here goes wrong again in the cell.
    """
    if (variant, dimension, jointed) in _worker.warm:
        return 0.0
    begun = time.perf_counter()
    _worker.warm.add((variant, dimension, jointed))
    _, solver = find(variant)
    free = np.zeros(dimension + 1)
    free[:2] = -1.0, 1.0
    rows = np.eye(dimension + 1)
    problem = FrictionProblem(
        mass=rows,
        normal=rows[:1],
        tangent=rows[1:dimension],
        friction=np.array([0.5]),
        free_velocity=free,
        bias=np.zeros(1),
        joints=rows[dimension:] if jointed else rows[:0],
        dimension=dimension,
    )
    with suppress(Exception):
        solver.solve(solver.prepare(problem), 1e-6, None)
    gc.collect()
    gc.freeze()  # what is loaded now stays; collections between cells need not look at it
    return time.perf_counter() - begun


def _be_silent() -> None:
    """Send what solvers print, from Python or native code, to nowhere."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
