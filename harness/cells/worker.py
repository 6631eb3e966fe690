"""What happens inside a worker process: one core, one thread, bounded memory, silence.

A worker dies with a solver that takes too long, crashes or eats the memory; nothing else is lost with it. What a solver is
given is a copy, and its answer is verified on the problem that it never held.
"""

import gc
import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness import process
from frictionbench.harness.cells.answers import AnswerError
from frictionbench.harness.cells.collect import Entry, collect, stored, stored_start
from frictionbench.harness.cells.convergence import convergence_history
from frictionbench.harness.cells.polygon import measure
from frictionbench.harness.cells.record import keep, record
from frictionbench.harness.cells.rows import simulation_row, solve_row, solver_facts
from frictionbench.harness.cells.simulation import refusal, run_closed_loop
from frictionbench.harness.cells.timing import MOST, Timing, time_solver
from frictionbench.harness.deadline import Deadline
from frictionbench.harness.plans.plan import Plugin, SimulationCell, SolveCell, Source
from frictionbench.harness.verify import Finding, verify, verify_lcp
from frictionbench.problems import LCP, FrictionProblem, InputError, scene
from frictionbench.problems.analysis.mode import mode
from frictionbench.problems.analysis.stability import backward_error
from frictionbench.problems.copies import duplicate, same
from frictionbench.problems.measures import defects
from frictionbench.problems.spec import split
from frictionbench.results.conventions import COLD
from frictionbench.results.motion import write_motion
from frictionbench.results.polygon import read_deviations, write_deviations
from frictionbench.results.store import Row
from frictionbench.results.verdicts import RANK, Verdict
from frictionbench.solvers import Answer, Solver, SolverInfo, Status, find, plugins

MOST_TOLD = 24  # contacts whose mode a row tells


@dataclass
class _Worker:
    deadline: Deadline
    core: int | None
    folder: Path
    plugins: tuple[Plugin, ...]
    warm: set[tuple[str, int, bool]] = field(default_factory=set)


_worker: _Worker
FAR, NOTICED = 5.0, 1e-3  # a first call that took so many times as long as the repeats, and so many seconds, is remarked on
IMPORTING = 60.0  # seconds a plug-in's import may take
SHOWN = Path("motion") / "shown.json"  # of a motion that is recorded for itself
LOADING = 30.0  # seconds in which an outside library may be loaded and solve a single contact, whatever the limit


def start(deadline: Deadline, core: int | None, folder: Path, plugin_files: tuple[Plugin, ...], memory_limit: int) -> None:
    """Make this process a worker of the run in folder, alone on a core where there is one."""
    global _worker  # noqa: PLW0603  # a worker process has one state, set once
    if core is not None:
        os.sched_setaffinity(0, {core})
    _worker = _Worker(deadline, core, folder, plugin_files)
    process.bound_memory(memory_limit)


def describe_plugin(source: str, named: list[str], limit: float) -> dict[str, Any]:
    """Import a plug-in and tell what harness.plans.plan.Plugin holds, of the variants named and of all solvers in a file."""
    with _worker.deadline.within(limit):
        content, version = plugins.content(source), plugins.version(source)
        names = plugins.load(source)
    whole = names if plugins.is_file(source) else ()
    variants = [*whole, *(spec for spec in named if split("solver", spec)[0] in names)]
    return {"source": source, "content": content, "solvers": {v: solver_facts(v) | {"version": version} for v in variants}}


def run_source(source: Source, limit: float) -> list[Entry]:
    """Collect a source's problems."""
    with _worker.deadline.within(limit):
        return collect(_worker.folder, source)


def run_solve(cell: SolveCell, entry: Entry, limit: float) -> Row:
    """Run one solve cell; its row."""
    begun = perf_counter()
    row = solve_row(cell, entry, limit, _worker.plugins)
    info, solver = _solver(cell.variant)
    problem = _problem(cell.problem)
    takes_start = info.warm_start or cell.start == COLD
    if reason := info.missing or info.refuses(problem) or (None if takes_start else f"{info.name} takes no start"):
        return _done(begun, row | {"verdict": Verdict.SKIPPED, "reason": reason})
    begun += _warm_up(cell.variant, *_kind(problem), limit)
    given = duplicate(problem)
    process.forget_peak_memory()
    try:
        with process.watch_core() as core:
            timing = _timed(solver, given, cell, limit, entry.get("repeats") or MOST)
    except AnswerError as complaint:
        verdict = Verdict.WRONG if complaint.claimed else Verdict.UNSOLVED
        return _done(begun, row | {"verdict": verdict, "reason": str(complaint), "claimed": complaint.claimed})
    except BaseException as error:  # whatever a solver raises is its row, not our end
        return _done(begun, row | {"verdict": Verdict.CRASHED, "reason": plugins.describe_error(error)})
    row["peak_memory"] = process.peak_memory()
    row |= _undisturbed(core, timing.spent)
    row |= _found(problem, timing, info, cell.tol, limit, disturbed=bool(row["disturbed"]))
    if not same(problem, given):
        row |= {"verdict": Verdict.WRONG, "reason": "the solver changed its input"}
    return _done(begun, row | {"overhead": perf_counter() - begun - timing.spent})


