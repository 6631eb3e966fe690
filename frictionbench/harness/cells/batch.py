"""Many small problems solved in one of several ways, timed and verified: the columns of a row of batches.

The problems come from one scene and have one size; push, friction and mass ratio of each are drawn with SEED. The way is timed
ROUNDS times, alternating with single calls of BASE on the same problems. The problems of each round differ in the last bits, so
that no earlier answer can be reused. The answers of the first call and of every round are verified.
The time is processor time, children included, which other processes on the core do not change. If the duration without waiting
for the core is more than WAITS times the processor time, the call waited for something else, and the duration is used instead.
Kernels are compiled and loaded before the first timing. A warm start is the answer to the same problem with a push smaller by
NEARBY, which stands for the previous step of a simulation.
"""

import json
import os
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from time import perf_counter, process_time
from typing import Any

import numpy as np

from frictionbench.harness import process
from frictionbench.harness.cells.rows import verified
from frictionbench.harness.cells.timing import drawn_ulps
from frictionbench.harness.plans.plan import BatchCell
from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.frictionless import idle
from frictionbench.problems.answer import checked_copy, is_plain
from frictionbench.problems.catalogue import problem_of
from frictionbench.problems.check import Array
from frictionbench.problems.copies import duplicate, nudged
from frictionbench.problems.packed import Batch
from frictionbench.problems.verdicts import RANK, Verdict
from frictionbench.results.conventions import DRAWN, NEARBY, WARM
from frictionbench.results.store import Row
from frictionbench.solvers import Answer, Answers, SolverInfo, solve, solve_many

BASE = {2: "lemke", 3: "hybrid"}  # by dimension
TOL, ROUNDS, SAMPLE, SEED = 1e-8, 5, 20, 1
WAITS = 1.2  # duration over processor time: smaller ratios may be due to the host of a virtual machine


@dataclass(frozen=True)
class Problems:
    """A batch, the flat impulses for its warm start, and the columns that describe it."""

    problems: tuple[FrictionProblem, ...]
    start: Array
    facts: Row


@lru_cache(maxsize=1)  # the cells of a batch run one after another
def batch_of(name: str, parameters: str, count: int) -> Problems:
    """Make `count` problems of a scene or an instance. parameters: a JSON object. Errors: InputError of the scene."""
    chosen = json.loads(parameters)
    rng = np.random.default_rng(SEED)
    drawn = [{key: rng.uniform(*bounds) for key, bounds in DRAWN.items()} | chosen for _ in range(count)]
    problems = [problem_of(name, **settings) for settings in drawn]
    spec = BASE[problems[0].dimension]
    nearby = solve_many([problem_of(name, **each | {"push": (1 - NEARBY) * each["push"]}) for each in drawn], spec, tol=TOL)
    answers = solve_many(problems, spec, tol=TOL)
    loaded = np.concatenate([answers[k][:, 0] > 0 for k in range(count)])
    idle_flags = [idle(problem, lambda frictionless: solve(frictionless, spec).impulse) for problem in problems[:SAMPLE]]
    facts = {
        "dimension": problems[0].dimension,
        "contacts": problems[0].contacts,
        "active": float(loaded.mean()) if len(loaded) else 0.0,
        "idle": float(np.mean(idle_flags)),
        "base": spec,
    }
    return Problems(tuple(problems), nearby.impulse, facts)


def time_batch(cell: BatchCell, batch: Problems, info: SolverInfo) -> Row:
    """Return the measured columns."""
    run = _way(cell, batch.problems, batch.start)
    row = _verified(cell, batch.problems, _one_by_one(run()), info)  # also compiles and loads
    _calls(batch.problems, batch.facts["base"], cell.tol)
    times, singles = [], []
    for _ in range(ROUNDS):
        problems = tuple(nudged(problem, drawn_ulps()) for problem in batch.problems)
        seconds, last = _worked(_way(cell, problems, batch.start))
        times.append(seconds / cell.count)
        singles.append(_worked(partial(_calls, problems, batch.facts["base"], cell.tol))[0] / cell.count)
        again = _verified(cell, problems, _one_by_one(last), info)
        worst = max(row, again, key=lambda each: (RANK[each["verdict"]], -each["verified"]))
        row |= worst | {"work": row["work"], "verified": min(row["verified"], again["verified"])}
    return row | {"times": times, "base_times": singles}


def _way(cell: BatchCell, problems: tuple[FrictionProblem, ...], start_impulses: Array) -> Callable[[], Any]:
    """Return the call that solves copies of these problems, to be timed; work done once, such as packing, is done here."""
    problems = tuple(map(duplicate, problems))
    start = start_impulses if cell.start == WARM else None
    many = partial(solve_many, solver=cell.variant, tol=cell.tol, start=start)
    if cell.way == "packed":
        return partial(many, Batch(problems))
    if cell.way == "list":
        return lambda: many([problem.fresh() for problem in problems])
    return partial(_calls, problems, cell.variant, cell.tol)


def _calls(problems: tuple[FrictionProblem, ...], spec: str, tol: float) -> list[Answer]:
    return [solve(problem.fresh(), spec, tol=tol) for problem in problems]


def _one_by_one(answers: Answers | list[Answer]) -> list[Answer]:
    """Return a list with the answer to each problem."""
    if isinstance(answers, list):
        return answers
    counts = [(name, count.tolist()) for name, count in answers.work.items()]
    return [Answer(answers[k], answers.status[k], {name: count[k] for name, count in counts}) for k in range(len(answers))]


def _verified(cell: BatchCell, problems: tuple[FrictionProblem, ...], answers: list[Answer], info: SolverInfo) -> Row:
    """Return the worst verdict, the count of each other verdict than solved, and the summed counts of work."""
    findings = [verified(problem, answer, info, cell.tol) for problem, answer in zip(problems, answers, strict=True)]
    verdicts = Counter(finding.verdict for finding in findings)
    work: Counter[str] = Counter()
    for answer in answers:
        work.update(answer.work)
    failed = {verdict: count for verdict, count in verdicts.items() if verdict != Verdict.SOLVED}
    return {
        "verdict": max(verdicts, key=RANK.__getitem__),
        "reason": ", ".join(f"{count} of {len(answers)} {verdict}" for verdict, count in sorted(failed.items())),
        "verified": verdicts[Verdict.SOLVED] / len(answers),
        "residual": max(finding.residual for finding in findings),
        "work": json.dumps(work, sort_keys=True),
    }


def _worked(run: Callable[[], Any]) -> tuple[float, Any]:
    """Return the seconds of a call, as described above, and its result. Work deferred until answers are read counts too."""
    before = perf_counter() - process.waited(), _processor_time()
    result = run()
    duration, processor = perf_counter() - process.waited() - before[0], _processor_time() - before[1]
    seconds = duration if duration > WAITS * processor else processor
    if not isinstance(result, list) or all(map(is_plain, result)):
        return seconds, result
    converting, result = _worked(lambda: [checked_copy(answer) for answer in result])
    return seconds + converting, result


def _processor_time() -> float:
    """Return the processor time of this process and its children, s."""
    times = os.times()
    return process_time() + times.children_user + times.children_system
