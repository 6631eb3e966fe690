"""The convergence histories of a run (results.convergence): residual against work on a few problems, after all cells are done.

Chosen are the largest problems of up to MOST contacts of different scenes, and the small ones with the most redundant
contacts, none of them trivial; followed are single methods, not portfolios, that solved the problem at the tightest tolerance.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from frictionbench.harness.cells import worker
from frictionbench.harness.cells.collect import Entry
from frictionbench.harness.plans.plan import Plan
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.pool import Pool
from frictionbench.harness.workers.task import Task
from frictionbench.results import store
from frictionbench.results.convergence import NAME, ConvergenceHistory, write_histories
from frictionbench.results.verdicts import Verdict

LARGE, REDUNDANT = 4, 2  # problems chosen of each kind
MOST = 64  # contacts
MOST_FORCES = 12  # contacts of a problem whose impulses are kept
LIMIT = 10.0  # seconds for one history


def record_histories(plan: Plan, folder: Path, entries: Iterable[Entry], pool: Pool, progress: Progress) -> None:
    """Write the histories, unless they are there; one that is lost is no loss. Maps have none."""
    if plan.maps or (folder / NAME).exists():
        return
    tol, problems = min(plan.tolerances), {entry["problem"]: entry for entry in chosen(entries)}
    able = {
        (row.get("problem"), row.get("variant"))
        for row in store.rows(folder, "solves")
        if row.get("tol") == tol and row.get("verdict") in (Verdict.SOLVED, Verdict.RELAXED) and not row.get("members")
    }
    tasks = [
        Task(f"convergence history of {variant}", worker.run_history, (name, variant, tol, LIMIT), LIMIT, plan.owner(variant))
        for variant in sorted(plan.solvers, key=plan.owner)
        for name in problems
        if (name, variant) in able
    ]
    found = []
    with progress.stage("convergence histories", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            name, variant, *_ = outcome.task.arguments
            if not outcome.failure:
                found.append(_history(problems[name], variant, outcome.value))
            stage.finished(outcome.task)
    write_histories(
        folder, sorted(found, key=lambda history: (history.scene, history.parameters, str(history.step), history.variant))
    )


def chosen(entries: Iterable[Entry]) -> list[Entry]:
    """The problems that are followed."""
    real = [entry for entry in entries if entry["problem"] and not entry["trivial"] and (entry["contacts"] or MOST + 1) <= MOST]
    large = sorted(real, key=lambda entry: -entry["contacts"])
    redundant = [entry for entry in large if entry["redundancy"] and entry["contacts"] <= MOST_FORCES]
    redundant.sort(key=lambda entry: -entry["redundancy"] / entry["contacts"])
    return [*_one_a_scene(large)[:LARGE], *_one_a_scene(redundant)[:REDUNDANT]]


def _one_a_scene(entries: list[Entry]) -> list[Entry]:
    found: dict[str, Entry] = {}
    for entry in entries:
        found.setdefault(entry["scene"], entry)
    return list(found.values())


def _history(entry: Entry, variant: str, told: dict[str, Any]) -> ConvergenceHistory:
    redundant = bool(entry["redundancy"])
    impulse = told["impulse"] if redundant and entry["contacts"] <= MOST_FORCES else []
    facts = (entry["scene"], entry["parameters"], entry["step"], variant, entry["contacts"], redundant)
    return ConvergenceHistory(*facts, told["units"], told["residuals"], impulse)
