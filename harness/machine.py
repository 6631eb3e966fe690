"""The machine a run is made on: what it is, its versions, and how a worker holds one core, one thread and a bound on memory."""

import os
import platform
import resource
import signal
import socket
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError, distributions, version
from pathlib import Path
from typing import Any

import psutil

ROOT = Path(__file__).resolve().parent.parent
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS")
_held: list[socket.socket] = []


def pin_threads() -> None:
    """One thread for BLAS, OpenMP, numba and Rayon in every process started from here on."""
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))


def cores() -> list[int]:
    """The cores this process may use."""
    return sorted(os.sched_getaffinity(0))


def hold_core() -> int:
    """Pin this process to a core that no other worker on this machine holds, until it dies; -1 where all are held.

    The claim is a bound socket without a file (Linux's abstract namespace): the kernel ends it with the process.
    """
    for core in cores():
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            claim.bind(f"\0frictionbench-core-{core}")
        except OSError:
            claim.close()
            continue
        _held.append(claim)
        os.sched_setaffinity(0, {core})
        return core
    return -1


def bound_memory(limit: int) -> None:
    """Let this process map at most `limit` bytes beyond what it has mapped; allocations past that fail."""
    mapped = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (mapped + limit, resource.RLIM_INFINITY))


@contextmanager
def hard_limit(seconds: float) -> Iterator[Callable[[float], None]]:
    """The kernel ends this process by SIGALRM when the block takes longer, whatever native code it is in.

    The clock stands still while numba compiles. Yields a function that sets the time left anew, in seconds.
    """
    from numba.core import event

    def alarm(left: float) -> None:
        signal.setitimer(signal.ITIMER_REAL, left)

    class Pause(event.Listener):
        depth, left = 0, 0.0  # compilations nest

        def on_start(self, _: object) -> None:
            if not self.depth:
                self.left = signal.setitimer(signal.ITIMER_REAL, 0)[0]
            self.depth += 1

        def on_end(self, _: object) -> None:
            self.depth -= 1
            if not self.depth:
                alarm(self.left)

    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    alarm(seconds)
    try:
        with event.install_listener("numba:compile", Pause()):
            yield alarm
    finally:
        alarm(0)


def forget_peak_memory() -> None:
    """Start the record of this process's largest resident memory anew (Linux)."""
    with open("/proc/self/clear_refs", "w", encoding="ascii") as control:
        control.write("5")


def peak_memory() -> float:
    """Largest resident memory since forget_peak_memory, in bytes (Linux)."""
    with open("/proc/self/status", encoding="ascii") as status:
        for line in status:
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) * 1024
    return float("nan")


def describe() -> dict[str, Any]:
    """What figures of this machine must not be mixed with another's: host, processor, cores, memory, system, Python."""
    return {
        "host": host(),
        "processor": _processor(),
        "cores": len(cores()),
        "memory": psutil.virtual_memory().total,
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "threads": 1,
    }


def versions() -> dict[str, str]:
    """The version of every installed distribution, and of this project's code."""
    found = {entry.metadata["Name"]: entry.version for entry in distributions()}
    return {"frictionbench": revision(), **{name: found[name] for name in sorted(found) if name != "frictionbench"}}


def version_of(needs: tuple[str, ...]) -> str:
    """Versions of the distributions a solver needs; this project's revision for our own."""
    try:
        return ", ".join(f"{name} {version(name)}" for name in needs) or revision()
    except PackageNotFoundError:
        return ""


@cache
def revision() -> str:
    """The code's revision: the commit, marked where files differ from it; the package's version outside a checkout."""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return version("frictionbench")


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor()


def host() -> str:
    """The machine's name."""
    return platform.node()
