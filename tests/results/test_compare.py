"""Comparison of two runs: what counts as worse, and that a comparison without common measurements never passes."""

import json
import re
from dataclasses import replace
from itertools import count, pairwise
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.stats import wilcoxon

from frictionbench.reports.comparison.files import write_files
from frictionbench.reports.comparison.markdown import markdown, summarise
from frictionbench.results import cells
from frictionbench.results.changes import Flip
from frictionbench.results.compare import Limits, compare, confirm
from frictionbench.results.conventions import RankBy
from frictionbench.results.times import estimate, may_be_slower
from tests.helpers.made_results import MACHINE, SETTINGS, solve_row, unanswered_row, write_folder

ELSEWHERE = {"machine": MACHINE | {"host": "there"}}


@pytest.fixture
def runs(tmp_path):
    """Write two folders from rows and compare them."""

    made = count()

    def make(before, after, limits=Limits(), **manifest):  # noqa: B008  # it is a value
        home = tmp_path / f"{next(made)}"
        old, new = write_folder(home / "before", before), write_folder(home / "after", after, **manifest)
        return compare(old, new, limits)

    return make


def rows(verdicts, **given):
    return [solve_row("a", f"p{i}", verdict=verdict, **given) for i, verdict in enumerate(verdicts)]


def told(findings):
    """Each finding as a short text."""
    return [f"{one.key} {one.before} → {one.after}" if isinstance(one, Flip) else one.name for one in findings]


EQUAL = {"worse": 0, "better": 0, "same": 1, "new": 0, "gone": 0, "skipped": 0}
ORDER = ["solved", "relaxed", "near_miss", "unjudgeable", "unsolved", "timeout", "crashed", "wrong"]


@pytest.mark.parametrize(("better", "worse"), list(pairwise(ORDER)))
def test_verdicts_are_ordered(runs, better, worse):
    result = runs(rows([better, better]), rows([better, worse]))
    assert result.exit_code == 1
    assert told(result.worse) == [f"a-p1-1e-08 {better} → {worse}"]
    back = runs(rows([better, worse]), rows([better, better]))
    assert (back.exit_code, told(back.better)) == (0, [f"a-p1-1e-08 {worse} → {better}"])
    equal = runs(rows([better, worse]), rows([better, worse]))
    assert (equal.exit_code, equal.same, equal.worse, equal.better) == (0, 2, [], [])
    assert markdown(equal).startswith("## worse 0 · better 0 · same 2 · new 0 · gone 0 · skipped 0\n")


@pytest.mark.parametrize(("seconds", "code"), [(0.02, 1), (6.0, 0)])  # of a limit of 10 s
@pytest.mark.parametrize("manifest", [{}, ELSEWHERE])
def test_timeouts_explained_by_machine(runs, seconds, code, manifest):
    taken = {"solve_time": seconds}
    pace = 1.5 if manifest else 1.0  # of a slower machine, as the others show it
    others = [solve_row("b", f"p{i}") for i in range(9)]
    slower = [solve_row("b", f"p{i}", solve_time=pace * 2e-3) for i in range(9)]
    before, after = rows(["solved"], **taken), [unanswered_row("a", "p0", "timeout")]
    result = runs([*others, *before], [*slower, *after], **manifest)
    assert result.exit_code == code
    assert ("changes: 1 cells whose timeout the speed of the machine may explain." in markdown(result)) is (code == 0)
    assert bool(runs([*slower, *after], [*others, *before], **manifest).better) is (code == 1)


def test_timeout_to_worse(runs):
    before = [*rows(["solved"]), unanswered_row("a", "p1", "timeout")]
    after = solve_row("a", "p1", verdict="wrong", solve_time=9.0)
    assert told(runs(before, [*rows(["solved"]), after], **ELSEWHERE).worse) == ["a-p1-1e-08 timeout → wrong"]


