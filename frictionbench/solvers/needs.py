"""The distributions that a solver requires, and their installed versions.

quantecon                          a distribution of this Python; it may be imported under another name
siconos.numerics@/usr/bin/python3  a module of another Python, for a solver that runs in a child process
"""

import subprocess
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version

# Scripts that fail without a valid licence, by distribution: the demonstration licence that comes with GAMS expires.
LICENSED = {"gamspy": "import gamspy; gamspy.Set(gamspy.Container(), 'i', records=['1'])"}


@cache
def installed_version(need: str) -> str | None:
    """The installed version of a requirement; None if it is missing, or has no valid licence."""
    module, _, python = need.partition("@")
    if python:
        package = module.partition(".")[0]
        return _output(python, f"import {module}, importlib.metadata as m; print(m.version({package!r}))")
    try:
        installed = version(need)
    except PackageNotFoundError:
        return None
    return installed if need not in LICENSED or _output(sys.executable, LICENSED[need]) is not None else None


def _output(python: str, script: str) -> str | None:
    """The output of a script; None if it fails."""
    try:
        return subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
