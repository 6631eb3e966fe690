"""Limits hold: those of the shell, those on memory, and the clock of a plug-in. What ends a task is named."""

import resource
import subprocess
import sys
from functools import partial
from pathlib import Path

from frictionbench.harness.deadline import Deadline
from frictionbench.harness.workers.pool import Task, scratch_pool
from frictionbench.problems.compiled import kernel
from tests.helpers.paths import ROOT

BOUNDED = """
import resource
from frictionbench.harness import process
from frictionbench.harness.cells import worker
from frictionbench.commands.single import solve_one
print(process.bound_memory(2**28))
soft, hard = resource.getrlimit(resource.RLIMIT_AS)
print(soft == hard)
"""


def limited(limit: int, *command: str) -> subprocess.CompletedProcess[str]:
    """A command of Python under a limit on address space."""
    bound = partial(resource.setrlimit, resource.RLIMIT_AS, (limit, limit))
    return subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False, cwd=ROOT, preexec_fn=bound)


def test_the_lesser_of_two_memory_limits_holds() -> None:
    assert limited(resource.RLIM_INFINITY, "-c", BOUNDED).stdout.split() == [str(2**28), "True"]
    given, hard = limited(2**30, "-c", BOUNDED).stdout.split()
    assert (0 < int(given) <= 2**28, hard) == (True, "True")


def test_worker_that_cannot_start_ends_the_command() -> None:
    done = limited(700 * 2**20, "-m", "frictionbench", "solve", "stack[blocks=1]", "--solver", "lemke")
    assert done.returncode == 2
    assert "ulimit -v" in done.stderr or "MemoryError" in done.stderr
    assert "crashed" not in done.stdout


OURS = """
import numpy as np
from numba import njit
from numba.core import event
from frictionbench.harness.deadline import Deadline
from frictionbench.problems.catalogue import scene
from frictionbench.problems.residual import residual

problem = scene("stack", blocks=2).problem()
deadline, seen = Deadline(), []
record = type("Record", (event.Listener,), {"on_start": lambda *_: None, "on_end": lambda *_: seen.append(deadline.left > 5.0)})
theirs = njit(lambda x: x + 1)
with deadline.within(5.0, compiling=60.0, ours=True), event.install_listener("numba:compiler_lock", record()):
    with event.trigger_event("numba:compiler_lock"):
        print(deadline.left <= 5.0)
    theirs(1)
    print(any(seen))
    residual(problem, np.zeros((4, 2)))
    print(4.0 < deadline.left <= 5.0, len(deadline._met) > 1)
    known = len(deadline._met)
    theirs.recompile()
    print(known == len(deadline._met))
"""


def test_only_our_kernels_stop_the_clock_of_a_plugin() -> None:
    """Each once; neither an event without compilation nor a kernel of the plug-in's does."""
    done = subprocess.run([sys.executable, "-c", OURS], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.split() == ["True", "False", "True", "True", "True"]


def test_compiler_event_does_not_stop_the_clock() -> None:
    """An event of numba's lock pauses the deadline for the seconds allowed, in all, and for a plug-in's cell not at all."""
    from numba.core import event

    deadline = Deadline()
    with deadline.within(5.0, compiling=0.0), event.trigger_event("numba:compiler_lock"):
        assert deadline.left <= 5.0
    with deadline.within(5.0, compiling=7.0):
        with event.trigger_event("numba:compiler_lock"):
            assert 5.0 < deadline.left <= 12.0
        assert deadline.left <= 5.0
        with event.trigger_event("numba:compiler_lock"):
            assert deadline.left <= 12.0


def _compiles_on_a_full_disk() -> int:
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    return kernel(lambda x: x + 1)(1)


def _hits_in_a_damaged_cache(suffix: str) -> list[int]:
    """How often a kernel is found in its cache, whose files of this suffix were emptied, and then again."""
    made = [kernel(lambda x: x + 1) for _ in range(3)]
    made[0](1)
    for path in Path(made[0].stats.cache_path).glob(f"*{suffix}"):
        path.write_bytes(b"")
    return [sum(each.stats.cache_hits.values()) for each in made[1:] if each(1) == 2]


def test_a_kernel_that_cannot_be_cached_is_compiled() -> None:
    tasks = [Task(_hits_in_a_damaged_cache, (".nbi",), 60.0), Task(_hits_in_a_damaged_cache, (".nbc",), 60.0)]
    with scratch_pool() as pool:
        outcomes = list(pool.run([*tasks, Task(_compiles_on_a_full_disk, (), 60.0)]))
    assert [(outcome.value, outcome.reason) for outcome in outcomes] == [([0, 1], ""), ([0, 1], ""), (2, "")]


def test_sys_exit_in_a_task_is_named() -> None:
    with scratch_pool() as pool:
        (outcome,) = pool.run([Task(sys.exit, (3,), 60.0)])
    assert (outcome.failure, outcome.reason[:13]) == ("crashed", "SystemExit: 3")