@pytest.mark.parametrize("manifest", [{}, ELSEWHERE])
def test_unknown_times_and_lower_limits_excuse_no_timeout(runs, manifest):
    for unknown in (None, float("nan"), float("inf"), -1.0, 0.0):
        before = [*rows(["solved"]), solve_row("b", "p", solve_times=[unknown] * 3 if unknown is not None else None)]
        result = runs(before, [*rows(["solved"]), unanswered_row("b", "p", "timeout")], **manifest)
        assert told(result.worse) == ["b-p-1e-08 solved → timeout"]
    result = runs(
        rows(["solved"] * 3), [unanswered_row("a", f"p{i}", "timeout", time_limit=1e-3) for i in range(3)], **manifest
    )
    assert (result.exit_code, len(result.of("flips"))) == (1, 3)


def test_a_longer_limit_is_unusable(runs):
    """It solves what a solver that became slower does not within the baseline's."""
    result = runs(rows(["solved"] * 2), rows(["solved"] * 2, time_limit=30.0))
    assert (result.exit_code, "has a longer time limit, 30 s in place of 10 s" in result.unusable) == (2, True)
    unknown = rows(["solved"] * 2, time_limit=None)
    assert "unknown limit 'nan'" in runs(unknown, unknown).unusable


@pytest.mark.parametrize("reason", ["not installed", ""])
@pytest.mark.parametrize("others", [1, 20])
def test_lost_coverage_fails(runs, reason, others):
    remaining = [solve_row("b", f"p{i}") for i in range(others)]
    skipped = [unanswered_row("a", f"p{i}", "skipped", reason=reason) for i in range(4)]
    result = runs([*remaining, *rows(["solved"] * 4)], [*remaining, *skipped])
    assert (result.exit_code, result.counts) == (1, EQUAL | {"same": others, "skipped": 4})
    assert told(result.worse) == [f"a-p{i}-1e-08 solved → skipped" for i in range(4)]
    assert "### `a`: worse" in markdown(result)
    assert runs([*remaining, *skipped], [*remaining, *skipped]).exit_code == 0


@pytest.mark.parametrize("verdict", ["solved", "relaxed", "near_miss", "unsolved", "timeout", "crashed", "wrong", "skipped"])
def test_new_cells_that_fail(runs, verdict):
    good, new = rows(["solved"]), [solve_row("b", f"p{i}", verdict=verdict) for i in range(3)]
    skipped = [unanswered_row("b", f"p{i}", "skipped") for i in range(3)]
    code = int(verdict not in ("solved", "relaxed", "skipped"))
    for before in (good, [*good, *skipped]):
        result = runs(before, [*good, *new])
        assert (result.exit_code, len(result.worse)) == (code, 3 * code)
        assert result.counts == EQUAL | {"worse": 3 * code, "new": 3 * (verdict != "skipped")}
        assert (f"**new → {verdict}**" in markdown(result)) is bool(code)


@pytest.mark.parametrize("after", [[solve_row("a", "other")], [unanswered_row("a", "p0", "skipped")], []])
def test_nothing_in_common_is_unusable(runs, after):
    result = runs(rows(["solved"]), after)
    assert (result.exit_code, result.unusable) == (2, "no cell was measured in both runs")


@pytest.mark.parametrize(("name", "other"), [("suite", "another"), ("tolerances", [1e-3])])
def test_different_settings_are_unusable(runs, name, other):
    result = runs(rows(["solved"]), rows(["solved"]), settings=SETTINGS | {name: other})
    assert result.exit_code == 2
    assert name in markdown(result)


@pytest.mark.parametrize("residual", [None, float("nan"), 1e-3])
def test_impossible_verdicts_are_unusable(runs, residual):
    assert "a-p0-1e-08: solved, with a residual of" in runs(rows(["solved"]), rows(["solved"], residual=residual)).unusable
    assert "unknown verdict 'fine'" in runs(rows(["solved"]), rows(["fine"])).unusable


def pivots(counts, **given):
    return [solve_row("a", f"p{i}", work=json.dumps({"pivots": count}), **given) for i, count in enumerate(counts)]


