"""The convergence histories of a run (results.histories): residual against work on a few problems, after all cells are done.

The problems are the largest with up to MOST_CONTACTS contacts, one per scene. Trivial and idle ones are left out. The solvers
are single methods that solved the problem at the tightest tolerance.

A history holds the residual of the answer for work limits of 1, 2, 3, 4, 6, ... units, which are the solver's own: sweeps,
iterations or pivots. Every answer comes from a new call on a copy of the problem, and its residual is computed on the original,
so that the curve shows what a user gets with these limits. No call is timed.
"""

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from frictionbench.harness.cells import worker
from frictionbench.harness.cells.simulation import usable
from frictionbench.harness.cells.stored import Record
from frictionbench.harness.plans.plan import Plan, owner
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.pool import Pool, Task
from frictionbench.problems import FrictionProblem
from frictionbench.problems.answer import checked_copy
from frictionbench.problems.copies import duplicate
from frictionbench.problems.residual import residual
from frictionbench.problems.verdicts import ACCEPTED
from frictionbench.results.files import parsed
from frictionbench.results.histories import CONVERGENCE, ConvergenceHistory, write_histories
from frictionbench.results.store import Row
from frictionbench.solvers import Solver, Status

HISTORY_BUDGET = 2.0  # seconds after which no larger limit is tried: a history shows early convergence
MOST_PROBLEMS = 6  # each is a panel of the report's figure, which is legible with few panels
MOST_CONTACTS = 64  # contacts: a history takes some twenty-five solves, too long for larger problems
HISTORY_LIMIT = 10.0  # seconds for one history: five times HISTORY_BUDGET
LARGEST_LIMIT = 20_000  # units of work: a bound for methods that stall; methods that converge well need fewer


def history(problem: FrictionProblem, solver: Solver, tol: float) -> tuple[list[int], list[float]]:
    """Return the limits and the verified residuals, up to the first status SOLVED.

    Errors: AnswerError, and whatever the solver raises.
    """
    start_time, units, residuals, limit = perf_counter(), [], [], 1
    while True:
        answer = checked_copy(solver.solve(solver.prepare(duplicate(problem)), tol, limit))
        impulse = usable(problem, answer.impulse)
        if impulse is not None and np.isfinite(reached := residual(problem, impulse)):
            units.append(limit)
            residuals.append(reached)
        if answer.status is Status.SOLVED or limit >= LARGEST_LIMIT or perf_counter() - start_time > HISTORY_BUDGET:
            return units, residuals
        limit = max(limit + 1, round(1.5 * limit))  # 1, 2, 3, 4, 6, 9, ...


def run_history(name: str, variant: str, tol: float) -> dict[str, Any]:
    """In a worker, compute a solver's history on a stored problem: units of work and verified residuals."""
    units, residuals = history(*worker.prepared(name, variant, HISTORY_LIMIT), tol)
    return {"units": units, "residuals": residuals}


def record_histories(
    plan: Plan, folder: Path, records: Iterable[Record], solves: Iterable[Row], pool: Pool, progress: Progress
) -> None:
    """Write the histories, unless the folder has them. Those that fail are left out. Runs of maps have none."""
    if plan.maps or (folder / CONVERGENCE).exists():
        return
    tol, problems = min(plan.tolerances), {record["problem"]: record for record in chosen(records)}
    solved = {
        (row.get("problem"), row.get("variant"))
        for row in solves
        if row.get("tol") == tol and row.get("verdict") in ACCEPTED and not row.get("members")
    }
    tasks = [
        Task(run_history, (name, variant, tol), HISTORY_LIMIT, owner(variant, plan.plugins))
        for variant in sorted(plan.variants, key=lambda variant: owner(variant, plan.plugins))
        for name in problems
        if (name, variant) in solved
    ]
    histories = []
    for outcome in progress.follow("convergence histories", pool, tasks):
        name, variant, _ = outcome.task.arguments
        if not outcome.failure:
            with suppress(ValueError, TypeError, LookupError):  # the reply may be anything from a plug-in
                facts = {fact: problems[name][fact] for fact in ("scene", "parameters", "step", "contacts")}
                curve = {part: outcome.value[part] for part in ("units", "residuals")}
                histories.append(parsed(facts | curve | {"variant": variant}, ConvergenceHistory, CONVERGENCE))
    write_histories(
        folder, sorted(histories, key=lambda history: (history.scene, history.parameters, str(history.step), history.variant))
    )


def chosen(records: Iterable[Record]) -> list[Record]:
    """The records of the problems whose histories are recorded."""
    real = [
        record
        for record in records
        if record["problem"] and not record["trivial"] and not record["idle"] and 0 < (record["contacts"] or 0) <= MOST_CONTACTS
    ]
    by_scene: dict[str, Record] = {}
    for record in sorted(real, key=lambda record: -record["contacts"]):
        by_scene.setdefault(record["scene"], record)
    return list(by_scene.values())[:MOST_PROBLEMS]
