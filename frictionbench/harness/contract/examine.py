"""Run all checks on a solver, each as a task of its own; a check that hangs or crashes counts as a violation.

A fault found by FIRST would break most other checks as well, which are therefore run only if it finds none. A solver that hangs
in MOST_HUNG checks is not tested further, since each check might take its whole limit.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple

from frictionbench.harness.cells import worker
from frictionbench.harness.contract.check import CHECKS
from frictionbench.harness.plans.plan import Plugin, owner
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems.verdicts import Verdict
from frictionbench.solvers import available

LIMIT = 20.0  # seconds for one check, which solves about forty small problems
MOST_HUNG = 3
FIRST = ("first_calls", "ordinary_problems")
CRASHES = "Raise no error: return an Answer with a Status and the best impulses, or refuse such problems by lacks=(...)."
HANGS = "End each call: after `limit` units of work, or, where it is None, after a number of your own."


class CheckResult(NamedTuple):
    """The violations of a check by a variant. failure: the verdict if it hung or crashed, which is then the only violation.
    inapplicable: why the check does not apply, otherwise empty."""

    variant: str
    check: str
    violations: list[str]
    failure: Verdict | None = None
    inapplicable: str = ""


def examine(specs: list[str], jobs: int, progress: Progress) -> list[CheckResult]:
    """Run the checks on every variant of the specs, which are files or names. Errors: InputError naming the solver or file."""
    named = [variant for spec in specs for variant in (available()[spec].specs if spec in available() else (spec,))]
    variants, plugins = load_plugins(named)
    with scratch_pool(plugins, jobs=jobs) as pool:
        tasks = [Task(worker.require_available, (each,), worker.IMPORT_SECONDS, owner(each, plugins)) for each in variants]
        for outcome in pool.run(tasks):
            outcome.result("solver: cannot be loaded")
    order = list(CHECKS)
    results = [result for each in variants for result in _examined(each, plugins, jobs, progress)]
    return sorted(results, key=lambda result: (variants.index(result.variant), order.index(result.check)))


def _examined(variant: str, plugins: tuple[Plugin, ...], jobs: int, progress: Progress) -> Iterator[CheckResult]:
    """Yield what the checks of a variant find, without those that are not run."""
    hung = 0
    with scratch_pool(plugins, jobs=jobs) as pool:
        for stage in (FIRST, [check for check in CHECKS if check not in FIRST]):
            tasks = [
                Task(worker.run_check, (variant, check, LIMIT), LIMIT, owner(variant, plugins), whole=False) for check in stage
            ]
            for outcome in progress.follow(f"{'first' if stage is FIRST else 'other'} checks of {variant}", pool, tasks):
                check = outcome.task.arguments[1]
                replied = [outcome.reason] if outcome.failure else outcome.value  # anything, from a plug-in
                inapplicable = replied if isinstance(replied, str) else ""
                readable = [] if inapplicable else replied
                texts = [*map(str, readable)] if isinstance(readable, list) else ["its worker returned a malformed reply"]
                yield CheckResult(variant, check, texts, outcome.failure, inapplicable)
                hung += outcome.failure == Verdict.TIMEOUT
                unsound = stage is FIRST and (outcome.failure or (check == FIRST[-1] and texts))
                if unsound or hung == MOST_HUNG:
                    return


def format_findings(results: Iterable[CheckResult]) -> str:
    """Format the findings by variant: a line for each check, violations and advice if it failed, then how many passed."""
    lines, names = [], {check: check.replace("_", " ") for check in CHECKS}
    for variant, of_variant in groupby(results, key=lambda one: one.variant):
        checked = list(of_variant)
        states = ["failed" if one.violations else "not applicable" if one.inapplicable else "passed" for one in checked]
        lines.append(variant)
        for one, state in zip(checked, states, strict=True):
            advice = {None: CHECKS[one.check].advice, Verdict.TIMEOUT: HANGS}.get(one.failure, CRASHES)
            because = f": {one.inapplicable}" if one.inapplicable else ""
            lines.append(f"  {state}  {names[one.check]}{because}")
            lines += [f"            {' '.join(text.split())}" for text in (*one.violations, advice) if one.violations]
        rest = [name for check, name in names.items() if check not in {one.check for one in checked}]
        lines += [f"  not tested before the above is mended  {', '.join(rest)}"] if rest else []
        counts = {"passed": 0, **Counter(states), "not tested": len(rest)}
        lines.append(", ".join(f"{n} {word}" for word, n in counts.items() if n or word == "passed"))
    return "\n".join(lines)