@pytest.mark.parametrize(("after", "code"), [((50, 55), 0), ((50, 60), 1), ((45, 45), 0), ((20, 20), 0)])
def test_work_growth_limit(runs, after, code):
    assert runs(pivots((40, 60)), pivots(after)).exit_code == code
    assert runs(pivots((40, 60), verdict="unsolved"), pivots(after, verdict="unsolved")).exit_code == 0


NO_PIVOTS = ["-9", "1e30", "9" * 5000, "true", "[" * 600 + "]" * 600]


@pytest.mark.parametrize("text", ['{"sweeps": 9}', "[1]", "{", "", *(f'{{"pivots": {count}}}' for count in NO_PIVOTS)])
def test_lost_counters_fail(runs, text):
    before, after = pivots([9, 9]), [*pivots([9]), solve_row("a", "p1", work=text)]
    result = runs(before, after)
    assert (result.exit_code, told(result.worse)) == (1, ["pivots"])
    assert "| **pivots** | 9 | none |  | 1 |" in markdown(result)
    assert "| sweeps | none | 9 |  | 1 |" in markdown(result) or "sweeps" not in text
    assert runs(after, before).exit_code == int("sweeps" in text)
    assert runs(after, after).exit_code == 0
    assert runs([solve_row("a", "p", work='{"restarts": 0}')], [solve_row("a", "p", work=text)]).exit_code == 1


def timed(solve, factors=(1.0,) * 4):
    """Rows of solvers a and b; a's times are 1 ms and solve, times each cell's factor."""
    given = {"form_time": 0.0, "setup_time": 1e-3}
    own = [solve_row("a", f"p{i}", **given, solve_time=solve * factor) for i, factor in enumerate(factors)]
    return [*own, *(solve_row("b", f"p{i}", **given, solve_time=1e-3 * factor) for i, factor in enumerate(factors))]


def test_single_pair_is_not_significant(runs):
    result = runs(timed(1e-3), timed(9e-3))
    assert (result.exit_code, [time.n for time in result.of("times")]) == (0, [1, 1])
    assert "| `a` | 2 ms | 10 ms | ×5.00 ~ | ~ |  | 1 | 4 |" in markdown(result)
    assert runs(timed(1e-3), timed(9e-3), Limits(times=False)).of("times") == []
    assert runs(timed(1e-3), timed(9e-3), **ELSEWHERE).of("times") == []


@pytest.mark.parametrize(
    ("solve", "worse", "better"),
    [(1.0e-3, 0, 0), (1.1e-3, 0, 0), (1.6e-3, 1, 0), (0.5e-3, 0, 1)],  # with 1 ms to set up: ratios 1, 1.05, 1.3, 0.75
)
def test_slowdown_is_detected_through_noise(runs, tmp_path, solve, worse, better):
    noise = np.random.default_rng(0)
    seen = runs(timed(1e-3), timed(solve))

    def process(seconds, name):
        busy = 3.0 if name.endswith("3") else noise.uniform(1, 1.1)  # one pair met other work
        rows = timed(seconds * busy, noise.uniform(0.97, 1.03, 4))
        return cells.read(write_folder(tmp_path / name, rows)).table

    pairs = [(process(1e-3, f"b{i}"), process(solve, f"n{i}")) for i in range(8)]
    result = confirm(seen, pairs, both=True, limits=Limits())
    assert (len(result.worse), len(result.better), result.exit_code) == (worse, better, worse)
    assert {time.n for time in result.of("times")} == {8}
    assert all(may_be_slower(pairs[:k], 8, 1.1) for k in range(3, 8)) is bool(worse)  # else it ends early
    assert ("**×1.3" in markdown(result)) is bool(worse)
    few = markdown(confirm(seen, pairs[:5], both=True, limits=Limits()))
    assert "| ~ |  | 5 | 4 |" in few
    assert "Fewer than six pairs give no interval" in few
    assert confirm(seen, pairs, both=True, limits=Limits(slowdown=1.5)).exit_code == 0
    half = [(before, process(10 ** (i % 2 - 3), f"h{i}")) for i, (before, _) in enumerate(pairs)]  # slow in some processes
    assert re.search(r"\| ×[\d.]+( ~)? \? \|", markdown(confirm(seen, half, both=True, limits=Limits())))
    assert confirm(seen, pairs, both=False, limits=Limits()).of("times") == seen.of("times")


