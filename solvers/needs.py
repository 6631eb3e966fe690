"""What a solver needs that is not ours, and its version.

quantecon                          a distribution of this Python; its import name is the solver's own business
dartpy>=7                          one of at least this major version
siconos.numerics@/usr/bin/python3  a module of another Python, for a solver that runs in a child process
"""

import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def installed(need: str) -> str | None:
    """The version of what is needed, as far as it tells one; None where it is missing."""
    module, _, python = need.partition("@")
    if python:
        return _elsewhere(module, python)
    name, _, least = need.partition(">=")
    try:
        found = version(name)
    except PackageNotFoundError:
        return None
    return found if int(found.partition(".")[0]) >= int(least or 0) else None


def _elsewhere(module: str, python: str) -> str | None:
    package = module.partition(".")[0]
    script = f"import {module}, importlib.metadata as m; print(m.version({package!r}))"
    try:
        return subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
