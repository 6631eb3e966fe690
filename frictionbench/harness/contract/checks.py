"""The checks of the contract by subject: first calls, the answer's format, the fields of the problem, degenerate problems, the
status, and transformations of the problem under which velocities are invariant.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from frictionbench.harness.contract.check import (
    TOL,
    Subject,
    Violations,
    check,
    contact,
    duplicated,
    in_units,
    mirrored,
    ordinary,
    permuted,
    rotated,
)
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import make_instance, problem_of, scene
from frictionbench.problems.copies import duplicate, same
from frictionbench.problems.spec import parse
from frictionbench.problems.subproblems import side_by_side
from frictionbench.problems.verdicts import ACCEPTED, Verdict
from frictionbench.solvers import SolverInfo, Status

FAST = 1e6  # ratio of two islands' speeds: a test relative to the fastest contact accepts any answer in the slow island
TIGHT = 1e-8  # tolerance of the solves compared, so that differences above SAME_VELOCITY are not due to it
SAME_VELOCITY = 1e-4  # relative to the largest free contact velocity; each of these problems has a unique velocity


def inapplicable(name: str, info: SolverInfo) -> str:
    """Return why a check does not apply to a solver, or an empty text."""
    reasons = {
        f"the solver declares that it lacks {name}": name in info.lacks,
        "the solver does not declare warm_start=True": name == "warm_start" and not info.warm_start,
        "in the plane there is one tangent": name == "tangent_frame" and 3 not in info.dimension,
        "the solver's polygonal cone rotates with the tangents": name == "tangent_frame" and info.model == "lcp",
    }
    return next((reason for reason, holds in reasons.items() if holds), "")


@check("Answer the first call of a process, and the first on a problem, like later ones: fill tables before they are read.")
def first_calls(subject: Subject) -> Violations:
    yield from subject.broken
    for problem in subject.takes(*ordinary()):  # new to this process, as no other check ran in it before
        if (fault := subject.fault(problem)) and not subject.fault(problem):
            yield f"{problem.summary} when first met: {fault}"


@check(
    "A solver returns Answer(impulse, status, work), an executable writes an answer file: impulses of the step, N s, "
    "(contacts, dimension), normal first; whole numbers of work; a status, solved only where the residual is within the "
    "tolerance."
)
def ordinary_problems(subject: Subject) -> Violations:
    faults: dict[str, list[str]] = {}
    for problem in subject.takes(*ordinary()):
        subject.fault(problem)  # a fault of the first call alone is reported by first_calls
        faults.setdefault(subject.fault(problem), []).append(problem.summary)
    yield from (f"{fault}, on {'; '.join(met)}" for fault, met in faults.items() if fault)


@check("Copy arrays before changing them: those of the problem belong to the caller.")
def input_unchanged(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        given = duplicate(problem)
        subject.solver.solve(subject.solver.prepare(given), TOL, None)
        handed: list[Any] = [[*one.dense(), *one.csr()] for one in (problem, given)]  # C code can write to read-only arrays
        if not same(problem, given) or not all(np.array_equal(*pair) for pair in zip(*handed, strict=True)):
            yield f"the problem of {problem.summary} was changed by the call"


@check("Return SOLVED and impulses of shape (0, dimension) where there is no contact.")
def no_contacts(subject: Subject) -> Violations:
    for d in (2, 3):
        for problem in subject.takes(permuted(contact(d), np.zeros(0, dtype=int))):
            answer, _ = subject.solve(problem)
            if answer.impulse.shape != (0, d) or answer.status is not Status.SOLVED:
                message = answer.detail or answer.status.value
                yield f"of dimension {d}: {answer.status.name}, impulse of shape {answer.impulse.shape}; {message}"


@check("A single contact slides, sticks or opens; compare with the solution in closed form.")
def single_contact(subject: Subject) -> Violations:
    cases = {"slides": (1.0, 1.0), "sticks": (0.1, 1.0), "opens": (1.0, -1.0)}
    for d in (2, 3):
        for name, (speed, falling) in cases.items():
            for problem in subject.takes(contact(d, speed=speed, falling=falling)):
                _, finding = subject.solve(problem)
                if finding.verdict not in ACCEPTED:
                    what = f"{finding.verdict}, residual {finding.model_residual:.1e}; {finding.reason}"
                    yield f"a contact of dimension {d} that {name}: {what}"


@check("Bound friction by mu r_n + friction_bias, or declare lacks=('friction_bias',), so that such problems are refused.")
def friction_bias(subject: Subject) -> Violations:
    for d in (2, 3):
        for name, falling in (("pressed", 1.0), ("opening", -1.0)):
            sliding = contact(d, speed=2.0, falling=falling).replace(friction_bias=np.ones(1))
            yield from _claimed(subject, sliding, f"with a friction_bias of 1 N s, {name}")
    for problem in ordinary():
        more = np.linspace(0.5, 1, problem.contacts) * problem.velocity_scale / problem.scale.mean()  # of the impulses' size
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
        again = duplicated(problem)
        opened = again.replace(bias=again.bias + np.tile([0.0, FAST * problem.velocity_scale], problem.contacts))
        yield from _claimed(subject, opened, f"of which half are open by {FAST:g} times the largest velocity")


def _claimed(subject: Subject, problem: FrictionProblem, name: str, tol: float = TOL) -> Iterator[str]:
    """Yield a violation if the solver falsely claims to have solved the problem."""
    for given in subject.takes(problem):
        _, finding = subject.solve(given, tol)
        if finding.verdict == Verdict.WRONG:
            yield f"{given.summary} {name}: {finding.reason}"


@check("W is singular here and impulses are not unique: regularise, or solve for velocities, and verify the residual.")
def redundant_contacts(subject: Subject) -> Violations:
    problems = (
        scene("redundant_table", legs=6, speed=1.0).problem(),
        scene("stack", blocks=5).problem(),
        make_instance("cubes", boxes=3, push=0.5),
    )
    for problem in problems:
        yield from _claimed(subject, problem, "of which some are redundant")


@check("Two copies of a contact may share its impulse in any way; its velocity stays the same.")
def duplicated_contacts(subject: Subject) -> Violations:
    for problem in ordinary():
        yield from _claimed(subject, duplicated(problem), "of which each is there twice")


@check("Without friction tangential impulses vanish and the problem is a convex QP: do not divide by mu.")
def frictionless(subject: Subject) -> Violations:
    for problem in subject.takes(*(each.replace(friction=np.zeros(each.contacts)) for each in ordinary())):
        answer, finding = subject.solve(problem)
        most = 1e-6 * np.abs(answer.impulse).max(initial=1.0)
        if finding.verdict == Verdict.WRONG or not np.isfinite(answer.impulse).all():
            yield f"{problem.summary}: {finding.verdict}, {finding.reason}"
        elif finding.verdict in ACCEPTED and np.abs(answer.impulse[:, 1:]).max(initial=0.0) > most:
            yield "tangential impulses without friction"


@check("Compute the residual of the answer (problems.residual) before returning SOLVED.")
def correct_status(subject: Subject) -> Violations:
    random = (f"{name}[seed={seed},contacts=8]" for name in ("random", "random_bodies") for seed in range(6))
    for spec in (*random, "stack[blocks=4,push=1,mass_ratio=1e4]", "painleve_rod"):
        name, settings = parse("problem", spec)
        for tol in (1e-4, 1e-8):
            yield from _claimed(subject, problem_of(name, **settings), f"({spec}) to {tol:g}", tol)


@check("Seed random numbers, and keep no state between solves: a benchmark solves the same problem many times.")
def deterministic(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        (first, _), (second, _) = (subject.solve(problem) for _ in range(2))
        if not np.array_equal(first.impulse, second.impulse, equal_nan=True):
            yield f"{problem.summary}: impulses differ by {np.abs(first.impulse - second.impulse).max():.1e}"
        if first.work != second.work:
            yield f"{problem.summary}: work {first.work}, then {second.work}"


@check("Stop after `limit` units of work, and return WORK_LIMIT if that was too few.")
def work_limit(subject: Subject) -> Violations:
    for problem in subject.takes(scene("stack", blocks=10, push=1.0).problem(), make_instance("cubes", boxes=5, push=1.0)):
        answer, finding = subject.solve(problem, 1e-10, limit=1)
        if finding.verdict == Verdict.WRONG:
            yield f"{problem.summary}, with a limit of 1: {finding.reason}"
        if (most := max(answer.work.values(), default=0)) > 100:
            yield f"{problem.summary}: with a limit of 1 it counts {most} units of work"


@check("Use a start only as an initial guess: check it, solve without it if it does not help, and do not write into it.")
def warm_start(subject: Subject) -> Violations:
    for problem in subject.takes(*ordinary()):
        cold, finding = subject.solve(problem)
        if finding.verdict not in ACCEPTED:
            continue
        for name, start in (("its own answer", cold.impulse), ("zero", 0 * cold.impulse), ("nonsense", 1e3 + 0 * cold.impulse)):
            given = np.array(start, order="C")
            _, found = subject.solve(problem, start=given)
            if not np.array_equal(start, given):
                yield f"{problem.summary}, from {name}: the start was changed by the call"
            if found.verdict not in ACCEPTED:
                yield f"{problem.summary}, from {name}: {found.verdict}, residual {found.model_residual:.1e}"


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
    """Yield violations where the changed problem's velocities are not `times` those of the problem, if that was solved."""
    for problem in subject.takes(*ordinary()):
        if spatial and problem.dimension == 2:
            continue
        answer, finding = subject.solve(problem, TIGHT)
        if finding.verdict not in ACCEPTED:
            continue
        other = change(problem)
        again, found = subject.solve(other, TIGHT)
        if found.verdict not in ACCEPTED:
            yield f"{problem.summary}: solved before, {found.verdict} after; {found.reason}"
            continue
        off = np.abs(problem.velocity(answer.impulse) - other.velocity(again.impulse) / times).max(initial=0.0)
        gap = off / (problem.velocity_scale or 1.0)
        if gap > SAME_VELOCITY:
            yield f"{problem.summary}: velocities differ by {gap:.1e}"