def test_times_from_the_form(runs):
    """A solver whose solve is twice as slow, and its form a hundred times as long as that."""
    parts = {"form_times": [0.2] * 5, "setup_times": [0.0] * 5}
    sides = [rows(["solved"] * 3, solve_times=[time] * 5, **parts) for time in (1e-3, 2e-3)]
    ratios = [runs(*sides, Limits(rank_by=rank_by)).of("times")[0].ratio for rank_by in RankBy]
    assert ratios == pytest.approx([0.202 / 0.201, 2.0])


def test_disturbed_times(runs):
    def waited(slow, fast):
        times = {"form_times": [5e-4] * (slow + fast), "setup_times": [5e-4] * (slow + fast)}
        return times | {"solve_times": [9e-3] * slow + [2e-3] * fast, "disturbed": True}

    quiet = [solve_row("a", f"p{i}") for i in range(2)]
    second = [solve_row("a", "p0"), solve_row("a", "p1", **waited(2, 0))]
    brief = [solve_row("a", "p0"), solve_row("a", "p1", **waited(4, 1))]
    both = [solve_row("a", f"p{i}", **waited(2, 0)) for i in range(2)]
    for before, after, cells_and_ratio in (
        (second, quiet, (1, 1.0)),  # the machine's doing
        (quiet, brief, (2, 1.0)),
        (both, both, (2, 1.0)),  # a solver that has no others
        (quiet, second, (2, (10 / 3) ** 0.5)),  # the later code's own doing, as far as one pair shows
    ):
        (time,) = runs(before, after).of("times")
        assert (time.cells, time.ratio) == (cells_and_ratio[0], pytest.approx(cells_and_ratio[1]))


def test_slowness_by_own_processes_is_detected(runs, tmp_path):
    """A cell that waits for its core in each process of the later code and in few of the earlier counts."""
    slow = {"form_times": [0.0], "setup_times": [0.0], "disturbed": True}
    noise = np.random.default_rng(0)

    def process(name, seconds, **given):
        quick = [solve_row("a", f"p{i}") for i in range(3)]
        own = solve_row("a", "p3", **(slow | given), solve_times=[seconds * noise.uniform(1, 1.1)])
        return write_folder(tmp_path / name, [*quick, own])

    seen = compare(process("before", 0.1, disturbed=False), process("after", 1.0))
    pairs = [
        tuple(cells.read(folder).table for folder in (process(f"b{i}", 0.1, disturbed=i == 4), process(f"n{i}", 1.0)))
        for i in range(8)
    ]
    assert confirm(seen, pairs, both=True, limits=Limits()).exit_code == 1
    busy = [(before.assign(disturbed=after["disturbed"]), after) for before, after in pairs]
    assert confirm(seen, busy, both=True, limits=Limits()).exit_code == 1  # ten times slower in each
    half = [(before, after.assign(seconds=after["seconds"] / (1 + 4 * after["disturbed"]))) for before, after in busy]
    once = [*busy[:7], half[7]]  # in one pair twice as slow
    assert confirm(seen, once, both=True, limits=Limits()).exit_code == 0
    mild = [(before, after.assign(seconds=after["seconds"] / (1 + 4.5 * after["disturbed"]))) for before, after in pairs]
    assert may_be_slower([mild[4], *mild[:2]], 8, 1.1)  # the earlier code may be undisturbed in the pairs to come


