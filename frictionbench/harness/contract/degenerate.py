"""Checks on degenerate problems: redundant and duplicated contacts, where impulses are not unique, and no friction."""

import numpy as np

from frictionbench.harness.contract.change import duplicated, with_friction
from frictionbench.harness.contract.check import Subject, Violations, check, is_false_claim, is_solved, ordinary
from frictionbench.problems import scene
from frictionbench.problems.instances import make_instance


@check("W is singular here and impulses are not unique: regularise, or solve for velocities, and verify the residual.")
def redundant_contacts(subject: Subject) -> Violations:
    problems = (
        scene("redundant_table", legs=6, speed=1.0).problem(),
        scene("stack", blocks=5).problem(),
        make_instance("cubes", boxes=3, push=0.5),
    )
    for problem in subject.takes(*problems):
        _, finding = subject.solve(problem)
        if is_false_claim(finding):
            yield f"{problem.contacts} contacts: {finding.reason}"


@check("Two copies of a contact may share its impulse in any way; its velocity stays the same.")
def duplicated_contacts(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        twice = duplicated(problem)
        _, finding = subject.solve(twice)
        if is_false_claim(finding):
            yield f"{twice.contacts} contacts: {finding.reason}"


@check("Without friction tangential impulses vanish and the problem is a convex QP: do not divide by mu.")
def frictionless(subject: Subject) -> Violations:
    for problem in subject.takes(*(with_friction(each, np.zeros(each.contacts)) for each in ordinary())):
        answer, finding = subject.solve(problem)
        if is_false_claim(finding) or not np.isfinite(answer.impulse).all():
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: {finding.verdict}, {finding.reason}"
        elif is_solved(finding) and np.abs(answer.impulse[:, 1:]).max(initial=0.0) > 1e-6 * np.abs(answer.impulse).max(
            initial=1.0
        ):
            yield "tangential impulses without friction"
