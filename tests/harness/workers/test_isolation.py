"""Workers run the code of this package only, end with their run, and do not affect one another."""

import json
import os
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

import frictionbench as fb
from frictionbench.harness import run as runs
from frictionbench.harness.plans.plan import Plan, Source
from frictionbench.harness.run import drop_disturbed, run
from frictionbench.results import store
from frictionbench.results.files import ResultsError
from tests.helpers.friction_problems import block
from tests.helpers.runs import MARK, marked, quiet, soon

pytestmark = pytest.mark.slow  # the quick tests do not look for processes left behind

BLOCKS_SIGNALS = """
import os
import signal

from frictionbench.solvers import solver


@solver("blocks_signals", family="bad", model="coulomb")
class BlocksSignals:
    '''Hangs from the first call with all signals blocked, and so does its orphaned child process.'''

    def solve(self, *given):
        signal.pthread_sigmask(signal.SIG_SETMASK, set(signal.Signals))
        if os.fork() == 0:
            os.setsid()
        open(os.environ["FRICTIONBENCH_TEST_MARK"] + "/hangs", "a").close()
        while True:
            pass
"""

CONFIRM = """import sys; from pathlib import Path; from frictionbench.commands import confirm
confirm._cells(confirm.Code([sys.executable, "-m", "frictionbench"], []), sys.argv[1:-2], Path(sys.argv[-1]), "bodies")"""
SMOKE = ("smoke", "--scene", "stack", "--solver")
WAYS = {"run": ("-m", "frictionbench", "run", *SMOKE), "confirm": ("-c", CONFIRM, *SMOKE)}
WAYS["judge"] = ("-m", "frictionbench", "judge", ".", "--against")


@pytest.mark.parametrize(
    ("way", "name", "times"),
    [("run", "KILL", 1), ("run", "TERM", 1), ("run", "HUP", 1), ("run", "INT", 2), ("judge", "INT", 1), ("confirm", "KILL", 1)],
)
def test_ended_run_leaves_no_process(tmp_path, way, name, times) -> None:
    number, plugin = signal.Signals[f"SIG{name}"], tmp_path / "blocks_signals.py"
    plugin.write_text(BLOCKS_SIGNALS, encoding="utf-8")
    fb.save(block(), tmp_path / "step.npz", impulse=[[1.0, 0.0]], step=0.01)
    begun = subprocess.Popen(
        [sys.executable, *WAYS[way], str(plugin), "--time-limit", "300", "--out", str(tmp_path / "run")],
        env=os.environ | {MARK: str(tmp_path)},
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert soon((tmp_path / "hangs").exists)
    assert way != "confirm" or any(tmp_path.glob("frictionbench-*"))  # what it leaves is removed with the folder of the pairs
    for _ in range(times):
        begun.send_signal(number)
    _, told = begun.communicate(timeout=60)
    assert soon(lambda: not marked(str(tmp_path)))
    assert begun.returncode == (-number if name == "KILL" else 128 + number)
    assert name == "KILL" or f"interrupted by SIG{name}; run the same command again to resume" in told
    assert store.read_manifest(tmp_path / "run")["settings"]["time_limit"] == 300.0


def test_disturbed_rows_are_repeated(tmp_path, monkeypatch) -> None:
    plan = Plan("test", (Source("stack", {"blocks": 1}),), ("nsgs", "lemke", "murty"), (1e-4,))
    run(plan, tmp_path, 1, quiet())
    (shard,) = (tmp_path / "shards").glob("solves-*.jsonl")
    lines = shard.read_text(encoding="utf-8").splitlines()
    rows = [json.loads(line) | {"disturbed": k == 0, "reason": "before"} for k, line in enumerate(lines)]
    rows[1] |= {"verdict": "timeout", "disturbed": None}  # it was stopped before it could tell
    shard.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    with pytest.raises(ResultsError, match=r"another run[^{]*settings.solvers: lemke, murty in the folder only$"):
        drop_disturbed(replace(plan, solvers=("nsgs",)), tmp_path)
    drop_disturbed(plan, tmp_path)
    left, own = [], runs._run
    monkeypatch.setattr(runs, "_run", lambda *given: left.append(len(store.read_table(tmp_path, "solves"))) or own(*given))
    run(plan, tmp_path, 1, quiet())
    assert left == [1]  # what a report reads meanwhile
    again = store.read_table(tmp_path, "solves").set_index("key")["reason"]
    assert [again[row["key"]] for row in rows] == ["", "", "before"]
    for path in (tmp_path / "shards").glob("solves-*.jsonl"):
        path.write_text("", encoding="utf-8")  # as where all were disturbed
    run(plan, tmp_path, 1, quiet())
    assert left == [1, 0]
