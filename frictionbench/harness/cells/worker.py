"""The functions that run in a worker process: one core, one thread, bounded memory.

A solver that takes too long, crashes or exhausts the memory ends only its worker. It receives a copy of the problem, and its
answer is verified on the original.
"""

import gc
import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness import machine, process
from frictionbench.harness.cells.batch import batch_of, time_batch
from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.motion import record_motion
from frictionbench.harness.cells.rows import finding_columns, solver_facts, verified
from frictionbench.harness.cells.simulation import malformed, refusal, run_closed_loop
from frictionbench.harness.cells.stored import Record, stored, stored_answer, stored_start
from frictionbench.harness.cells.timing import MOST_REPEATS, time_solver
from frictionbench.harness.contract.check import CHECKS, Subject, contact
from frictionbench.harness.contract.checks import inapplicable
from frictionbench.harness.deadline import COMPILE_SECONDS, HARNESS_SECONDS, Deadline
from frictionbench.harness.plans.plan import BatchCell, Plugin, SimulationCell, SolveCell, Source, plugin_of
from frictionbench.harness.workers.pool import Settings
from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.analysis.contradiction import contradiction
from frictionbench.problems.answer import AnswerError, checked_copy
from frictionbench.problems.catalogue import problem_of, scene
from frictionbench.problems.copies import duplicate, same
from frictionbench.problems.spec import split
from frictionbench.problems.verdicts import RANK, Verdict
from frictionbench.problems.verify import verify
from frictionbench.results.conventions import COLD
from frictionbench.results.files import ResultsError
from frictionbench.results.motion import encoded
from frictionbench.results.store import Row
from frictionbench.solvers import Solver, SolverInfo, find, plugins
from frictionbench.solvers.interface import dense_storage


@dataclass
class _Worker:
    deadline: Deadline
    core: int | None
    folder: Path
    plugins: tuple[Plugin, ...]
    memory: int
    report_loaded: Callable[[], None]
    warm: dict[tuple[str, int, bool], Row] = field(default_factory=dict)  # see _warm_up
    solved_before: set[tuple[str, str]] = field(default_factory=set)  # variants and problems


_worker: _Worker
IMPORT_SECONDS = 60.0  # time limit in seconds for a plug-in's import: large libraries take over ten from a cold disk
LOAD_SECONDS = 30.0  # least time limit in seconds for an outside library's first call, on one contact, in which it is loaded
FOREIGN_COMPILING = 120.0  # seconds that a plug-in's first call may spend in compiling its kernels, and ours that it calls
FOREIGN_LOADING = 10.0  # seconds not counted in a plug-in's cell, in which kernels of ours that it calls are loaded
FIRST_TOLERANCE = 1e-6  # tolerance of a solver's first call: the tightest for single precision
SHARED = 0.02  # a cell that waited for its core for more than this share of the timed seconds is marked as disturbed


def start(deadline: Deadline, core: int | None, settings: Settings, report_loaded: Callable[[], None]) -> None:
    """Make this process a worker, pinned to its own core if there is one.

    report_loaded: called before and after a solver's first call, to report to the main process what has been loaded.
    """
    global _worker  # noqa: PLW0603  # the state of the worker process, set once
    if core is not None:
        os.sched_setaffinity(0, {core})
    folder, plugin_files, memory_limit = settings
    _worker = _Worker(deadline, core, folder, plugin_files, process.bound_memory(memory_limit), report_loaded)


def folder() -> Path:
    """The folder of the run."""
    return _worker.folder


def prepared(name: str, variant: str, limit: float) -> tuple[FrictionProblem, Solver]:
    """Return a stored friction problem and a solver warmed up for it. The task may take `limit` seconds from then on."""
    _, solver = _solver(variant)
    problem = _problem(name)
    assert isinstance(problem, FrictionProblem)
    _warm_up(variant, *_kind(problem), limit)
    _worker.deadline.allow(limit)
    return problem, solver


