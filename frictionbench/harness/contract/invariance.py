"""Checks of invariance: the order of contacts, tangent frames, a mirror image and units do not change the velocities."""

from collections.abc import Callable

import numpy as np

from frictionbench.harness.contract.change import in_units, mirrored, permuted, rotated
from frictionbench.harness.contract.check import Subject, Violations, check, is_solved, ordinary
from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array

TOL = 1e-8  # so that differences above NEAR are not the tolerance's
NEAR = 1e-4  # of the largest free contact velocity; each of these problems has a unique velocity


@check("The order of contacts is arbitrary: results may depend on it only by rounding.")
def contact_order(subject: Subject) -> Violations:
    yield from _same(subject, lambda problem: permuted(problem, np.arange(problem.contacts)[::-1]))


@check("The sign of a tangent is arbitrary: the same law holds along -t.")
def tangent_sign(subject: Subject) -> Violations:
    yield from _same(subject, mirrored)


@check("Any two orthogonal tangents may be given: use norms of tangential parts, not components.")
def tangent_frame(subject: Subject) -> Violations:
    yield from _same(subject, lambda problem: rotated(problem, np.linspace(0.3, 3.0, problem.contacts)), spatial=True)


@check("Units are arbitrary: scale the problem before comparing with an absolute tolerance.")
def unit_scaling(subject: Subject) -> Violations:
    for mass, velocity in ((1e6, 1.0), (1.0, 1e4), (1e-6, 1e-3)):
        yield from _same(subject, lambda problem, m=mass, v=velocity: in_units(problem, m, v), velocity)  # type: ignore[misc]


def _same(
    subject: Subject, change: Callable[[FrictionProblem], FrictionProblem], times: float = 1.0, spatial: bool = False
) -> Violations:
    """Velocities of the changed problem that are not `times` those of the problem, where that was solved."""
    for problem in subject.takes(*ordinary()):
        if spatial and (problem.dimension == 2 or subject.info.model == "lcp"):  # a polygon rotates with the tangents
            continue
        answer, finding = subject.solve(problem, TOL)
        if not is_solved(finding):
            continue
        other = change(problem)
        again, found = subject.solve(other, TOL)
        if not is_solved(found):
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: solved before, {found.verdict} after"
            continue
        gap = _gap(problem.velocity(answer.impulse), other.velocity(again.impulse) / times) / (problem.velocity_scale or 1.0)
        if gap > NEAR:
            yield f"{problem.contacts} contacts of dimension {problem.dimension}: velocities differ by {gap:.1e}"


def _gap(one: Array, other: Array) -> float:
    return float(np.abs(one - other).max(initial=0.0))
