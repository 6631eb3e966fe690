"""All checks on a solver, each a task of its own: a check that hangs or crashes counts as a violation."""

from collections import Counter
from collections.abc import Iterable
from itertools import groupby, islice
from typing import Any, NamedTuple

from frictionbench.harness.cells import worker
from frictionbench.harness.contract import checks  # noqa: F401  # registers them
from frictionbench.harness.contract.check import CHECKS, Subject
from frictionbench.harness.plans.plan import owner
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems import InputError
from frictionbench.solvers import Solver, SolverInfo, available, find

LIMIT = 20.0  # seconds for one check, which solves some forty small problems


class Found(NamedTuple):
    """The violations of a check about a variant."""

    variant: str
    check: str
    violations: list[str]


def examine(specs: list[str], jobs: int) -> list[Found]:
    """Run all checks on every variant of the specs, files or names. Errors: InputError naming the solver or the file."""
    named = [variant for spec in specs for variant in (available()[spec].specs if spec in available() else (spec,))]
    variants, plugins = load_plugins(named)
    for variant in variants:
        if not owner(variant, plugins) and (missing := find(variant)[0].missing):
            raise InputError(f"solver: {variant}: {missing}")
    tasks = [
        Task(worker.run_check, (variant, check, _violations, LIMIT), LIMIT, owner(variant, plugins), whole=False)
        for variant in variants
        for check in CHECKS
    ]
    with scratch_pool(plugins, jobs=jobs) as pool:
        outcomes = {outcome.task.arguments[:2]: outcome for outcome in pool.run(tasks)}
    return [
        Found(variant, check, [outcome.reason] if outcome.failure else _texts(outcome.value))
        for variant in variants
        for check in CHECKS
        if (outcome := outcomes[variant, check])
    ]


def _texts(value: Any) -> list[str]:
    """The violations that a worker reports; a plug-in may have made it reply with anything."""
    return [str(text) for text in value] if isinstance(value, list) else ["its worker returned a malformed reply"]


def format_findings(found: Iterable[Found]) -> str:
    """The findings as text, by variant: a line for each check, with advice and violations if it failed, then how many passed.

    An error that ends several checks, as of a solver that writes into the problem, is told once with their names.
    """
    lines: list[str] = []
    for variant, own in groupby(found, key=lambda one: one.variant):
        findings = list(own)
        causes = {one.check: tuple(each.partition(" < ")[0] for each in one.violations) for one in findings}  # innermost frame
        alike = Counter(causes.values())
        lines.append(variant)
        for one in findings:
            cause = causes[one.check]
            if not one.violations:
                lines.append(f"  passed  {_named(one.check)}")
            elif alike[cause] == 1:
                lines.append(f"  failed  {_named(one.check)}: {CHECKS[one.check].advice}")
                lines += [f"            {violation}" for violation in one.violations]
            elif one.check == next(check for check, other in causes.items() if other == cause):
                lines.append(f"  failed  {', '.join(_named(check) for check, other in causes.items() if other == cause)}")
                lines += [f"            {violation}" for violation in one.violations]
        passed = sum(not one.violations for one in findings)
        lines.append(f"{passed} passed" + (f", {len(findings) - passed} failed" if passed < len(findings) else ""))
    return "\n".join(lines)


def _named(check: str) -> str:
    return check.replace("_", " ")


def _violations(info: SolverInfo, solver: Solver, broken: list[str], check: str) -> list[str]:
    """What one check finds; at most five violations."""
    return list(islice(CHECKS[check].violations(Subject(info, solver, broken)), 5))
