"""The gate: what counts as worse between two runs, and that it never passes having measured nothing."""

import json
from itertools import pairwise

import numpy as np
import pytest

from results.changes import van_elteren
from results.compare import compare
from tests.made_results import MACHINE, SETTINGS, drive_row, lost_row, solve_row, write_folder


@pytest.fixture
def runs(tmp_path):
    """Write two folders from rows and compare them."""

    def make(before, after, **manifest):
        write_folder(tmp_path / "before", before)
        return compare(tmp_path / "before", write_folder(tmp_path / "after", after, **manifest))

    return make


def rows(verdicts, **given):
    return [solve_row("a", f"p{i}", verdict=verdict, **given) for i, verdict in enumerate(verdicts)]


def test_equal_runs_pass(runs):
    result = runs(rows(["solved", "wrong"]), rows(["solved", "wrong"]))
    assert (result.exit_code, result.cells, result.changes) == (0, 2, ())
    assert result.markdown.startswith("## Nothing worse")


ORDER = ["solved", "relaxed", "missed", "unjudgeable", "unsolved", "timeout", "crashed", "wrong"]


@pytest.mark.parametrize(("better", "worse"), list(pairwise(ORDER)))
def test_verdicts_are_ordered(runs, better, worse):
    result = runs(rows([better, better]), rows([better, worse]))
    assert result.exit_code == 1
    (change,) = result.worse
    assert (change.kind, change.key, change.what) == ("verdict", "a-p1-1e-08", f"{better} → {worse}")


@pytest.mark.parametrize("change", [{"machine": MACHINE | {"host": "there"}}, {"settings": SETTINGS | {"time_limit": 5.0}}])
@pytest.mark.parametrize("there", ["solved", "unsolved", "crashed"])
def test_the_gate_does_not_depend_on_another_machines_clock(runs, there, change):
    before, after = rows(["solved", "timeout", there]), rows(["solved", there, "timeout"])
    result = runs(before, after, **change)
    assert (result.exit_code, result.changes) == (0, ())
    assert "timeouts with other verdicts: 2 cells" in result.markdown


def test_what_no_clock_decides_counts_on_any_machine(runs):
    result = runs(rows(["solved", "timeout"]), rows(["wrong", "solved"]), machine={"host": "there"})
    assert [change.what for change in result.changes] == ["solved → wrong"]


def test_a_better_verdict_is_told_of_and_passes(runs):
    result = runs(rows(["wrong", "solved"]), rows(["solved", "solved"]))
    assert result.exit_code == 0
    assert [change.what for change in result.better] == ["wrong → solved"]
    assert "Better: verdict (1)" in result.markdown


def test_a_missing_cell_is_worse(runs):
    result = runs(rows(["solved", "solved"]), rows(["solved"]))
    assert [(change.kind, change.key) for change in result.worse] == [("missing", "a-p1-1e-08")]


@pytest.mark.parametrize(("reason", "code"), [("not installed", 0), ("", 1)])
def test_a_skip_is_excused_by_a_reason(runs, reason, code):
    kept = solve_row("b", "p0")
    assert runs([kept, solve_row("a", "p0")], [kept, lost_row("a", "p0", "skipped", reason=reason)]).exit_code == code


def test_a_solver_skipped_as_a_whole_excuses_its_cells(tmp_path):
    kept = solve_row("b", "p0")
    before = write_folder(tmp_path / "before", [kept, solve_row("a", "p0"), solve_row("a", "p1")])
    after = write_folder(tmp_path / "after", [kept, lost_row("a", "p0", "skipped")])
    result = compare(before, after)
    assert result.exit_code == 0
    assert "skipped, with a reason: 2" in result.markdown


def test_nothing_measured_in_both_is_unusable(runs):
    assert runs(rows(["solved"]), [solve_row("a", "other")]).exit_code == 2


def test_all_skipped_is_unusable(runs):
    result = runs(rows(["solved"]), [lost_row("a", "p0", "skipped")])
    assert (result.exit_code, result.unusable) == (2, "no cell was measured in both runs")


def test_empty_tables_are_unusable(runs):
    assert runs([], []).exit_code == 2


@pytest.mark.parametrize("name", ["suite", "tolerances"])
def test_unlike_runs_are_unusable(runs, name):
    result = runs(rows(["solved"]), rows(["solved"]), settings=SETTINGS | {name: "another"})
    assert result.exit_code == 2
    assert name in result.markdown


def test_a_folder_that_is_none_is_unusable(tmp_path):
    result = compare(tmp_path, tmp_path / "absent")
    assert result.exit_code == 2
    assert "manifest.json" in result.markdown