def test_unconfirmed_alert_is_dropped(runs):
    seen = runs([*rows(["solved"]), *pivots([10, 10])][1:], [*rows(["wrong"]), *pivots([10, 20])][1:])
    assert seen.exit_code == 1
    before, after = (cells.read(path).table for path in (seen.baseline, seen.current))
    assert confirm(seen, [(before, after)] * 3, both=False, limits=Limits()).worse == seen.worse
    fallen = confirm(seen, [(before, after), (before, before), (before, before)], both=False, limits=Limits())
    assert (fallen.exit_code, fallen.of("flips"), fallen.of("work")) == (0, [], [])
    assert "Not confirmed, most repeats give the result of the baseline: a, pivots." in markdown(fallen)


@pytest.mark.parametrize("shown", [True, False])
def test_a_solver_that_fails_at_times(runs, shown):
    """In three of eight runs, whether the first showed it or not; as often as before is no change."""
    seen = runs(rows(["solved"] * 2), rows(["solved", "wrong" if shown else "solved"]))
    before, after = (
        cells.read(runs(rows(["solved"] * 2), rows(["solved", last])).current).table for last in ("solved", "wrong")
    )
    times, steady = [(before, after)] * 3, [(before, before)] * 5
    assert told(confirm(seen, times + steady, both=True, limits=Limits()).worse) == ["a-p1-1e-08 solved → wrong"]
    assert confirm(seen, times + [(after, before)] * 3 + steady[:2], both=True, limits=Limits()).exit_code == 0
    assert confirm(seen, times[:2] + steady + steady[:1], both=True, limits=Limits()).exit_code == 0


@pytest.mark.parametrize(
    ("lost", "named"),
    [
        ({"form_times": None, "setup_times": None, "solve_times": None}, "timed cells"),
        ({"verdict": "skipped"}, "a-p0-1e-08 solved → skipped"),
        ({"work": "{}"}, "pivots"),
    ],
)
def test_what_is_lost_in_the_repeats_alone(runs, lost, named):
    """In three of eight, of which the others show a time twice as long in too few pairs for an interval."""
    seen = runs(pivots([9]), pivots([9]))
    before, gone = (cells.read(path).table for path in (seen.baseline, runs([], [pivots([9])[0] | lost]).current))
    slow = before.assign(seconds=2 * before["seconds"])
    for steady in ([(before, slow)] * 5, []):
        found = confirm(seen, [(before, gone)] * 3 + steady, both=True, limits=Limits())
        assert (told(found.worse), found.counts["same"]) == ([named], int("verdict" not in lost))
    assert confirm(seen, [(before, gone)] * 2 + [(before, before)] * 6, both=True, limits=Limits()).exit_code == 0


def test_a_counter_that_grows_in_one_cell_and_is_gone_in_another(runs):
    """In three of eight repeats, which confirms the loss alone."""
    seen = runs(pivots([10, 10]), [*pivots([20]), solve_row("a", "p1", work="{}")])
    before, after = (cells.read(path).table for path in (seen.baseline, seen.current))
    found = confirm(seen, [(before, after)] * 3 + [(before, before)] * 5, both=True, limits=Limits())
    assert [[one.after for one in each.worse] for each in (seen, found)] == [[20, None], [None]]


def test_a_timeout_in_most_repeats_is_an_alert(runs, tmp_path):
    """Though the time of the recorded run, near the limit, would excuse it on another machine."""
    fine = [solve_row("a", f"p{i}", form_times=[0.0], setup_times=[0.0], solve_times=[1.05], time_limit=2.0) for i in range(2)]
    late = [fine[0], unanswered_row("a", "p1", verdict="timeout", time_limit=2.0)]
    seen = runs(fine, late, machine=ELSEWHERE["machine"])
    assert (seen.exit_code, seen.of("flips")) == (0, [])
    before, after = (cells.read(path).table for path in (seen.baseline, seen.current))
    assert told(confirm(seen, [(before, after)] * 8, both=True, limits=Limits()).worse) == ["a-p1-1e-08 solved → timeout"]
    assert confirm(seen, [(before, after)] * 3 + [(before, before)] * 5, both=True, limits=Limits()).exit_code == 0
    assert confirm(seen, [(before, after)] * 8, both=False, limits=Limits()).exit_code == 0


