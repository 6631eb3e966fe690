"""Checks that every field of a problem is used, friction_bias, joints and biases of either sign, and every island solved."""

from collections.abc import Iterator

import numpy as np

from frictionbench.harness.contract.change import duplicated, in_units
from frictionbench.harness.contract.check import TOL, Subject, Violations, check, contact, is_false_claim, ordinary
from frictionbench.problems import FrictionProblem
from frictionbench.problems.combine import side_by_side

FAST = 1e6  # the ratio of two islands' speeds: a test relative to the fastest contact allows the other any answer


@check("Bound friction by mu r_n + friction_bias, or declare lacks=('friction_bias',), so that such problems are refused.")
def friction_bias(subject: Subject) -> Violations:
    for d in (2, 3):
        for name, falling in (("pressed", 1.0), ("opening", -1.0)):
            sliding = contact(d, speed=2.0, falling=falling).replace(friction_bias=np.ones(1))
            yield from _claimed(subject, sliding, f"with a friction_bias of 1 N s, {name}")
    for problem in ordinary():
        more = np.linspace(0.5, 1, problem.contacts) * _impulse(problem)
        yield from _claimed(subject, problem.replace(friction_bias=more), "with friction_bias")


@check("Satisfy F v + joint_bias = 0 exactly (problem.W contains the joints), or declare lacks=('joints',).")
def joints(subject: Subject) -> Violations:
    for d in (2, 3):
        held = contact(d).replace(joints=np.array([[0.6, 1.0, 0.0]])[:, :d], joint_bias=np.array([0.5]))
        yield from _claimed(subject, held, "with a joint that moves at 0.5 m/s")
    for problem in ordinary():
        random, nv = np.random.default_rng(0), len(problem.free_velocity)
        rows = random.standard_normal((2, nv)) * np.sqrt(problem.mass.diagonal())
        moved = problem.replace(joints=rows, joint_bias=rows @ random.standard_normal(nv) * problem.velocity_scale)
        yield from _claimed(subject, moved, "with two joint equations")


@check("Add bias to the normal velocity, u_n = n'v + bias: a gap over the step if positive, a penetration if negative.")
def bias(subject: Subject) -> Violations:
    for d in (2, 3):
        for size in (0.5, 2.0, -0.5, -2.0):
            given = contact(d).replace(bias=np.array([size]))
            yield from _claimed(subject, given, f"with a bias of {size:g} m/s")
    for problem in ordinary():
        signs = np.where(np.arange(problem.contacts) % 2, 0.3, -0.3) * problem.velocity_scale
        yield from _claimed(subject, problem.replace(bias=signs), "with biases of both signs")


@check("Measure each island in its own unit: stop at tol * problem.units.min(), or solve problem.balanced().")
def islands(subject: Subject) -> Violations:
    for problem in ordinary():
        fast = in_units(contact(problem.dimension), 1.0, FAST * problem.velocity_scale)
        yield from _claimed(subject, side_by_side(problem, fast), f"beside an island that is {FAST:g} times as fast")
        gap = np.repeat([0.0, FAST * problem.velocity_scale], problem.contacts)
        again = duplicated(problem)
        order = np.argsort(np.arange(again.contacts) % 2, kind="stable")
        opened = again.replace(bias=again.bias + gap[np.argsort(order)])
        yield from _claimed(subject, opened, f"of which half are open by {FAST:g} times the largest velocity")


def _claimed(subject: Subject, problem: FrictionProblem, name: str) -> Iterator[str]:
    """A violation where the solver claims an answer that is far from one."""
    for given in subject.takes(problem):
        _, finding = subject.solve(given, TOL)
        if is_false_claim(finding):
            yield f"{given.contacts} contacts of dimension {given.dimension} {name}: {finding.reason}"


def _impulse(problem: FrictionProblem) -> float:
    """The size of the problem's impulses, N s."""
    return float(problem.velocity_scale / problem.scale.mean())