def describe_plugin(source: str, named: list[str]) -> dict[str, Any]:
    """Import a plug-in; return the fields of harness.plans.plan.Plugin for the named variants and all solvers of a file."""
    content, version = plugins.content(source), plugins.version(source)
    names = plugins.load(source)
    defined = names if plugins.defines_all(source) else ()
    variants = [*defined, *(spec for spec in named if split("solver", spec)[0] in names)]
    return {"source": source, "content": content, "solvers": {v: solver_facts(v) | {"version": version} for v in variants}}


def run_source(source: Source) -> list[Record] | str:
    """Collect a source's problems. Return their records or, if they cannot be stored, the reason, which ends the run."""
    try:
        return collect(_worker.folder, source)
    except (OSError, ResultsError) as error:
        return plugins.describe_error(error)


def run_scene(name: str, parameters: dict[str, Any]) -> None:
    """Build a scene and its first problem, or an instance."""
    problem_of(name, **parameters)


def run_problem(source: Source) -> dict[str, Any]:
    """Collect a source's first problem without solving it. Return its record, its summary, whether its mechanics are given, and
    the contradiction in it as text, if any."""
    record, *_ = collect(_worker.folder, source, described=False)
    problem = stored(_worker.folder, record["problem"])
    facts = {"record": record, "summary": problem.summary, "mechanical": False, "contradiction": ""}
    if isinstance(problem, FrictionProblem):
        facts |= {"mechanical": problem.mechanical, "contradiction": str(contradiction(problem) or "")}
    return facts


def run_solve(cell: SolveCell, record: Record, limit: float) -> Row:
    """Run a solve cell and return its row."""
    if record.get("reason"):  # the source yielded no problem
        return _row(cell.variant, (0, False), limit, record["reason"], dict)
    info, solver = _solver(cell.variant)
    problem = _problem(cell.problem)
    takes_start = info.warm_start or cell.start == COLD
    no_start = None if takes_start else f"{info.name} takes no start: it does not declare warm_start=True"
    reason = info.missing or info.refuses(problem) or info.too_tight(cell.tol) or _too_large(solver, problem) or no_start
    return _row(cell.variant, _kind(problem), limit, reason, lambda: _solved(cell, record, limit, problem, info, solver))


def _too_large(solver: Solver, problem: FrictionProblem | LCP) -> str | None:
    """Return that the solver's dense matrices do not fit into memory, or None."""
    need = dense_storage(solver, problem)
    reason = f"its dense matrices need {need / 2**30:.1f} GiB, and the memory is limited to {_worker.memory / 2**30:.1f} GiB"
    return reason if need > _worker.memory else None


def _solved(
    cell: SolveCell, record: Record, limit: float, problem: FrictionProblem | LCP, info: SolverInfo, solver: Solver
) -> Row:
    """Call the solver and return the columns of its answers. The limit applies to the first call; repeats, which are few or
    short, may take a second more."""
    handed, case = duplicate(problem), (cell.variant, cell.problem)
    met_before = _foreign(cell.variant) and case in _worker.solved_before
    _worker.solved_before.add(case)
    digest = (record.get("starts") or {}).get(cell.start, "")
    start, handed_start = (stored_start(_worker.folder, cell.problem, cell.origin, cell.start, digest) for _ in range(2))
    begun, waited = perf_counter(), process.waited()
    try:
        timing = time_solver(
            solver,
            handed,
            solve=lambda prepared: solver.solve(prepared, cell.tol, None, handed_start),
            restart_limit=lambda: _worker.deadline.allow(limit + 1.0),
            rank=lambda posed, answer: RANK[verified(posed, answer, info, cell.tol).verdict],
            most=record.get("repeats") or MOST_REPEATS,
            remote=info.remote and info.ours,
            met_before=met_before,
        )
    except AnswerError as error:
        return {"verdict": malformed(error), "reason": str(error), "claimed": error.claimed}
    _worker.deadline.allow(HARNESS_SECONDS)
    row = _machine_columns(waited, timing.spent)
    reference = stored_answer(_worker.folder, cell.problem)
    row |= finding_columns(problem, timing, info, cell.tol, limit, reference, disturbed=bool(row["disturbed"]))
    if not same(problem, handed) or not np.array_equal(start, handed_start):  # type: ignore[arg-type]  # may be None
        row |= {"verdict": Verdict.WRONG, "reason": "the solver changed its input"}
    return row | {"overhead": perf_counter() - begun - timing.spent}