def test_missing_cells_with_removed_code(runs):
    seen = runs([*rows(["solved"]), solve_row("b", "p0")], rows(["solved"]))
    before, after = (cells.read(path).table for path in (seen.baseline, seen.current))
    without = before[before["variant"] != "b"]
    assert told(confirm(seen, [(without, after)] * 3, both=True, limits=Limits()).worse) == ["b-p0-1e-08 solved → gone"]
    assert confirm(seen, [(without, before)] * 3, both=True, limits=Limits()).exit_code == 0


@pytest.mark.parametrize("n", [3, 6, 8, 11])
def test_interval_equals_wilcoxon(n):
    shifts = np.random.default_rng(n).normal(0.3, 0.5, n)
    ratio, low, high, p = estimate(shifts)
    if n < 6:  # 2 of 2^n signs are more than one in twenty
        assert (low, high, np.isnan(p)) == (0, np.inf, True)
        return
    assert low < ratio < high
    assert p == pytest.approx(wilcoxon(shifts, method="exact").pvalue)
    assert wilcoxon(shifts - np.log(low) + 1e-9, method="exact").pvalue <= 0.05
    assert wilcoxon(shifts - np.log(low) - 1e-9, method="exact").pvalue > 0.05
    assert wilcoxon(shifts - np.log(high) + 1e-9, method="exact").pvalue > 0.05


def test_markdown_cut_and_escaping(runs):
    markup = "a|b`<script>\n# c"
    before, after = ([solve_row(markup, f"p{i}", verdict=v) for i in range(25)] for v in ("solved", "wrong"))
    text = markdown(runs(before, after))
    assert text.count("| **solved → wrong** | `bar[friction=0.2]` | 0 | 1e-8 | 1.0e-9 → 1.0e-9 |") == 20
    assert "and 5 more, which `--out` writes as data." in text
    assert "### `a\\|b'<script> # c`: worse" in text
    assert "\n# c" not in text


def test_markdown_length_limit(runs):
    before, after = (
        [solve_row(f"s{n}", f"p{i}", verdict=v) for n in range(30) for i in range(25)] for v in ("solved", "wrong")
    )
    assert 40_000 < len(markdown(runs(before, after))) < 65_536


def test_comparison_files(runs, tmp_path, monkeypatch):
    before = rows(["solved", "solved", "unsolved"])
    after = [*rows(["solved"]), unanswered_row("a", "p1", "crashed", reason="ill\x00")]
    result = runs(before, [*after, *(unanswered_row("a", problem, "skipped", reason="absent") for problem in ("p2", "p3"))])
    write_files(result, tmp_path / "out")
    told = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
    assert told["counts"] == EQUAL | {"worse": 1, "skipped": 1}
    (flip,) = told["flips"]
    assert flip["command"] == f"frictionbench rerun {result.current} a-p1-1e-08"
    assert (flip["residual_after"], told["exit_code"]) == (None, 1)
    (suite,) = ElementTree.parse(tmp_path / "out" / "junit.xml").getroot()
    assert (suite.get("name"), len(suite), len(suite.findall("*/skipped"))) == ("a", 5, 1)
    assert [case.find("failure").get("message") for case in suite if case.find("failure") is not None] == [
        "solved → crashed, residual 1.0e-9 → nan ill?",
        "unsolved → skipped, residual 1.0e-9 → nan absent",
    ]
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "summary"))
    summarise(result)
    page = (tmp_path / "out" / "comparison.md").read_text(encoding="utf-8")
    assert (tmp_path / "summary").read_text(encoding="utf-8") == page + "\n"
    write_files(replace(result, unusable="nothing"), tmp_path / "none")
    assert ElementTree.parse(tmp_path / "none" / "junit.xml").find(".//error").get("message") == "nothing"
