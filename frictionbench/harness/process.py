"""Control of a process under Linux: its core, threads and memory, and killing its descendants, orphaned ones included.

A subreaper becomes the parent of its orphaned descendants, however they were detached. The parent-death signal cannot be
blocked. A bound abstract socket claims a core; the kernel closes it when the process ends.
"""

import ctypes
import os
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

import psutil

from frictionbench.problems.check import InputError, require

# The variables from which OpenMP, OpenBLAS, MKL, numba and Rayon (Rust) read their number of threads.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS")
PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_SET_CHILD_SUBREAPER, PR_SET_NO_NEW_PRIVS = 1, 4, 36, 38  # linux/prctl.h
KILL_SECONDS = 10.0  # seconds after which killing processes that keep starting others is given up
ENDED = "ZX"  # process states in /proc: zombie, dead
LEAST_MEMORY = 2**27  # bytes: with less, a worker cannot compile a kernel
libc = ctypes.CDLL(None, use_errno=True)
held_cores: list[socket.socket] = []  # this process's claims on cores; closing one releases the core


def require_linux() -> None:
    """Check for the mechanisms that isolation and timing need. Errors: InputError on other systems than Linux."""
    lacks = f"{sys.platform} has no parent-death signal, subreaper or core affinity, which isolation needs; "
    require(sys.platform == "linux", "platform", lacks + "solvers are run and timed on Linux only")


def cores() -> list[int]:
    """Return the processor cores that this process may use, each as its first hardware thread."""
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
    """Claim a core that no other worker on this machine has claimed, until this process ends; None if all are claimed."""
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


def bound_memory(limit: int) -> int:
    """Let this process map at most `limit` more bytes, or fewer if it has a lower limit already; return how many.

    The bound cannot be raised again without privileges. Errors: InputError if the limit that this process was started with
    leaves less than LEAST_MEMORY.
    """
    mapped, bound = _memory_bound(limit)
    leaves = f"leaves a worker {max(bound - mapped, 0) / 2**20:.0f} MiB; it needs {LEAST_MEMORY / 2**20:g} MiB"
    limited = f"this program was started with a limit on address space (ulimit -v) of {bound / 2**20:.0f} MiB, which {leaves}"
    require(bound - mapped >= min(limit, LEAST_MEMORY), "memory", limited)
    resource.setrlimit(resource.RLIMIT_AS, (bound, bound))
    return bound - mapped


@contextmanager
def memory_within(limit: int) -> Iterator[None]:
    """During a block, let this process map at most `limit` more bytes. Without effect except on Linux.

    Errors: InputError if more is needed.
    """
    if sys.platform != "linux":
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (_memory_bound(limit)[1], before[1]))
    try:
        yield
    except MemoryError:
        raise InputError(f"memory: more than {limit / 2**30:g} GiB would be needed") from None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def _memory_bound(limit: int) -> tuple[int, int]:
    """Return the bytes that this process has mapped and the bytes that it may map: `limit` more, or its own limit if lower."""
    mapped = psutil.Process().memory_info().vms
    own_limits = [bound for bound in resource.getrlimit(resource.RLIMIT_AS) if bound != resource.RLIM_INFINITY]
    return mapped, min([mapped + limit, *own_limits])


def reset_peak_memory() -> None:
    """Reset the peak resident memory of this process and of its descendants."""
    for pid in (os.getpid(), *descendants(os.getpid())):
        with suppress(OSError), open(f"/proc/{pid}/clear_refs", "w", encoding="ascii") as control:
            control.write("5")


def peak_memory() -> float:
    """Return the peak resident memory since reset_peak_memory, in bytes, summed over this process and its descendants."""
    peak = 0.0
    for pid in (os.getpid(), *descendants(os.getpid())):
        with suppress(OSError), open(f"/proc/{pid}/status", encoding="ascii") as status:
            peak += sum(float(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))
    return peak


def waited() -> float:
    """Return the seconds for which this thread was runnable while its core ran another; NaN if they are not reported."""
    try:
        return int(Path("/proc/thread-self/schedstat").read_text("ascii").split()[1]) / 1e9
    except (OSError, IndexError, ValueError):
        return float("nan")


