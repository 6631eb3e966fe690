"""The machine that a run is made on, and the versions of all installed distributions and of this code."""

import platform
import subprocess
from contextlib import suppress
from functools import cache
from hashlib import sha256
from importlib.metadata import distributions, version
from pathlib import Path
from typing import Any

import psutil

from frictionbench.harness import process
from frictionbench.problems.compiled import PACKAGE

FOLDERS = ("problems", "solvers", "harness", "results", "reports")


def describe() -> dict[str, Any]:
    """Return what must be equal for times to be comparable: host, processor, cores, memory, system, Python."""
    return {
        "host": host(),
        "processor": _processor(),
        "cores": len(process.cores()),
        "memory": psutil.virtual_memory().total,
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "threads": 1,
    }


def versions() -> dict[str, str]:
    """Return the version of every installed distribution whose metadata can be read, and of this project's code."""
    installed = {}
    for each in distributions():
        with suppress(TypeError, ValueError):
            installed[each.metadata["Name"] or ""] = each.version
    return {"frictionbench": revision(), **{name: installed[name] for name in sorted(installed) if name != "frictionbench"}}


@cache
def revision() -> str:
    """Return the commit, with a hash of the code if it was changed; outside a checkout, the version with that hash."""
    unset = ("-uGIT_DIR", "-uGIT_WORK_TREE", "-uGIT_INDEX_FILE")  # set in git's hooks, where they name another repository
    git = ["env", *unset, "git", "--no-optional-locks", "-C", str(PACKAGE.parent)]  # a lock would remain after a kill
    try:
        if not (PACKAGE.parent / ".git").exists():  # the environment may lie in another repository
            raise FileNotFoundError
        commit, changes = (
            subprocess.run([*git, *command], capture_output=True, text=True, check=True, timeout=10).stdout.strip()
            for command in (["describe", "--always", "--abbrev=12"], ["status", "--porcelain", "--", "frictionbench", *FOLDERS])
        )
    except (OSError, subprocess.SubprocessError):
        return f"{version('frictionbench')}+{content()[:12]}"
    return f"{commit}-dirty-{content()[:12]}" if changes else commit


@cache
def content(folders: tuple[str, ...] = FOLDERS) -> str:
    """Return a hash of this project's code in these folders, without the baselines, which are results."""
    digest = sha256()
    for folder in folders:
        for path in sorted((PACKAGE / folder).rglob("*")):
            if path.suffix in (".py", ".html", ".js", ".md", ".svg", ".tsv") and "baselines" not in path.parts:
                digest.update(f"{path.relative_to(PACKAGE)}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def code() -> dict[str, str]:
    """Return the location and the hash of the code that this process runs."""
    return {"package": str(PACKAGE), "content": content()}


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor()


def host() -> str:
    """The machine's name."""
    return platform.node()
