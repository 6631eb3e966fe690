"""A run on a local dask cluster survives the loss of a worker and reports the loss of the scheduler."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import MagicMock

import pytest

from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run
from frictionbench.harness.workers.cluster import Cluster
from frictionbench.harness.workers.pool import Task
from frictionbench.results.files import ResultsError
from tests.helpers.runs import quiet, small_plan, verdicts

pytestmark = pytest.mark.slow  # the quick tests start no scheduler


@contextmanager
def dask_cluster(folder: Path) -> Iterator[tuple[str, list[subprocess.Popen]]]:
    """A scheduler and two workers over TCP on loopback: its address and the three."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
    quietly = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "start_new_session": True, "cwd": folder}
    environment = os.environ | {"DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", address, "--no-dashboard"]
    processes = [subprocess.Popen(dask, env=environment, **quietly)]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    worker += ["--local-directory", str(folder)]
    processes += [subprocess.Popen(worker, env=environment, **quietly) for _ in range(2)]
    try:
        yield address, processes
    finally:
        for process in processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


class KillAfter(Progress):
    """Kills a worker or the scheduler, or stops it, after a few cells."""

    def __init__(self, killed: subprocess.Popen, cells: int, number: int = signal.SIGKILL) -> None:
        super().__init__(quiet=True)
        self.killed, self.left, self.number = killed, cells, number

    def counted(self, name, items, total, done=0):
        for item in super().counted(name, items, total, done):
            if name == "cells":
                self.left -= 1
                if self.left == 0:
                    os.killpg(self.killed.pid, self.number)
            yield item


def wait_for_workers(address: str, count: int) -> None:
    from distributed import Client

    with Client(address, timeout=60) as client:
        client.wait_for_workers(count, timeout=60)


@pytest.mark.filterwarnings("default")
def test_lost_worker_and_lost_scheduler(tmp_path) -> None:
    pytest.importorskip("distributed")
    run(small_plan(), tmp_path / "here", 1, quiet())
    (tmp_path / "scratch").mkdir()
    with dask_cluster(tmp_path / "scratch") as (address, (scheduler, worker, _)):
        wait_for_workers(address, 2)
        killer = KillAfter(worker, cells=3)
        run(small_plan(), tmp_path / "there", 1, killer, cluster=address)
        assert killer.left < 0
        assert worker.wait(timeout=10) == -signal.SIGKILL
        with pytest.raises(ResultsError, match="cluster: lost the connection to its scheduler; run the same command again"):
            run(small_plan(), tmp_path / "lost", 1, KillAfter(scheduler, cells=2), cluster=address)
    assert verdicts(tmp_path / "there") == verdicts(tmp_path / "here")


def test_a_task_waits_where_the_last_worker_has_left(tmp_path) -> None:
    cluster, future = Cluster.__new__(Cluster), MagicMock(status="lost")
    future.add_done_callback = lambda put: put(future)
    cluster._client = MagicMock(sync=lambda *_, **__: {"workers": {}}, submit=lambda *_, **__: future)
    cluster._folder, cluster._settings = tmp_path, ((), 0)
    with pytest.raises(ResultsError, match="cluster: lost"):  # the task was submitted nevertheless
        list(cluster.run([Task(len, ((),), 1.0)]))
