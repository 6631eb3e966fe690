"""Checks of the status: it is correct, results are reproducible, work limits hold, and starts do no harm."""

import numpy as np

from frictionbench.harness.contract.check import Subject, Violations, check, is_false_claim, is_solved, ordinary
from frictionbench.problems import scene
from frictionbench.problems.instances import make_instance
from frictionbench.solvers import Status


@check("Compute the residual of the answer (problems.residual) before returning SOLVED.")
def correct_status(subject: Subject) -> Violations:
    planar = (make_instance("random", seed=seed, contacts=8) for seed in range(6))
    spatial = (make_instance("random_bodies", seed=seed, contacts=8) for seed in range(6))
    rough = (scene("stack", blocks=4, push=1.0, mass_ratio=1e4).problem(), scene("painleve_rod").problem())
    for problem in subject.takes(*planar, *spatial, *rough):
        for tol in (1e-4, 1e-8):
            _, finding = subject.solve(problem, tol)
            if is_false_claim(finding):
                yield f"{problem.contacts} contacts of dimension {problem.dimension}: {finding.reason}"


@check("Seed random numbers, and keep no state between solves: a benchmark solves the same problem many times.")
def deterministic(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        (first, _), (second, _) = (subject.solve(problem) for _ in range(2))
        if not np.array_equal(first.impulse, second.impulse, equal_nan=True):
            yield f"{problem.contacts} contacts: impulses differ by {np.abs(first.impulse - second.impulse).max():.1e}"
        if first.work != second.work:
            yield f"{problem.contacts} contacts: work {first.work}, then {second.work}"


@check("Stop after `limit` units of work, and return WORK_LIMIT if that was too few.")
def work_limit(subject: Subject) -> Violations:
    for problem in subject.takes(scene("stack", blocks=10, push=1.0).problem(), make_instance("cubes", boxes=5, push=1.0)):
        answer, finding = subject.solve(problem, 1e-10, limit=1)
        if is_false_claim(finding):
            yield f"with a limit of 1: {finding.reason}"
        if answer.status is not Status.SOLVED and (most := max(answer.work.values(), default=0)) > 100:
            yield f"with a limit of 1 it counts {most} units of work"


@check("Use a start only as an initial guess: check it, and solve without it if it does not help.")
def warm_start(subject: Subject) -> Violations:
    if not subject.info.warm_start:
        return
    for problem in subject.takes(*ordinary()):
        cold, finding = subject.solve(problem)
        if not is_solved(finding):
            continue
        for name, start in (("its own answer", cold.impulse), ("zero", 0 * cold.impulse), ("nonsense", 1e3 + 0 * cold.impulse)):
            _, found = subject.solve(problem, start=np.ascontiguousarray(start))
            if not is_solved(found):
                yield f"{problem.contacts} contacts, from {name}: {found.verdict}, residual {found.model_residual:.1e}"
