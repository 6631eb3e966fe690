"""Problems at the edge: redundant and duplicated contacts, none with friction. What has no single answer must not mislead."""

import numpy as np

from frictionbench.harness.contract.change import duplicated, with_friction
from frictionbench.harness.contract.check import Complaints, Subject, check, lie, ordinary, well
from frictionbench.problems import scene
from frictionbench.problems.instances import make_instance


@check("W is singular here and impulses are not unique: regularise, or solve in velocities, and look at the residual.")
def redundant_contacts(subject: Subject) -> Complaints:
    problems = (
        scene("redundant_table", legs=6, speed=1.0).problem(),
        scene("stack", blocks=5).problem(),
        make_instance("cubes", boxes=3, push=0.5),
    )
    for problem in subject.takes(*problems):
        _, finding = subject.solve(problem)
        if lie(finding):
            yield f"{problem.contacts} contacts: {finding.reason}"


@check("The same contact twice shares its impulse in any way; its velocity stays.")
def duplicated_contacts(subject: Subject) -> Complaints:
    for problem in subject.takes(*ordinary()):
        twice = duplicated(problem)
        _, finding = subject.solve(twice)
        if lie(finding):
            yield f"{twice.contacts} contacts: {finding.reason}"


@check("Without friction the tangential impulses vanish and the problem is a convex QP: divide by no mu.")
def frictionless(subject: Subject) -> Complaints:
    for problem in subject.takes(*(with_friction(each, np.zeros(each.contacts)) for each in ordinary())):
        answer, finding = subject.solve(problem)
        if lie(finding) or not np.isfinite(answer.impulse).all():
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: {finding.verdict}, {finding.reason}"
        elif well(finding) and np.abs(answer.impulse[:, 1:]).max(initial=0.0) > 1e-6 * np.abs(answer.impulse).max(initial=1.0):
            yield "tangential impulses without friction"