def run_simulation(cell: SimulationCell, limit: float) -> Row:
    """Simulate a scene with a solver and return the row of the simulation cell."""
    info, solver = _solver(cell.variant)
    stage = scene(cell.scene, **cell.parameters)
    kind, reason = (stage.dimension, bool(stage.hinges)), refusal(cell, stage, info)
    return _row(cell.variant, kind, limit, reason, lambda: run_closed_loop(cell, stage, info, solver))


def run_batch(cell: BatchCell, limit: float) -> Row:
    """Solve the problems of a batch in one way and return the row of the batch cell."""
    info, _ = _solver(cell.variant)
    with _worker.deadline.within(limit, COMPILE_SECONDS):
        batch = batch_of(cell.scene, json.dumps(cell.parameters), cell.count)
    reason = info.missing or info.too_tight(cell.tol) or next(filter(None, map(info.refuses, batch.problems)), None)
    kind = batch.facts["dimension"], False
    return batch.facts | _row(cell.variant, kind, limit, reason, lambda: time_batch(cell, batch, info))


def _row(variant: str, kind: tuple[int, bool], limit: float, reason: str | None, measure: Callable[[], Row]) -> Row:
    """Return the columns that `measure` finds within the limit, and those of the machine. Whatever a solver raises, SystemExit
    included, is a crash. A worse verdict of _warm_up takes precedence. reason: why the cell is skipped. kind: see _kind."""
    row: Row = {"verdict": Verdict.SKIPPED, "reason": reason}
    first = {} if reason else _warm_up(variant, *kind, limit)
    process.reset_peak_memory()
    begun, waited = perf_counter(), process.waited()
    if not reason:
        try:
            # the seconds of compiling or cache reading by numba that are not counted, and whether only our kernels' are
            compiling = (FOREIGN_LOADING, True) if _foreign(variant) else (COMPILE_SECONDS, False)
            with _worker.deadline.within(limit, *compiling):
                row = measure()
            row = _machine_columns(waited, perf_counter() - begun) | row
        except BaseException as error:
            row = {"verdict": Verdict.CRASHED, "reason": plugins.describe_error(error)}
    if first and RANK[first["verdict"]] > RANK[row["verdict"]]:
        row |= first
    return row | {"host": machine.host(), "core": _worker.core, "wall_time": perf_counter() - begun}


def require_available(variant: str) -> None:
    """Errors: InputError if what the solver needs is not installed."""
    if missing := _solver(variant)[0].missing:
        raise InputError(f"solver: {variant}: {missing}")


def run_check(variant: str, check: str, limit: float) -> list[str] | str:
    """Return at most five violations of a check of the contract (harness.contract), which also gets those of first calls, or
    why the check does not apply."""
    info, solver = _solver(variant)
    broken = [str(row["reason"]) for dimension in info.dimension if (row := _warm_up(variant, dimension, False, limit))]
    with _worker.deadline.within(limit), process.no_forked_child():
        return inapplicable(check, info) or list(islice(CHECKS[check].violations(Subject(info, solver, broken)), 5))


def run_show(name: str, settings: dict[str, Any], variant: str, scheme: str, steps: int | None) -> dict[str, Any]:
    """Return the motion of a scene by a solver, encoded, because a plug-in's sandboxed worker cannot write files."""
    _solver(variant)
    return encoded(record_motion(scene(name, **settings), variant, scheme, steps))


def _solver(variant: str) -> tuple[SolverInfo, Solver]:
    """Return the solver of a variant. A plug-in is imported. Errors: InputError if its content changed since the run began."""
    if plugin := plugin_of(variant, _worker.plugins):
        if plugins.content(plugin.source) != plugin.content:
            raise InputError(f"solver: {plugin.source} was changed since the run began; begin another run")
        with _worker.deadline.within(IMPORT_SECONDS):
            plugins.load(plugin.source)
    return find(variant)