def _worst(findings: list[tuple[Finding, Answer]]) -> tuple[Finding, Answer]:
    return max(findings, key=lambda found: (RANK[found[0].verdict], found[0].residual))


def run_simulation(cell: SimulationCell, limit: float) -> Row:
    """Simulation one scene with one solver; the row."""
    begun = perf_counter()
    row = simulation_row(cell, limit, _worker.plugins)
    info, solver = _solver(cell.variant)
    if reason := refusal(cell, info):
        return _done(begun, row | {"verdict": Verdict.SKIPPED, "reason": reason})
    begun += _warm_up(cell.variant, 2, bool(scene(cell.scene, **cell.parameters).hinges), limit)
    process.forget_peak_memory()
    try:
        with _worker.deadline.within(limit), process.watch_core() as core:
            simulated = run_closed_loop(cell, info, solver)
    except BaseException as error:
        return _done(begun, row | {"verdict": Verdict.CRASHED, "reason": plugins.describe_error(error)})
    return _done(begun, row | simulated | {"peak_memory": process.peak_memory()} | _undisturbed(core, perf_counter() - begun))


def run_check(variant: str, check: str, complaints: Callable[[SolverInfo, Solver, str], list[str]], limit: float) -> list[str]:
    """What a check of the contract (harness.contract) has to say of a solver."""
    info, solver = _solver(variant)
    for dimension in info.dimension:
        _warm_up(variant, dimension, False, limit)
    with _worker.deadline.within(limit), process.no_forked_child():
        return complaints(info, solver, check)


def run_history(name: str, variant: str, tol: float, limit: float) -> dict[str, Any]:
    """How a solver gets to its answer on a stored problem: units of work, verified residuals, the last impulses."""
    _, solver = _solver(variant)
    problem = _problem(name)
    assert isinstance(problem, FrictionProblem)
    _warm_up(variant, problem.dimension, problem.joints.shape[0] > 0, limit)
    with _worker.deadline.within(limit):
        units, residuals, impulse = convergence_history(problem, solver, tol)
    kept = np.isfinite(residuals)
    told = {"units": np.array(units)[kept].tolist(), "residuals": np.array(residuals)[kept].tolist()}
    return told | {"impulse": impulse.tolist()}


def run_motion(source: Source, limit: float) -> None:
    """Record the motion of a simulated scene."""
    with _worker.deadline.within(limit):
        keep(_worker.folder, source)


def run_show(name: str, settings: dict[str, Any], variant: str, scheme: str, steps: int | None, limit: float) -> None:
    """Record the motion of a scene by a solver, as folder/SHOWN."""
    _solver(variant)
    with _worker.deadline.within(limit):
        write_motion(_worker.folder / SHOWN, record(scene(name, **settings), variant, scheme, steps))


def run_polygon(limit: float) -> None:
    """Leave in the folder what polygons make of a ball's motion, unless it is there."""
    if not read_deviations(_worker.folder):
        with _worker.deadline.within(limit):
            write_deviations(_worker.folder, measure())


def _solver(variant: str) -> tuple[SolverInfo, Solver]:
    """The solver; where it is a plug-in's, that is imported now, if it is still what the run began with."""
    for plugin in _worker.plugins:
        if variant in plugin.solvers:
            if plugins.content(plugin.source) != plugin.content:
                raise InputError(f"solver: {plugin.source} was changed since the run began")
            with _worker.deadline.within(IMPORTING):
                plugins.load(plugin.source)
    return find(variant)


def _timed(solver: Solver, problem: FrictionProblem | LCP, cell: SolveCell, limit: float, repeats: int) -> Timing:
    """The answers and their times, the first call under the limit; repeats, which are few or short, have a second more."""
    start = stored_start(_worker.folder, cell.problem, cell.origin, cell.start)
    with _worker.deadline.within(limit) as allow:
        return time_solver(
            solver,
            problem,
            solve=lambda prepared: solver.solve(prepared, cell.tol, None, start),
            answered=lambda: allow(limit + 1.0),
            most=repeats,
        )


