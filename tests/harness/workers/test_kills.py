"""A run whose processes are killed at any moment, and that is resumed where it was the main one, gives the same tables.

A few kills by default; FRICTIONBENCH_KILLS=200 makes more. A process is stopped before it is killed, so that it cannot end by
itself meanwhile: a kill counts only where the process was seen stopped, and then gone.
"""

import os
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
import pytest

from tests.helpers.plugin import write
from tests.helpers.runs import soon, verdicts

pytestmark = pytest.mark.slow  # the quick tests kill no process of a run

KILLS = int(os.environ.get("FRICTIONBENCH_KILLS", "6"))
WHO = {"main": 0, "server": 1, "supervisor": 2, "worker": 3}  # generations below the main process; of a plug-in, the keeper
LONGEST = 3.0  # seconds between kills: some cells
OPTIONS = ("run", "smoke", "--jobs", "1", "--scene", "stack", "--scene", "pyramid", "--time-limit", "60", "--solver", "lemke")


def started(folder: Path, plugin: Path) -> psutil.Popen:
    command = [sys.executable, "-c", "from frictionbench.commands.cli import main; main()", *OPTIONS]
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return psutil.Popen([*command, "--solver", str(plugin), "--out", str(folder)], **options)


def below(main: psutil.Process, generations: int) -> psutil.Process | None:
    """The process so many generations below one; None where there is none now."""
    found = main
    with suppress(psutil.Error):
        for _ in range(generations):
            if not (children := found.children()):
                return None
            found = children[0]
        return found
    return None


def killed(victim: psutil.Process) -> bool:
    """Kill a process; whether it was seen stopped before, and gone after."""
    try:
        victim.suspend()
        stopped = soon(lambda: victim.status() == psutil.STATUS_STOPPED)
        victim.kill()
    except psutil.Error:
        return False
    return stopped and soon(lambda: ended(victim))


def ended(victim: psutil.Process) -> bool:
    try:
        return not victim.is_running() or victim.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def progress(folder: Path) -> int:
    """A number that grows with every problem, motion and row: whoever kills a task three times gets that as its verdict."""
    found = len([*folder.glob("*/*")])
    for shard in folder.glob("shards/*"):
        with suppress(FileNotFoundError):  # one without rows is taken away again
            found += shard.stat().st_size
    return found


def test_killed_processes_change_no_table(tmp_path) -> None:
    plugin = write(tmp_path / "guest.py", first="import time", body="time.sleep(0.05)")
    assert started(tmp_path / "whole", plugin).wait() == 0
    expected = verdicts(tmp_path / "whole")
    assert {verdict for verdict, *_ in expected.values()} == {"solved", "unsolved"}
    random, landed = np.random.default_rng(0), Counter()
    while landed.total() < KILLS:
        folder, code = tmp_path / f"killed-{landed.total()}", -9
        while code == -9:
            main, before = started(folder, plugin), -1
            while main.poll() is None and landed.total() < KILLS:
                time.sleep(random.uniform(0.0, LONGEST))
                who = min(random.permutation(list(WHO)), key=lambda who: landed[who])  # each as often as the others
                victim = below(main, WHO[who])
                if victim is None or (folder / "manifest.json").exists() <= (progress(folder) == before):
                    continue
                before = progress(folder)
                landed[who] += killed(victim)
            code = main.wait()
        assert code == 0
        assert verdicts(folder) == expected
    assert landed.total() >= KILLS
    assert len(landed) == min(KILLS, len(WHO))
