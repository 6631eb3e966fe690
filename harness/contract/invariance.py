"""The same mechanics in other words has the same velocities: order of contacts, frames, mirror, units."""

from collections.abc import Callable

import numpy as np

from frictionbench.harness.contract.change import in_units, mirrored, permuted, rotated
from frictionbench.harness.contract.check import Complaints, Subject, check, ordinary, well
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array

TOL = 1e-8
NEAR = 1e-4  # of the largest free contact velocity; these problems have one velocity each


@check("An order of contacts is an accident: results may depend on it by rounding alone.")
def order_of_contacts(subject: Subject) -> Complaints:
    yield from _same(subject, lambda problem: permuted(problem, np.arange(problem.contacts)[::-1]))


@check("Left and right are an accident: the same law holds along -t.")
def mirror(subject: Subject) -> Complaints:
    yield from _same(subject, mirrored)


@check("Tangents are any two that are orthogonal: use norms of tangential parts, not their components.")
def tangent_frames(subject: Subject) -> Complaints:
    yield from _same(subject, lambda problem: rotated(problem, np.linspace(0.3, 3.0, problem.contacts)), spatial=True)


@check("Kilograms and metres are an accident: scale the problem before an absolute tolerance meets it.")
def units(subject: Subject) -> Complaints:
    for mass, velocity in ((1e6, 1.0), (1.0, 1e4), (1e-6, 1e-3)):
        yield from _same(subject, lambda problem, m=mass, v=velocity: in_units(problem, m, v), velocity)  # type: ignore[misc]


def _same(
    subject: Subject, change: Callable[[FrictionProblem], FrictionProblem], times: float = 1.0, spatial: bool = False
) -> Complaints:
    """Velocities of the changed problem that are not `times` those of the problem, where that was solved."""
    for problem in subject.takes(*ordinary()):
        if spatial and (problem.dimension == 2 or subject.info.model == "lcp"):  # a polygon turns with its tangents
            continue
        answer, finding = subject.solve(problem, TOL)
        if not well(finding):
            continue
        other = change(problem)
        again, found = subject.solve(other, TOL)
        if not well(found):
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: solved before, {found.verdict} after"
            continue
        gap = _gap(problem.velocity(answer.impulse), other.velocity(again.impulse) / times) / (problem.velocity_scale or 1.0)
        if gap > NEAR:
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: velocities differ by {gap:.1e}"


def _gap(one: Array, other: Array) -> float:
    return float(np.abs(one - other).max(initial=0.0))