@lru_cache(maxsize=8)  # the cells of a problem run one after another
def _problem(name: str) -> FrictionProblem | LCP:
    return stored(_worker.folder, name)


def _machine_columns(waited: float, spent: float) -> Row:
    """Return the columns of memory and core. waited: process.waited() before the cell began; spent: the timed seconds. A cell
    whose solver has left its core counts as disturbed too."""
    core_wait, own_core = process.waited() - waited, None if _worker.core is None else {_worker.core}
    left = own_core is None or os.sched_getaffinity(0) != own_core
    if own_core:
        os.sched_setaffinity(0, own_core)
    disturbed = left or not core_wait <= SHARED * spent
    return {"peak_memory": process.peak_memory(), "core_wait": core_wait, "disturbed": disturbed}


def _foreign(variant: str) -> bool:
    """Return whether the solver belongs to a plug-in."""
    return plugin_of(variant, _worker.plugins) is not None


def _kind(problem: FrictionProblem | LCP) -> tuple[int, bool]:
    """Return the problem's dimension, 0 for an LCP, and whether it has joints."""
    return (0, False) if isinstance(problem, LCP) else (problem.dimension, problem.joints.shape[0] > 0)


def _warm_up(variant: str, dimension: int, jointed: bool, limit: float) -> Row:
    """Load and compile what the solver needs, once per worker and kind of problem, by solving _smallest.

    If a first call fails and a second does not, the solver's answers depend on what the process did before. The verdict on the
    first, with the reason, is then returned for all cells of this worker. Other failures are ignored; they recur in the cell.
    """
    kind = (variant, dimension, jointed)
    if kind not in _worker.warm:
        _worker.warm[kind] = {}
        _worker.report_loaded()
        info, solver = find(variant)
        gc.disable()  # compilation keeps most objects that it creates; collection would free little in a tenth of the time
        seconds = max(limit, LOAD_SECONDS) if info.needs else limit
        compiling = FOREIGN_COMPILING if _foreign(variant) else COMPILE_SECONDS
        with suppress(BaseException), _worker.deadline.within(seconds, compiling), process.no_forked_child():
            first = _failure(info, solver, dimension, jointed)
            if first and not _failure(info, solver, dimension, jointed):
                _worker.warm[kind] = first
        _worker.report_loaded()
        gc.enable()
        gc.collect()
        gc.freeze()  # collections between cells skip what is loaded now, since it stays
    return _worker.warm[kind]


def _failure(info: SolverInfo, solver: Solver, dimension: int, jointed: bool) -> Row:
    """Return the verdict and its reason if a call on _smallest crashes or falsely claims to have solved it, otherwise {}."""
    try:
        answer = checked_copy(solver.solve(solver.prepare(_smallest(dimension, jointed)), FIRST_TOLERANCE, None))
        finding = verify(_smallest(dimension, jointed), answer, info.model, FIRST_TOLERANCE)
        verdict, reason = finding.verdict, finding.reason
    except AnswerError as error:
        verdict, reason = malformed(error), str(error)
    except BaseException as error:
        verdict, reason = Verdict.CRASHED, plugins.describe_error(error)
    text = f"the first call in its process, on a problem of one contact, is {verdict}, and the second is not: {reason}"
    return {"verdict": verdict, "reason": text} if verdict in (Verdict.WRONG, Verdict.CRASHED) else {}


def _smallest(dimension: int, jointed: bool) -> FrictionProblem | LCP:
    """Return a problem of one sliding contact, an LCP for dimension 0."""
    if dimension == 0:
        return LCP(np.eye(2), np.array([-1.0, 1.0]))
    problem = contact(dimension, spare=1)
    return problem.replace(joints=np.eye(dimension + 1)[-1:], joint_bias=np.zeros(1)) if jointed else problem
