"""The courses of a run (results.courses): how solvers get to their answers on a few of its problems, after all cells are done.

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
from frictionbench.results.courses import NAME, Course, write_courses
from frictionbench.results.schema import RELAXED, SOLVED

LARGE, REDUNDANT = 4, 2  # problems chosen of each kind
MOST = 64  # contacts
MOST_FORCES = 12  # contacts of a problem whose impulses are kept
LIMIT = 10.0  # seconds for one course


def follow(plan: Plan, folder: Path, entries: Iterable[Entry], pool: Pool, progress: Progress) -> None:
    """Write the courses, unless they are there; one that is lost is no loss. Maps have none."""
    if plan.maps or (folder / NAME).exists():
        return
    tol, problems = min(plan.tolerances), {entry["problem"]: entry for entry in chosen(entries)}
    able = {
        (row.get("problem"), row.get("variant"))
        for row in store.rows(folder, "solves")
        if row.get("tol") == tol and row.get("verdict") in (SOLVED, RELAXED) and not row.get("members")
    }
    tasks = [
        Task(f"course of {variant}", worker.run_course, (name, variant, tol, LIMIT), LIMIT, plan.owner(variant))
        for variant in sorted(plan.solvers, key=plan.owner)
        for name in problems
        if (name, variant) in able
    ]
    found = []
    with progress.stage("courses", len(tasks), 0) as stage:
        for outcome in pool.run(tasks, stage.started, stage.compiling):
            name, variant, *_ = outcome.task.arguments
            if not outcome.death:
                found.append(_course(problems[name], variant, outcome.value))
            stage.finished(outcome.task)
    write_courses(folder, sorted(found, key=lambda course: (course.scene, course.parameters, str(course.step), course.variant)))


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


def _course(entry: Entry, variant: str, told: dict[str, Any]) -> Course:
    redundant = bool(entry["redundancy"])
    impulse = told["impulse"] if redundant and entry["contacts"] <= MOST_FORCES else []
    facts = (entry["scene"], entry["parameters"], entry["step"], variant, entry["contacts"], redundant)
    return Course(*facts, told["units"], told["residuals"], impulse)
