"""Runs write one row with the right verdict for every planned cell and resume after interruptions."""

import json
from contextlib import contextmanager

import pytest

from frictionbench.commands.single import rerun_row
from frictionbench.harness import run as run_module
from frictionbench.harness.cells.rows import no_problem
from frictionbench.harness.plans.plan import SimulationCell, SolveCell, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import cell_task, row_of, run
from frictionbench.harness.workers.pool import Outcome
from frictionbench.results import store
from frictionbench.results.files import ResultsError
from frictionbench.results.store import new_shard
from tests.helpers.command_line import frictionbench
from tests.helpers.runs import quiet, run_of, small_plan, verdicts


def test_run_writes_every_row_once_and_resumes(tmp_path, capsys) -> None:
    folder = tmp_path / "run"
    run(small_plan(), folder, 1, Progress())
    assert "about 1 min where all reach their time limits" in capsys.readouterr().err  # 8 solves of 5 s, a simulation of 60 s
    whole = verdicts(folder)
    assert len(whole) == 2 * 2 * 2 + 1
    assert {verdict for verdict, *_ in whole.values()} == {"solved"}
    # Lose half the rows and tear the last line left: the same command runs just what is missing.
    shard = max((folder / "shards").glob("solves-*.jsonl"), key=lambda path: path.stat().st_size)
    lines = shard.read_text(encoding="utf-8").splitlines(keepends=True)
    shard.write_text("".join(lines[:4]) + lines[4][:50], encoding="utf-8")
    run(small_plan(), folder, 1, quiet())
    assert verdicts(folder) == whole
    assert store.read_manifest(folder)["finished"]
    run(small_plan(), folder, 1, Progress())
    assert capsys.readouterr().err == "sources of problems: all 2 done\n9 cells had been run before, and none is left\n"


def test_all_solvers_take_a_problem_in_turn(tmp_path) -> None:
    """Their times are compared, and the machine's speed changes from minute to minute."""
    run(small_plan(solvers=("lemke", "clarabel"), tolerances=(1e-4,), simulations=()), tmp_path, 1, quiet())
    (lines,) = [path.read_text(encoding="utf-8").splitlines() for path in (tmp_path / "shards").glob("solves-*.jsonl")]
    assert [json.loads(line)["variant"] for line in lines] == ["lemke", "clarabel"] * 2


def test_dense_matrices_beyond_the_memory_are_told_before_they_are_made(tmp_path) -> None:
    """A solver whose matrices cannot fit is skipped with their size; it does not crash."""
    dense, piles = ("lemke", "murty", "fischer_newton"), (Source("stack", {"blocks": 700, "push": 1.0}),)
    rows = run_of(tmp_path, *dense, "interior_point", sources=piles, memory_limit=2**28).set_index("variant")
    assert rows.loc[[*dense], "verdict"].tolist() == ["skipped"] * 3
    assert rows["reason"]["lemke"].startswith("its dense matrices need 0.5 GiB, and the memory is limited to 0.2")
    assert rows["verdict"]["interior_point"] == "solved"


def test_different_plan_is_refused(tmp_path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / ".manifest-1.json").touch()  # left by a command that was killed while it wrote the manifest
    run(small_plan(simulations=()), folder, 1, quiet())
    before = verdicts(folder)
    with pytest.raises(ResultsError, match=r"settings\.tolerances"):
        run(small_plan(simulations=(), tolerances=(1e-5,)), folder, 1, quiet())
    assert verdicts(folder) == before
    one, two = ({"settings": {"plugins": [{"source": f"{name}.py", "content": name * 64}]}} for name in "ab")
    assert run_module._differences(one, two) == [
        "settings.plugins: a.py (content aaaaaaaa) in the folder, b.py (content bbbbbbbb) now"
    ]
    stranger = tmp_path / "photos"
    stranger.mkdir()
    (stranger / "holiday.txt").write_text("sun", encoding="utf-8")
    with pytest.raises(ResultsError, match="neither empty nor a results folder"):
        run(small_plan(), stranger, 1, quiet())
    assert [path.name for path in stranger.iterdir()] == ["holiday.txt"]


