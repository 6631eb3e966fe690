"""The suite of batches: every planned cell has a row, an interrupted run resumes, and a change for the worse is found."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from frictionbench.commands.single import rerun_row
from frictionbench.commands.summary import summary
from frictionbench.harness.plans.choose import choose
from frictionbench.harness.plans.plan import BatchSource
from frictionbench.harness.plans.suites import batch
from frictionbench.harness.run import run
from frictionbench.problems import InputError
from frictionbench.results import store
from frictionbench.results.compare import compare
from frictionbench.results.store import ShardWriter
from tests.helpers.made_results import batch_row, write_folder
from tests.helpers.runs import quiet

WAYS = [("calls", "cold"), ("packed", "cold"), ("packed", "warm"), ("list", "cold")]


def test_a_run_writes_every_row_and_resumes(tmp_path: Path) -> None:
    plan = replace(batch(), batches=(BatchSource("stack", {"blocks": 1}, 3),), solvers=("lemke",))
    run(plan, tmp_path, 1, quiet())
    rows = store.read_table(tmp_path, "batches")
    assert list(zip(rows["way"], rows["start"], strict=True)) == WAYS
    assert rows["verdict"].tolist() == ["solved"] * 4
    assert "batches of small problems: 4" in summary(tmp_path)
    shard = next((tmp_path / "shards").glob("batches-*.jsonl"))
    lines = shard.read_text(encoding="utf-8").splitlines(keepends=True)
    shard.write_text("".join(lines[1:]), encoding="utf-8")
    run(plan, tmp_path, 1, quiet())
    again = store.read_table(tmp_path, "batches")
    assert again["times"].map(tuple).tolist()[1:] == rows["times"].map(tuple).tolist()[1:]
    assert again["work"].tolist() == rows["work"].tolist()
    _, row = rerun_row(tmp_path, rows["key"][2], [])
    assert (row["verdict"], row["work"]) == ("solved", rows["work"][2])


@pytest.mark.parametrize(
    ("spec", "why"),
    [
        ("stak", "scene: unknown"),
        ("stack[block=2]", "stack has no"),
        ("painleve_rod", "scene: painleve_rod cannot be a batch"),
        ("random_bodies[contacts=3]", "scene: random_bodies cannot be a batch"),
    ],
)
def test_a_scene_that_is_no_batch_is_named(spec: str, why: str) -> None:
    with pytest.raises(InputError, match=why):
        choose("batch", [spec], (), None, None)


def test_a_scene_of_the_suite_or_another_size_is_chosen() -> None:
    assert choose("batch", ["cubes"], (), None, None).batches == tuple(one for one in batch().batches if one.scene == "cubes")
    assert choose("batch", ["stack[blocks=7]"], (), None, None).batches == (BatchSource("stack", {"blocks": 7}, 100),)


def test_a_lost_verdict_is_a_regression(tmp_path: Path) -> None:
    before = write_folder(tmp_path / "before", [], batches=[batch_row("lemke", "packed"), batch_row("nsgs", "packed")])
    worse = batch_row("nsgs", "packed", verdict="unsolved", verified=0.5, residual=1e-3)
    after = write_folder(tmp_path / "after", [], batches=[batch_row("lemke", "packed"), worse])
    assert compare(before, before).exit_code == 0
    found = compare(before, after)
    assert [(flip.variant, flip.before, flip.after) for flip in found.flips] == [("nsgs", "solved", "unsolved")]
    more = batch_row("lemke", "packed", work=json.dumps({"pivots": 2000}))
    grown = write_folder(tmp_path / "grown", [], batches=[more, batch_row("nsgs", "packed")])
    assert [(growth.variant, growth.counter) for growth in compare(before, grown).worse] == [("lemke", "pivots")]


def test_a_stored_row_that_cannot_run_is_named(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [], batches=[batch_row("lemke", "packed")], settings={"memory_limit": 2**30})
    with ShardWriter(folder, "batches", "other") as shard:
        shard.write(batch_row("lemke", "by magic", key="batch-magic"))
    with pytest.raises(InputError, match="way: unknown: 'by magic'"):
        rerun_row(folder, "batch-magic", [])