def test_an_unknown_verdict_is_unusable(runs):
    assert "unknown verdict 'fine'" in runs(rows(["solved"]), rows(["fine"])).unusable


@pytest.mark.parametrize(("after", "code"), [((50, 60), 0), ((50, 61), 1), ((45, 45), 0), ((20, 20), 0)])
def test_work_may_grow_by_a_tenth_in_sum(runs, after, code):
    def made(pivots):
        return [solve_row("a", f"p{i}", work=json.dumps({"pivots": count})) for i, count in enumerate(pivots)]

    assert runs(made((40, 60)), made(after)).exit_code == code


def test_grown_work_tells_the_sums(runs):
    before, after = ([solve_row("a", "p", work=json.dumps({"pivots": n, "restarts": r}))] for n, r in ((10, 0), (12, 3)))
    assert [change.what for change in runs(before, after).worse] == [
        "pivots: 10 → 12 (×1.20), 1 cells",
        "restarts: 0 → 3, 1 cells",
    ]


def test_work_counts_only_where_both_runs_solved(runs):
    before, after = ([solve_row("a", "p", verdict="unsolved", work=json.dumps({"pivots": n}))] for n in (10, 90))
    assert runs(before, after).exit_code == 0


@pytest.mark.parametrize("text", ['{"pivots": "many"}', "[1]", "{", '{"pivots": NaN}', '{"pivots": true}'])
def test_work_that_is_no_count_is_left_out(runs, text):
    assert runs(rows(["solved"], work=text), rows(["solved"], work=text)).exit_code == 0


def timed(solve, cells=4, repeats=5):
    times = [solve * (1 + 0.01 * k) for k in range(repeats)]
    return [solve_row("a", f"p{i}", form_time=0.0, setup_time=1e-3, solve_times=times) for i in range(cells)]


@pytest.mark.parametrize(
    ("solve", "code"),
    [(1.0e-3, 0), (1.4e-3, 0), (1.6e-3, 1)],  # with 1 ms to prepare: ratios 1, 1.2, 1.3
)
def test_a_quarter_slower_is_worse(runs, solve, code):
    assert runs(timed(1e-3), timed(solve)).exit_code == code


def test_twice_as_fast_is_better(runs):
    result = runs(timed(9e-3), timed(4e-3))
    assert result.exit_code == 0
    assert [(change.kind, change.variant) for change in result.better] == [("time", "a")]


def test_a_single_slow_measurement_is_chance(runs):
    assert runs(timed(1e-3, cells=1, repeats=1), timed(9e-3, cells=1, repeats=1)).exit_code == 0


@pytest.mark.parametrize(
    "manifest",
    [{"machine": MACHINE | {"host": "there"}}, {"settings": SETTINGS | {"time_limit": 5.0}}],
    ids=["machine", "setting"],
)
def test_times_of_unlike_machines_or_settings_are_not_compared(runs, manifest):
    result = runs(timed(1e-3), timed(9e-3), **manifest)
    assert result.exit_code == 0
    assert "Times are not compared" in result.markdown


def test_van_elteren_by_hand():
    # Mann and Whitney: 5 against 5, all greater: U = 25, mean 12.5, variance 25 * 11 / 12
    old, new = np.arange(5.0), np.arange(5.0) + 10
    one = 12.5 / np.sqrt(25 * 11 / 12)
    assert van_elteren([(old, new)]) == pytest.approx(one)
    assert van_elteren([(new, old)]) == pytest.approx(-one)
    assert van_elteren([(old, new)] * 4) == pytest.approx(2 * one)
    assert van_elteren([(old, old)]) == 0
    assert van_elteren([]) == 0


def test_drives_count_too(tmp_path):
    solves = rows(["solved"])
    before = write_folder(tmp_path / "before", solves, [drive_row("a")])
    after = write_folder(tmp_path / "after", solves, [drive_row("a", verdict="unsolved")])
    assert [change.key for change in compare(before, after).worse] == ["drive-a"]


def test_markdown_lists_twenty_and_keeps_strangers_text_in_its_cell(runs):
    evil = "a|b`<script>\n# c"
    before, after = ([solve_row(evil, f"p{i}", verdict=v) for i in range(25)] for v in ("solved", "wrong"))
    text = runs(before, after).markdown
    assert text.count("solved → wrong") == 20
    assert "and 5 more." in text
    assert "| `a\\|b'<script> # c` |" in text
    assert "\n# c" not in text
