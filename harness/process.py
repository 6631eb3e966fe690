"""Holds on a process: its core, its threads, its memory, its end with its parent's, and the end of all that it left behind.

The mechanisms are Linux's: a subreaper is the process to which orphans below it return, however they were detached; the
signal of a parent's death cannot be missed; a bound socket without a file is a claim that the kernel ends with the process.
"""

import ctypes
import os
import signal
import socket
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

import psutil

from frictionbench.problems import InputError

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS")
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # linux/prctl.h
PATIENCE = 10.0  # seconds to end processes that start others as fast as they die
DEAD = "ZX"  # states of a process in /proc: died and not waited for; gone
held_cores: list[socket.socket] = []  # the claims on cores of this process, each until it is closed


def require_linux() -> None:
    """Errors: InputError where the mechanisms are missing that a measurement stands on."""
    if sys.platform != "linux":
        raise InputError(
            f"platform: {sys.platform} has no parent-death signal, subreaper or core affinity as this suite needs them; "
            "solvers are run and measured on Linux only"
        )


def pin_threads() -> None:
    """One thread for BLAS, OpenMP, numba and Rayon in every process started from here on."""
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))


def cores() -> list[int]:
    """The processor cores this process may use, of two threads of one core the first."""
    allowed = os.sched_getaffinity(0)
    return sorted({min(_siblings(core) & allowed) for core in allowed})


def _siblings(core: int) -> set[int]:
    path = Path(f"/sys/devices/system/cpu/cpu{core}/topology/thread_siblings_list")
    try:
        ranges = [part.partition("-") for part in path.read_text(encoding="ascii").strip().split(",")]
        return {core} | {n for first, _, last in ranges for n in range(int(first), int(last or first) + 1)}
    except (OSError, ValueError):
        return {core}


def hold_core() -> int | None:
    """A core that no other worker on this machine holds, claimed until this process dies; None where all are held."""
    for core in cores():
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            claim.bind(f"\0frictionbench-core-{core}")
        except OSError:
            claim.close()
            continue
        held_cores.append(claim)
        return core
    return None


def bound_memory(limit: int) -> None:
    """Let this process map at most `limit` bytes beyond what it has mapped; allocations past that fail."""
    import resource

    mapped = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (mapped + limit, resource.RLIM_INFINITY))


def forget_peak_memory() -> None:
    """Start the record of the largest resident memory anew, of this process and all below it."""
    for pid in (os.getpid(), *descendants(os.getpid())):
        with suppress(OSError), open(f"/proc/{pid}/clear_refs", "w", encoding="ascii") as control:
            control.write("5")


def peak_memory() -> float:
    """Largest resident memory since forget_peak_memory, in bytes: of this process and of all below it, added up."""
    peak = 0.0
    for pid in (os.getpid(), *descendants(os.getpid())):
        with suppress(OSError), open(f"/proc/{pid}/status", encoding="ascii") as status:
            peak += sum(float(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))
    return peak


@dataclass
class Core:
    """What became of this process's core within a block: see watch_core."""

    core_wait: float = float("nan")
    load: tuple[float, ...] = ()
    clock: tuple[float, ...] = ()


@contextmanager
def watch_core() -> Iterator[Core]:
    """The seconds that this thread waited for its core while the block ran; load average and clock before and after."""
    core = Core()
    before, load, clock = _waited(), os.getloadavg()[0], _clock()
    yield core
    core.core_wait = _waited() - before
    core.load, core.clock = (load, os.getloadavg()[0]), (*clock, *_clock())


def _waited() -> float:
    try:
        with open("/proc/thread-self/schedstat", encoding="ascii") as times:
            return int(times.read().split()[1]) / 1e9
    except (OSError, IndexError, ValueError):
        return float("nan")


def _clock() -> tuple[float, ...]:
    """Of the core that runs this, in Hz; nothing where the machine does not tell."""
    core = min(os.sched_getaffinity(0))
    try:
        return (int(Path(f"/sys/devices/system/cpu/cpu{core}/cpufreq/scaling_cur_freq").read_text(encoding="ascii")) * 1e3,)
    except (OSError, ValueError):
        pass
    with suppress(OSError, ValueError, IndexError), open("/proc/cpuinfo", encoding="utf-8") as told:
        return (float([line for line in told if line.startswith("cpu MHz")][core].partition(":")[2]) * 1e6,)
    return ()


def die_with_parent(parent: int) -> None:
    """Have the kernel kill this process when its parent, by its id, dies."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before
        os._exit(1)


@contextmanager
def no_forked_child() -> Iterator[None]:
    """A child that the block forks and that comes out of it ends there: it is no second worker, and forks no further."""
    home = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != home:
            os._exit(1)


def adopt_orphans() -> None:
    """Make this process the parent of every orphan below it."""
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def _prctl(option: int, value: int) -> None:
    if ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0):
        raise OSError(ctypes.get_errno(), f"prctl({option}) is refused")


def descendants(pid: int) -> list[int]:
    """The ids of all processes below one; those that died and were not waited for count too."""
    found: list[int] = []
    for task in _listed(f"/proc/{pid}/task"):
        with suppress(OSError), open(f"/proc/{pid}/task/{task}/children", encoding="ascii") as children:
            found += map(int, children.read().split())
    return found + [below for child in found for below in descendants(child)]


def end_descendants(*, spare: Collection[int] = ()) -> bool:
    """Kill everything below this process but those to spare; whether there was anything alive.

    The dead children of one that is spared are its own to wait for. Calling this, a process must be a subreaper, or what was
    detached escapes.
    """
    found, patience = False, monotonic() + PATIENCE
    while (strays := [pid for pid in descendants(os.getpid()) if not _may_stay(pid, spare)]) and monotonic() < patience:
        for pid in strays:
            found = found or _state(pid)[0] not in DEAD
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        for pid in strays:
            with suppress(OSError):
                os.waitpid(pid, os.WNOHANG)
        sleep(0.002)
    return found


def _may_stay(pid: int, spare: Collection[int]) -> bool:
    state, parent = _state(pid)
    return pid in spare or (state in DEAD and parent != os.getpid())


def _state(pid: int) -> tuple[str, int]:
    """A process's state, a letter, and its parent; X and 0 of one that is gone."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
            state, parent, *_ = stat.read().rpartition(")")[2].split()
            return state, int(parent)
    except (OSError, ValueError):
        return "X", 0


def _listed(path: str) -> list[str]:
    try:
        return os.listdir(path)
    except OSError:
        return []