def _found(
    problem: FrictionProblem | LCP, timing: Timing, info: SolverInfo, tol: float, limit: float, *, disturbed: bool
) -> Row:
    """What verification finds of the answers that were timed: of unlike ones the worst counts.

    disturbed: something else took the core meanwhile, which may have made the first call a slow one.
    """
    findings = [
        (verify_lcp(problem, answer, tol) if isinstance(problem, LCP) else verify(problem, answer, info, tol), answer)
        for answer in timing.answers
    ]
    finding, answer = _worst(findings)
    row: Row = {
        "status": answer.status.name,
        "claimed": answer.status is Status.SOLVED,
        "verdict": finding.verdict,
        "reason": finding.reason,
        "residual": finding.residual,
        "model_residual": finding.model_residual,
        "work": json.dumps(answer.work, sort_keys=True),
        **({} if isinstance(problem, LCP) else _of_contacts(problem, finding, answer)),
    }
    remarks = [finding.reason]
    if len(findings) > 1:
        remarks.append(f"{len(findings)} unlike answers to the same problem, of which this is the worst")
    if not timing.solve:
        remarks.append("every call compiled or loaded something: no times")
        return row | {"reason": "; ".join(filter(None, remarks))}
    row |= _times(timing)
    median = row["form_time"] + row["setup_time"] + row["solve_time"]
    row["first_time"] = timing.first
    if timing.first and timing.first > max(FAR * median, NOTICED) and not disturbed:
        remarks.append(f"the first call took {timing.first / median:.0f} times as long as the repeats: does it remember?")
    row["reason"] = "; ".join(filter(None, remarks))
    if median > limit:
        row |= {"verdict": Verdict.TIMEOUT, "reason": "its median time is past the limit"}
    return row


def _of_contacts(problem: FrictionProblem, finding: Finding, answer: Answer) -> Row:
    """What an answer to a friction problem has beside its residuals."""
    free = problem.free_velocity
    energy = float(free @ (problem.mass @ free)) / 2 or 1.0
    return {
        "residual_floor": finding.floor,
        "fclib_error": finding.fclib_error,
        **defects(problem, answer.impulse)._asdict(),
        "backward_error": backward_error(problem, answer.impulse),
        "energy_defect": abs(finding.energy_defect) / energy,
        "mode": _mode(problem, answer),
    }


def _mode(problem: FrictionProblem, answer: Answer) -> str | None:
    """The type of solution, where it is short enough to be read."""
    impulse = answer.impulse
    readable = problem.dimension == 2 and problem.contacts <= MOST_TOLD and impulse.shape == (problem.contacts, 2)
    return mode(problem, impulse) if readable and np.isfinite(impulse).all() else None


def _times(timing: Timing) -> Row:
    row: Row = {}
    for step, times in (("form", timing.form), ("setup", timing.setup), ("solve", timing.solve)):
        row |= {f"{step}_time": float(np.median(times)), f"{step}_times": times} if times else {}
    return row | ({"clock_time": float(np.median(timing.clock))} if timing.clock else {})


@lru_cache(maxsize=8)
def _problem(name: str) -> FrictionProblem | LCP:
    return stored(_worker.folder, name)


def _undisturbed(core: process.Core, spent: float) -> Row:
    """What a row says of its core; spent: seconds that were timed."""
    disturbed = _worker.core is None or not core.core_wait <= spent / 50
    return {**vars(core), "disturbed": disturbed}


def _done(begun: float, row: Row) -> Row:
    return row | {"core": _worker.core, "wall_time": perf_counter() - begun}


def _kind(problem: FrictionProblem | LCP) -> tuple[int, bool]:
    """Its dimension, 0 of an LCP, and whether there are joints."""
    return (0, False) if isinstance(problem, LCP) else (problem.dimension, problem.joints.shape[0] > 0)


def _warm_up(variant: str, dimension: int, jointed: bool, limit: float) -> float:
    """Load and compile what the solver needs, once a worker, on a sliding contact, or on an LCP for dimension 0; the seconds it
    took.

    What goes wrong here goes wrong again in the cell.
    """
    if (variant, dimension, jointed) in _worker.warm:
        return 0.0
    begun = perf_counter()
    _worker.warm.add((variant, dimension, jointed))
    info, solver = find(variant)
    gc.disable()  # what compiles keeps most of what it makes: collections would find nothing, for a tenth of the time
    within = max(limit, LOADING) if info.needs else limit
    with suppress(BaseException), _worker.deadline.within(within), process.no_forked_child():
        solver.solve(solver.prepare(_least(dimension, jointed)), 1e-6, None)
    gc.enable()
    gc.collect()
    gc.freeze()  # what is loaded now stays; collections between cells need not look at it
    return perf_counter() - begun


def _least(dimension: int, jointed: bool) -> FrictionProblem | LCP:
    """A sliding contact; an LCP for dimension 0."""
    if dimension == 0:
        return LCP(np.eye(2), np.array([-1.0, 1.0]))
    free = np.zeros(dimension + 1)
    free[:2] = -1.0, 1.0
    rows = np.eye(dimension + 1)
    return FrictionProblem(
        mass=rows,
        normal=rows[:1],
        tangent=rows[1:dimension],
        friction=np.array([0.5]),
        free_velocity=free,
        bias=np.zeros(1),
        joints=rows[dimension:] if jointed else rows[:0],
        dimension=dimension,
    )