def test_rerun_is_bitwise_equal(tmp_path) -> None:
    folder = tmp_path / "run"
    run(small_plan(), folder, 1, quiet())
    same = ("verdict", "status", "residual", "work", "backward_error", "problems", "worst_residual", "energies")
    for table in ("solves", "simulations"):
        for key in store.read_table(folder, table)["key"].iloc[[0, -1]]:
            row, again = rerun_row(folder, key, [])
            assert {name: row.get(name) for name in same} == {name: again.get(name) for name in same}
    shown = frictionbench("rerun", str(folder), key)
    assert shown.returncode == 0, shown.stderr
    assert shown.stdout.count(row["variant"]) == 2


@pytest.mark.parametrize("verdict", [["solved"], {"solved": 1}, None, "certainly"])
def test_a_reply_without_a_verdict_is_a_crashed_row(verdict) -> None:
    source = Source("stack", {"blocks": 2})
    cell = SolveCell("abc", "origin", "lemke", 1e-6)
    task = cell_task(cell, 1.0, (), no_problem(source, "") | {"repeats": 1})
    row = row_of(Outcome(task, {"verdict": verdict}), ())
    assert (row["verdict"], row["reason"]) == ("crashed", "the worker returned a malformed row")


def test_steps_of_a_whole_motion_are_planned_by_the_worker() -> None:
    row = {"verdict": "unsolved", "steps": 100, "steps_done": 3}  # or the steps that are not done would be unknown
    assert row_of(Outcome(cell_task(SimulationCell("incline", {}, "lemke", 1e-8), 1.0, ()), row), ())["steps"] == 100


def test_replayed_starts(tmp_path) -> None:
    sources = (Source("stopping_block", {}, pick=3, steps=6),)
    rows = run_of(tmp_path, "nsgs", sources=sources, starts=("cold", "warm", "shuffled"), tolerances=(1e-8,))
    of = rows.groupby("start")["verdict"].agg(list).to_dict()
    assert of == {"cold": ["solved"] * 3, "warm": ["solved"] * 2, "shuffled": ["solved"] * 3}
    sweeps = {start: rows.loc[rows["start"] == start, "work"].map(json.loads) for start in of}
    # A block that slides on has the same impulse at every step: the warm start is the answer.
    assert max(work["sweeps"] for work in sweeps["warm"]) < max(work["sweeps"] for work in sweeps["cold"])


def test_rows_that_another_process_writes_do_not_count(tmp_path, monkeypatch) -> None:
    plan = small_plan(simulations=())
    run(plan, tmp_path / "honest", 1, quiet())
    shard = max((tmp_path / "honest" / "shards").glob("solves-*.jsonl"), key=lambda path: path.stat().st_size)
    row = json.loads(shard.read_text(encoding="utf-8").splitlines()[0])
    honest, forged = verdicts(tmp_path / "honest"), json.dumps(row | {"verdict": "wrong", "residual": 9.0}) + "\n"

    @contextmanager
    def forging(folder, table, writer):
        """Before the first row is written a shard appears whose name comes first."""
        with new_shard(folder, table, writer) as write:
            (folder / "shards" / "solves-0.jsonl").write_text(forged, encoding="utf-8")
            yield write

    monkeypatch.setattr(run_module, "new_shard", forging)
    run(plan, tmp_path / "beside", 1, quiet())
    assert verdicts(tmp_path / "beside") == honest


def test_stored_problem_that_was_exchanged_is_refused(tmp_path) -> None:
    plan = small_plan(simulations=(), solvers=("lemke",))
    run(plan, tmp_path, 1, quiet())
    one, other, *_ = (path for path in sorted((tmp_path / "problems").glob("*.npz")) if len(path.suffixes) == 1)
    one.write_bytes(other.read_bytes())
    for shard in (tmp_path / "shards").iterdir():
        shard.unlink()
    run(plan, tmp_path, 1, quiet())
    rows = store.read_table(tmp_path, "solves").set_index("problem")
    assert set(rows.loc[[one.stem], "verdict"]) == {"crashed"}
    assert all("holds another problem" in reason for reason in rows.loc[[one.stem], "reason"])
    assert set(rows.loc[[other.stem], "verdict"]) == {"solved"}
