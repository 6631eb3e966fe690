"""Checks of the answer's format: the input is not changed, the answer has the documented shape, also for 0 or 1 contact."""

import numpy as np

from frictionbench.harness.contract.change import permuted
from frictionbench.harness.contract.check import TOL, Subject, Violations, check, contact, is_solved, ordinary
from frictionbench.problems.copies import duplicate, same
from frictionbench.solvers import Status


@check("Copy arrays before changing them: those of the problem belong to the caller.")
def input_unchanged(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        given = duplicate(problem)
        subject.solver.solve(subject.solver.prepare(given), TOL, None)
        if not same(problem, given):
            yield f"the problem of {problem.contacts} contacts was changed by the call"


@check("Return Answer(impulse, status, work): impulses (contacts, dimension) of floats, normal first; counts of whole numbers.")
def answer_format(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        answer, _ = subject.solve(problem)
        expected = (problem.contacts, problem.dimension)
        if not isinstance(answer.status, Status):
            yield f"the status is {answer.status!r}, not a Status"
        if np.shape(answer.impulse) != expected:
            yield f"the impulse has shape {np.shape(answer.impulse)}, not {expected}"
        elif answer.status is Status.SOLVED and not np.isfinite(answer.impulse).all():
            yield "status SOLVED with an impulse that is not finite"
        if bad := {name: count for name, count in answer.work.items() if not isinstance(count, int) or count < 0}:
            yield f"counts of work are not whole numbers of at least 0: {bad}"


@check("Return impulses of shape (0, dimension) where there is no contact.")
def no_contacts(subject: Subject) -> Violations:
    for d in (2, 3):
        for problem in subject.takes(permuted(contact(d), np.zeros(0, dtype=int))):
            answer, _ = subject.solve(problem)
            if answer.impulse.shape != (0, d) or answer.status is not Status.SOLVED:
                yield f"of dimension {d}: {answer.status.name}, impulse of shape {answer.impulse.shape}"


@check("A single contact slides, sticks or opens; compare with the solution in closed form.")
def single_contact(subject: Subject) -> Violations:
    cases = {"slides": (1.0, 1.0), "sticks": (0.1, 1.0), "opens": (1.0, -1.0)}
    for d in (2, 3):
        for name, (speed, falling) in cases.items():
            for problem in subject.takes(contact(d, speed=speed, falling=falling)):
                _, finding = subject.solve(problem)
                if not is_solved(finding):
                    yield f"a contact of dimension {d} that {name}: {finding.verdict}, residual {finding.model_residual:.1e}"
