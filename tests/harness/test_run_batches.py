"""The suite of batches: every planned cell has a row, an interrupted run resumes, and a change for the worse is found."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from frictionbench.commands.single import rerun_row
from frictionbench.commands.summary import summary
from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.harness.plans.plan import BatchSource
from frictionbench.harness.plans.suites import batch
from frictionbench.harness.run import run
from frictionbench.problems import InputError
from frictionbench.results import store
from tests.helpers.made_results import solve_row, write_folder
from tests.helpers.runs import quiet

WAYS = [("calls", "cold"), ("packed", "cold"), ("list", "cold"), ("packed", "warm")]


def test_a_run_writes_every_row_and_resumes(tmp_path: Path) -> None:
    folder = tmp_path / "of today"
    plan = replace(batch(), batches=(BatchSource("stack", {"blocks": 1}, 3),), solvers=("lemke",))
    run(plan, folder, 1, quiet())
    rows = store.read_table(folder, "batches")
    assert list(zip(rows["way"], rows["start"], strict=True)) == WAYS
    assert rows["verdict"].tolist() == ["solved"] * 4
    assert re.search(f"batches of small problems: 4(.|\n)* report '{folder}'$", summary(folder))
    skipped = [solve_row(solver, "p", verdict="skipped", reason=solver[:1] * 300) for solver in ("lemke", "nsgs", "nncg")]
    cut = summary(write_folder(tmp_path / "cut", skipped))  # not as if it ended there
    assert re.search(r"^2 × skipped \(2 solvers\): n+ \.\.\.\n1 × skipped \(lemke\): l{100,140} \.\.\.$", cut, re.MULTILINE)
    shard = next((folder / "shards").glob("batches-*.jsonl"))
    lines = shard.read_text(encoding="utf-8").splitlines(keepends=True)
    shard.write_text("".join(lines[1:]), encoding="utf-8")
    run(plan, folder, 1, quiet())
    again = store.read_table(folder, "batches")
    assert again["times"].map(tuple).tolist()[1:] == rows["times"].map(tuple).tolist()[1:]
    assert again["work"].tolist() == rows["work"].tolist()
    _, row = rerun_row(folder, rows["key"][2], [])
    assert (row["verdict"], row["work"]) == ("solved", rows["work"][2])


def test_a_scene_that_is_no_batch_is_named() -> None:
    with pytest.raises(InputError, match="scene: painleve_rod cannot be a batch"):
        choose(RunOptions("batch", ["painleve_rod"]))
