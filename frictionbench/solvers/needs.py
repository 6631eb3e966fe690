"""The distributions that a solver requires, and their installed versions.

quantecon                          a distribution of this Python; it may be imported under another name
siconos.numerics@/usr/bin/python3  a module of another Python, for a solver that runs in a child process
"""

import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def installed_version(need: str) -> str | None:
    """The installed version of a requirement; None if it is missing."""
    module, _, python = need.partition("@")
    if python:
        return _in_other_python(module, python)
    try:
        return version(need)
    except PackageNotFoundError:
        return None


def _in_other_python(module: str, python: str) -> str | None:
    package = module.partition(".")[0]
    script = f"import {module}, importlib.metadata as m; print(m.version({package!r}))"
    try:
        return subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
