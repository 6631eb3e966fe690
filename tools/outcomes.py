"""Make docs/outside.tsv: the results of the contract for every installed outside solver, and the licences of its packages.

    python -m tools.outcomes > docs/outside.tsv

A line per variant has its name, the versions of the libraries that it needs, the licences in the packages' metadata, the date,
and the checks that it fails, each with the first violation, or "none", or the reason if it is not installed. The table is part
of the page that tools.direct.page generates.
"""

import subprocess
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from email import message_from_string
from email.message import Message
from importlib.metadata import PackageNotFoundError, metadata
from typing import Any

from frictionbench.harness.contract.examine import CheckResult, examine
from frictionbench.harness.process import cores
from frictionbench.harness.progress import Progress
from frictionbench.solvers import available, find

COLUMNS = ("variant", "versions", "licences", "date", "failed_checks")


def lines(specs: list[str], jobs: int) -> Iterable[str]:
    """Yield the lines of the table, the header first."""
    yield "\t".join(COLUMNS)
    installed = [spec for spec in specs if not find(spec)[0].missing]
    results = examine(installed, jobs, Progress()) if installed else []
    for spec in specs:
        info, _ = find(spec)
        licences = "; ".join(f"{need}: {licence(need)}" for need in info.needs)
        failed = info.missing or _failed_checks([one for one in results if one.variant == spec])
        yield "\t".join([spec, info.version, licences, f"{datetime.now(UTC):%Y-%m-%d}", failed])


def licence(need: str) -> str:
    """Return a package's licence from its metadata: the licence expression, the classifiers, or the first line of the text."""
    name, _, python = need.partition(">=")[0].partition("@")
    try:
        facts: Any = _metadata_of(name, python) if python else metadata(name)
    except (PackageNotFoundError, OSError, subprocess.SubprocessError):
        return "not stated"
    named = [name.split(" :: ")[-1] for name in facts.get_all("Classifier") or [] if name.startswith("License ::")]
    first = next(iter((facts["License"] or "").strip().splitlines()), "")
    return facts["License-Expression"] or ", ".join(named) or first or "not stated"


def _metadata_of(module: str, python: str) -> Message:
    """Return the metadata of a package installed for another Python."""
    script = f"import importlib.metadata as m; print(m.metadata({module.partition('.')[0]!r}))"
    done = subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    return message_from_string(done.stdout)


def _failed_checks(results: list[CheckResult]) -> str:
    failed = [f"{one.check.replace('_', ' ')} ({' '.join(one.violations[0].split())})" for one in results if one.violations]
    return "; ".join(failed) or "none"


if __name__ == "__main__":
    outside = [info for _, info in sorted(available().items()) if info.needs]
    for line in lines([spec for info in outside for spec in info.specs], len(cores())):
        sys.stdout.write(line + "\n")
