"""docs/outside.tsv: what the contract says of every outside solver that is here, and what its package says of its licence.

    python -m frictionbench.harness.commands.outcomes > docs/outside.tsv

A line an entry: its name, what it needs with versions, the licences as the installed packages' metadata tell them, the day, and
the checks that it breaks, each with the first complaint; "none" where it keeps them all, and the reason where it is not here.
harness.commands.fairness puts the table into its page.
"""

import subprocess
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from email import message_from_string
from email.message import Message
from importlib.metadata import PackageNotFoundError, metadata
from typing import Any

from frictionbench.harness.contract.examine import Found, examine
from frictionbench.harness.process import cores
from frictionbench.solvers import available, find

COLUMNS = ("entry", "versions", "licences", "day", "broken")


def lines(specs: list[str], jobs: int) -> Iterable[str]:
    """The table, its head first."""
    yield "\t".join(COLUMNS)
    here = [spec for spec in specs if not find(spec)[0].missing]
    found = examine(here, jobs) if here else []
    for spec in specs:
        info, _ = find(spec)
        licences = "; ".join(f"{need}: {licence(need)}" for need in info.needs)
        said = f"not here: {info.missing}" if info.missing else _broken([one for one in found if one.variant == spec])
        yield "\t".join([spec, info.version, licences, f"{datetime.now(UTC):%Y-%m-%d}", said])


def licence(need: str) -> str:
    """What an installed package says of its licence: its expression, its classifiers, or the first line of its text."""
    name, _, python = need.partition(">=")[0].partition("@")
    try:
        told: Any = _elsewhere(name, python) if python else metadata(name)
    except (PackageNotFoundError, OSError, subprocess.SubprocessError):
        return "not told"
    named = [name.split(" :: ")[-1] for name in told.get_all("Classifier") or [] if name.startswith("License ::")]
    first = next(iter((told["License"] or "").strip().splitlines()), "")
    return told["License-Expression"] or ", ".join(named) or first or "not told"


def _elsewhere(module: str, python: str) -> Message:
    """The metadata of another Python's package."""
    script = f"import importlib.metadata as m; print(m.metadata({module.partition('.')[0]!r}))"
    done = subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    return message_from_string(done.stdout)


def _broken(found: list[Found]) -> str:
    told = [f"{one.check.replace('_', ' ')} ({' '.join(one.complaints[0].split())})" for one in found if one.complaints]
    return "; ".join(told) or "none"


if __name__ == "__main__":
    outside = [info for _, info in sorted(available().items()) if info.needs]
    for line in lines([spec for info in outside for spec in info.specs], len(cores())):
        sys.stdout.write(line + "\n")