def die_with_parent(parent: int) -> None:
    """Have the kernel kill this process when its parent ends. parent: its id, 0 if it is outside the PID namespace."""
    _prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it has ended already
        os._exit(1)


def forbid_new_privileges() -> None:
    """Prevent programs that this process and its descendants execute from gaining rights, such as by set-user-ID."""
    _prctl(PR_SET_NO_NEW_PRIVS, 1)


def hide_memory() -> None:
    """Prevent processes without privileges from tracing this one or reading its memory."""
    _prctl(PR_SET_DUMPABLE, 0)


def close_all_but(*kept: int) -> None:
    """Close all inherited descriptors except the standard streams and those in `kept`."""
    held_cores.clear()  # the parent's claims, which it holds itself
    for name in _listed("/proc/self/fd"):
        if int(name) > 2 and int(name) not in kept:
            with suppress(OSError):  # the descriptor by which the folder was listed is closed already
                os.close(int(name))


def remove_folder(folder: Path) -> None:
    """Remove a folder, however deep it is, which shutil.rmtree cannot, and whatever the permissions in it are."""
    for command in (["chmod", "-R", "u+rwx"], ["rm", "-rf"]):
        subprocess.run([*command, "--", str(folder)], stderr=subprocess.DEVNULL, check=False)


@contextmanager
def no_forked_child() -> Iterator[None]:
    """End, after the block, a child process that a solver forked inside the block and that returned from the call too."""
    parent = os.getpid()
    try:
        yield
    finally:
        if os.getpid() != parent:
            os._exit(1)


def adopt_orphans() -> None:
    """Make this process the parent of orphaned descendants."""
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def _prctl(option: int, value: int) -> None:
    checked(f"prctl({option})", libc.prctl(option, value, 0, 0, 0))


def checked(call: str, result: int) -> int:
    """Return the result of a call of the C library. Errors: OSError naming the call if the result is negative."""
    if result < 0:
        raise OSError(ctypes.get_errno(), f"{call}: {os.strerror(ctypes.get_errno())}")
    return result


def children(pid: int) -> list[int]:
    """Return the ids of all children of a process, zombies included."""
    ids: list[int] = []
    for task in _listed(f"/proc/{pid}/task"):
        with suppress(OSError), open(f"/proc/{pid}/task/{task}/children", encoding="ascii") as listed:
            ids += map(int, listed.read().split())
    return ids


def descendants(pid: int) -> list[int]:
    """Return the ids of all descendants of a process, zombies included."""
    ids = children(pid)
    return ids + [below for child in ids for below in descendants(child)]


def end_descendants(*, spare: Collection[int] = ()) -> bool:
    """Kill all descendants of this process except those in `spare`; return whether any of them was running.

    Zombies of a spared process are left to it. This process must be a subreaper, or detached descendants are missed.
    """

    def is_stray(pid: int) -> bool:
        state, parent = _state(pid)
        return pid not in spare and (state not in ENDED or parent == os.getpid())

    return _end(lambda: list(filter(is_stray, descendants(os.getpid()))))


def end_children(*, spare: Collection[int]) -> None:
    """Kill all children of this process, which must be a subreaper, and the orphans that it then adopts. Processes in `spare`
    and their descendants are not killed."""
    _end(lambda: [pid for pid in children(os.getpid()) if pid not in spare])


def _end(running: Callable[[], list[int]]) -> bool:
    any_running, deadline = False, monotonic() + KILL_SECONDS
    while (strays := running()) and monotonic() < deadline:
        for pid in strays:
            any_running = any_running or _state(pid)[0] not in ENDED
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        for pid in strays:
            with suppress(OSError):
                os.waitpid(pid, os.WNOHANG)
        sleep(0.002)
    return any_running


def _state(pid: int) -> tuple[str, int]:
    """Return a process's state letter and its parent's id; X and 0 for a process that does not exist."""
    try:
        state, parent, *_ = Path(f"/proc/{pid}/stat").read_text("utf-8", "replace").rpartition(")")[2].split()
        return state, int(parent)
    except (OSError, ValueError):
        return "X", 0


def _listed(path: str) -> list[str]:
    try:
        return os.listdir(path)
    except OSError:
        return []
