"""Two rankings, weights, percentiles, what scenes and noise decide, and the words for relaxations, by hand."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import typer
from matplotlib.figure import Figure

from frictionbench.commands.options import parse_duration
from frictionbench.commands.single import advice, refusals
from frictionbench.reports import accuracy, choice, tables
from frictionbench.reports.charts import profiles, steps
from frictionbench.reports.choice import headline
from frictionbench.reports.page import write_report
from frictionbench.reports.recorded import motions
from frictionbench.reports.run import annotate, read_run
from frictionbench.results.conventions import ANOTHER_LAW, POLYGON, RankBy, ending, law
from tests.helpers.made_results import solve_row, unanswered_row, write_folder
from tests.reports.test_report import PLANE, run_of, table

TIMES = ("form_time", "setup_time", "solve_time")


def robot(count=8):
    """A robot with hinges: nsgs has to eliminate them first, and is four times as fast once that is done."""
    parts = {"interior_point": (1e-4, 1e-4, 7e-4), "nsgs": (2e-3, 0.0, 2e-4)}
    return [
        solve_row(name, f"p{i}", scene=f"robot{i}", contacts=9, **dict(zip(TIMES, own, strict=True)))
        for name, own in parts.items()
        for i in range(count)
    ]


def first(run, name=PLANE):
    return next(kind for kind in choice.choices(run) if kind.name == name).choices[1e-8]


def test_order_is_reversed_without_form(tmp_path):
    run = run_of(*robot())
    other = run.ranked_by(RankBy.FORM)
    assert first(run).orders[1] == ["interior_point", "nsgs"]
    assert first(other).orders[1] == ["nsgs", "interior_point"]
    assert first(other).lead == pytest.approx((8e-4 + 1e-5 - 1e-5) / 2e-4)
    (line,) = headline({one.rank_by: choice.choices(one) for one in (run, other)}, 1e-8)
    assert "From bodies interior_point has the least mean" in line
    assert "from the method's own form nsgs has the least mean" in line
    page = write_report(write_folder(tmp_path, robot())).read_text(encoding="utf-8")
    assert [". From bodies" in lead for lead in re.findall(r'class="lead">(.*)', page)] == [True, False]
    same = run_of(*(row | {"form_time": 0.0, "form_times": [0.0] * 3} for row in robot()))
    (line,) = headline({one.rank_by: choice.choices(one) for one in (same, same.ranked_by(RankBy.FORM))}, 1e-8)
    assert line.endswith("interior_point (4.00 to 4.00); from the method's own form the order of the first three is the same.")
    mixed = run_of(*robot(), *(row | {"scene": "robot_step", "problem": f"r{row['problem']}"} for row in robot()))
    line = headline({one.rank_by: choice.choices(one) for one in (mixed, mixed.ranked_by(RankBy.FORM))}, 1e-8)[0]
    assert line.startswith("In the plane, 16 problems (of which 8 are robots' steps), to ")
    # form is left out tolerance by tolerance: another tolerance may be the fastest then
    times = accuracy.times_to(run.ranked, 1e-8, RankBy.FORM)
    assert times.set_index("label").loc["nsgs", "charged"].tolist() == pytest.approx([2e-4] * 8)


def uneven():
    """Twelve problems of one scene, where a is the faster, and one of each of six others, where b is."""
    scenes = [("many", i) for i in range(12)] + [(f"s{k}", 0) for k in range(6)]
    times = {"a": (1e-3, 4e-3), "b": (2e-3, 2e-3)}
    return [
        solve_row(name, f"{scene}{i}", scene=scene, form_time=0.0, setup_time=0.0, solve_time=own[scene != "many"])
        for name, own in times.items()
        for scene, i in scenes
    ]


def test_means_shares_and_profiles_are_weighted_by_hand():
    run = run_of(*uneven())
    mean = {one.label: one.mean for one in first(run).places}
    expected = np.exp(np.log(1e-3 + 1e-5) / 7 + np.log(4e-3 + 1e-5) * 6 / 7) - 1e-5  # seven strata, whatever their problems
    assert mean == pytest.approx({"a": expected, "b": 2e-3})
    assert run.summaries[1e-8].set_index(["problem_class", "label"]).loc[(PLANE, "a"), "mean"] == pytest.approx(expected)
    curves = accuracy.profiles(accuracy.overall(run.times[1e-8])[PLANE])
    assert curves["a"].share(np.array([1.0, 1.5, 2.5])) == pytest.approx([1 / 7, 1 / 7, 1])
    assert profiles.panels(run)[0].title == f"{PLANE}, within 1e-8"
    weight = accuracy.weights(run.ranked.query("label == 'a'"))
    assert sorted(set(weight.round(9))) == [round(1 / 84, 9), round(1 / 7, 9)]
    assert accuracy.effective(weight.to_numpy()) == pytest.approx(1 / (12 / 84**2 + 6 / 49))
    # decades and dimensions are strata of their own
    facts = pd.DataFrame({"scene": "s", "contacts": [1, 10, 11, 100, 10], "dimension": [2, 2, 2, 2, 3]})
    assert accuracy.strata(facts).nunique() == 3


def test_profiles_are_drawn_to_the_largest_ratio():
    """Of eight problems b solves seven, the last in 2e5 times the time of a; each is the fastest on four."""
    rows = [*pair([0.1, 0.2, 0.5, 0.9, 2.0, 3.0, 2e5]), solve_row("a", "last"), unanswered_row("b", "last", "timeout")]
    (panel,) = profiles.panels(run_of(*rows))
    panel.draw(ax := Figure().subplots())
    ends = [line.get_xydata()[[0, -1]].ravel().tolist() for line in ax.lines]
    assert ends == [pytest.approx([1, 0.5, 2e5, 1]), pytest.approx([1, 0.5, 2e5, 7 / 8])]
    assert (ax.get_xlim(), [text.get_text() for text in ax.get_xticklabels()]) == ((1, 1e6), ["1", "100", "1e4", "1e6"])


def test_too_few_problems_name_no_winner():
    assert first(run_of(*uneven())).interval is not None
    few = run_of(*(row for row in uneven() if row["scene"] in ("many", "s0")))  # 13 problems, one with half of the weight
    assert first(few).unclear == "too few to rank"
    (line,) = headline({one.rank_by: choice.choices(one) for one in (few, few.ranked_by(RankBy.FORM))}, 1e-8)
    assert line.count("too few to rank") == 1
    alone = run_of(*(row for row in uneven() if row["solver"] == "a"))  # with nothing to compare it with
    (line,) = headline({one.rank_by: choice.choices(one) for one in (alone, alone.ranked_by(RankBy.FORM))}, 1e-8)
    assert "to a verified residual of 1e-8: a solves 18, from bodies with a mean of " in line


def pair(ratios, **given):
    """b takes 1 ms on each problem, a 1 ms over the ratio; a scene each."""
    plain = {"form_time": 0.0, "setup_time": 0.0}
    rows = [solve_row("a", f"p{i}", scene=f"s{i}", solve_time=1e-3 / r, **plain) for i, r in enumerate(ratios)]
    given = {"solve_time": 1e-3} | given
    return rows + [solve_row("b", f"p{i}", scene=f"s{i}", **plain | given) for i in range(len(ratios))]


def test_a_winner_has_an_interval_without_one():
    clear, doubtful = (first(run_of(*pair(ratios))) for ratios in ([1.5, 1.6, 1.4, 1.5] * 2, [3.0, 0.8, 3.0, 0.7] * 2))
    for one in (clear, doubtful):
        assert one.interval[0] < one.lead < one.interval[1]
    assert (clear.orders[1][0], clear.unclear, doubtful.unclear) == ("a", "", "no clear winner")
    near, above = (clear._replace(interval=(end, 2.0)).unclear for end in (1.004, 1.006))  # printed as 1.00 and 1.01
    assert (near, above) == ("no clear winner", "")


def test_problems_of_one_scene_do_not_make_a_lead_certain():
    """a is faster in one scene of 30 problems and in two of three others: drawn as problems, the lead would be certain."""
    rows = pair([2.0, 2.0, 0.6, 1.1])
    rows += [
        solve_row(name, f"many{i}", scene="s0", contacts=20 * (i % 2) + 2, form_time=0.0, setup_time=0.0, solve_time=time)
        for name, time in (("a", 5e-4), ("b", 1e-3))
        for i in range(30)
    ]
    found = first(run_of(*rows))
    assert found.lead > 1.3
    assert found.interval[0] < 1
    problem = pd.DataFrame({"cluster": list("aaab"), "stratum": list("xxyz"), "weight": [1 / 6, 1 / 6, 1 / 3, 1 / 3]})
    drawn = choice.draw_problems(problem, np.random.default_rng(0))
    assert drawn.sum(axis=1) == pytest.approx(np.ones(choice.DRAWS))
    assert drawn[:, 3].std() > 0.3  # the scene of one stratum is there, twice, or not at all
    assert np.mean(drawn[:, 3] == 0) == pytest.approx(1 / 4, abs=0.05)


def test_steps_of_robots_are_a_class_whose_clusters_are_models():
    rows = [
        solve_row("a", f"p{k}", scene="robot_step", parameters=json.dumps({"case": f"{model}-walk-{k}"}), dimension=3)
        for k, model in enumerate(["anymal", "anymal", "hand", "panda", "hand", "panda", "g1", "g1"])
    ]
    run = run_of(*rows, *pair([2.0] * 3))
    assert run.ranked.drop_duplicates("problem_id")["cluster"].nunique() == 4 + 3
    fall = solve_row("a", "p9", scene="box_tower", dimension=3)
    found = [[(kind.name, kind.problems) for kind in choice.choices(one) if kind.first] for one in (run, run_of(*rows, fall))]
    assert found == [[(PLANE, 3), ("in space", 8)], [("in space", 9), ("robots' steps", 8)]]  # nothing is told twice


def test_repeats_widen_the_interval():
    calm, noisy = ([1e-3] * 5, [0.6e-3, 0.7e-3, 1e-3, 2e-3, 4e-3])
    widths = []
    for times in (calm, noisy):
        low, high = first(run_of(*pair([1.2] * 8, solve_times=times, form_times=[0.0] * 5, setup_times=[0.0] * 5))).interval
        widths.append(high - low)
    assert widths[0] == pytest.approx(0, abs=1e-9)
    assert widths[1] > 0.1


def test_leads_by_the_shortest_repeats_tell_what_waiting_did():
    """b waited for its core in two of three repeats of each cell, and seems slower than a; one that failed remains charged."""
    rows = pair([1.0] * 8, solve_times=[5e-4, 4e-3, 4e-3], solve_time=4e-3, disturbed=True)
    assert (first(run_of(*rows)).orders[1], first(run_of(*rows)).lead) == (["a", "b"], pytest.approx(4))
    told = "Of 16 cells 8 shared or waited for their core while they were timed. By the shortest repeat of "
    lead = "each cell, from bodies, in the plane: b is 2.00 times ahead of a (2.00 to 2.00)."
    assert choice.disturbed(run_of(*rows)) == told + lead
    rows[-1] |= {"verdict": "unsolved", "residual": 1.0, "solve_times": [4e-3]}
    mean = np.exp(7 / 8 * np.log(5.1e-4) + np.log(10) / 8) - 1e-5
    for part in (", 1 of them timed once.", f"a is {mean / 1e-3:.2f} times ahead of b (0.500 to ", "): no clear winner."):
        assert part in choice.disturbed(run_of(*rows))
    assert choice.disturbed(run_of(*rows[:8])) == ""


def test_the_first_screen_tells_the_most_dependable_choice():
    """A portfolio that solves all and is rarely the fastest, a method that misses one, and two of outside libraries, of which
    one solves another law, which is the same on these problems."""
    solvers = ("mixed", 2e-3, "1", "coulomb"), ("quick", 1e-3, "1", "coulomb"), ("theirs", 5e-3, "lib 2", "coulomb")
    rows = [
        solve_row(name, f"p{i}", scene=f"s{i}", solve_time=time, version=version, model=model)
        | {"members": "quick" if name == "mixed" else None}
        for name, time, version, model in (*solvers, ("convex", 9e-3, "lib 3", "relaxation"))
        for i in range(8)
    ]
    rows[8] |= {"verdict": "unsolved", "residual": 1.0}
    run = replace(run_of(*rows), manifest={"versions": {"frictionbench": "1"}})
    found = first(run)
    facts = {place.label: (place.reached, place.fastest) for place in found.places}
    assert facts == {"mixed*": (8, 1), "theirs": (8, 0), "quick": (7, 7), "convex": (8, 0)}
    assert (found.common, found.outside) == (7, 1)
    common = {place.label: place.common for place in found.places}
    assert common["quick"] == pytest.approx(2e-3)  # with the millisecond of form and setup, and no charge
    told = choice.dependable(found)
    assert told.startswith("the most dependable choice among 2 own methods and 1 outside solver of Coulomb's law is mixed*")
    assert "8 of 8 solved, itself the fastest on 1; the best single method is theirs, 8 of 8 solved" in told
    assert told.endswith("most often the fastest is quick, on 7")


def test_charges_that_change_the_order_are_told():
    rows = pair([200.0] * 8)
    rows[0] |= {"verdict": "unsolved", "residual": 1.0, "time_limit": 1.0}
    run = run_of(*rows)
    assert first(run).orders == {1: ["a", "b"], 2: ["a", "b"], 10: ["a", "b"]}
    rows[1] |= {"verdict": "unsolved", "residual": 1.0, "time_limit": 1.0}
    run = run_of(*(row | {"time_limit": 40.0} for row in rows))
    assert first(run).orders[1] == ["a", "b"]
    assert first(run).orders[10] == ["b", "a"]
    (line,) = headline({one.rank_by: choice.choices(one) for one in (run, run.ranked_by(RankBy.FORM))}, 1e-8)
    assert "Other charges for what is not solved change the first three: by PAR10 b, then a." in line


def test_what_cannot_be_judged_is_counted_apart():
    """Of three answers within the target one is within its own rounding errors only."""
    rows = [solve_row("a", f"p{i}", residual=1e-9, residual_floor=1e-10) for i in range(3)]
    rows[2] |= {"residual_floor": 6.4e-5, "verdict": "unjudgeable"}
    run = run_of(*rows)
    assert first(run).places[0].solved == "2 + 1 unjudgeable"
    assert run.times[1e-8]["unjudgeable"].tolist() == [False, False, True]
    assert tables.reliabilities(run).loc[0, ["exact", "unjudgeable"]].tolist() == [2, 1]
    assert accuracy.times_to(run.ranked, 1e-4)["reached"].all()


def test_infeasible_problems_and_several_outcomes():
    rows = pair([1.5] * 8)
    found = run_of(*rows).rows
    found["infeasible"] |= found["problem"] == "p0"
    found["several_outcomes"] |= found["problem"].isin(["p1", "p2"])
    run = replace(run_of(*rows), rows=found)
    assert {kind.name: kind.problems for kind in choice.choices(run)} == {PLANE: 7, f"{PLANE}, one outcome": 5}
    told = "Left out of all rankings: 1 proved infeasible; rankings of one outcome also leave out 2 problems of the 7, with "
    assert tables.exclusions(run).startswith(told)


def test_infeasible_and_outcomes_are_read_from_their_columns():
    given = table("solves", pair([1.5] * 4)).assign(
        proved_infeasible=[True, None, None, None] * 2, outcome_distance=[0.0, 0.5, 0.0, None] * 2
    )
    rows = annotate(given).drop_duplicates("problem_id")
    assert rows[["infeasible", "several_outcomes"]].to_numpy().tolist() == [[True, False], [False, True], *[[False, False]] * 2]


def test_percentiles_and_budget_by_hand(tmp_path):
    """A motion of a hundred steps of 1 to 100 ms, of which the last is not solved."""
    rows = [solve_row("a", f"p{i}", step=i, form_time=0.0, setup_time=0.0, solve_time=1e-3 * (i + 1)) for i in range(100)]
    rows[99] |= {"residual": 1.0, "verdict": "unsolved"}
    run = run_of(*rows)
    table = accuracy.percentiles(accuracy.overall(run.times[1e-8])[PLANE], 40e-3).loc["a"]
    assert table.tolist() == pytest.approx([50e-3, 99e-3, np.inf, 0.4])
    few = accuracy.percentiles(accuracy.overall(run_of(*rows[:99]).times[1e-8])[PLANE])
    assert np.isnan(few.loc["a", "p99"])  # of fewer than a hundred it would be the longest, which stands beside it
    (motion,) = motions(read_run(write_folder(tmp_path / "run", rows), budget=40e-3))
    assert (motion.problems, motion.table.loc["a", "p99"]) == (100, pytest.approx(99e-3))
    page = write_report(tmp_path / "run", read_run(tmp_path / "run", budget=40e-3)).read_text(encoding="utf-8")
    assert all(each in page for each in ("within 40 ms", "100 problems of a motion", "; dashed: the budget of 40 ms</h3>"))
    assert "budget" not in steps.CHART.caption
    # every step counts the same in a motion, every stratum in a mean over problems
    two = [row | {"contacts": 20} for row in rows[:50]] + rows[50:99]
    times = accuracy.overall(run_of(*two).times[1e-8])[PLANE]
    assert accuracy.percentiles(times, 25e-3)["within"].item() == pytest.approx(0.25)
    assert accuracy.percentiles(times, 25e-3, weighted=False)["within"].item() == pytest.approx(25 / 99)


def test_durations():
    assert [parse_duration(text) for text in ("1ms", "250us", "250 µs", "0.5s")] == pytest.approx([1e-3, 250e-6, 250e-6, 0.5])
    for text in ("1", "ms", "-1ms", "0ms", "1 min", "nan s"):
        with pytest.raises(typer.BadParameter, match="is not a time with a unit"):
            parse_duration(text)


def test_advice_by_both_rankings():
    a, b = ({"variant": name, "verdict": "solved", "residual": 0.0} for name in "ab")
    a |= dict(zip(TIMES, (1e-4, 0.0, 1e-3), strict=True))
    b |= dict(zip(TIMES, (2e-3, 0.0, 5e-4), strict=True))
    told = "1.1 ms; 1 other solves it as well; from the method's own form b is faster: 500 µs"
    assert advice([a, b]) == f"fastest on this problem: a, from bodies in {told}"
    assert advice([b, a], RankBy.FORM).startswith("fastest on this problem: b, from the method's own form in 500 µs")
    skipped = [{"variant": f"{name}[x=1]", "solver": name, "reason": f"{name} takes no joints"} for name in "ab"]
    assert refusals(skipped) == ["not applicable to this problem: a[x=1], b[x=1]: takes no joints"]


def test_another_law_and_a_polygon_are_told_apart(tmp_path):
    found = [law(*what) for what in (("coulomb", 3), ("lcp", 2), ("lcp", 3), ("relaxation", 2), ("regularised", 3))]
    assert found == ["", "", POLYGON, ANOTHER_LAW, ANOTHER_LAW]
    assert [ending("relaxed", model) for model in ("lcp", "relaxation")] == [POLYGON, ANOTHER_LAW]
    rows = [solve_row("exact", f"p{i}", dimension=3, scene=f"s{i}", solve_time=1.0) for i in range(8)]
    for name, model, error in (("facets", "lcp", 1e-2), ("soft", "regularised", 3e-1)):
        relaxed = {"dimension": 3, "model": model, "residual": error, "verdict": "relaxed"}
        rows += [solve_row(name, f"p{i}", scene=f"s{i}", **relaxed) for i in range(8)]
        for row in rows[-7:]:  # where nothing slides the law is the same, or most of the time is charged
            row |= {"residual": 1e-9, "verdict": "solved"}
    run = run_of(*rows)
    table = tables.solvability(run).set_index("label")
    assert table[[POLYGON, ANOTHER_LAW]].to_numpy().tolist() == [[0, 0], [1, 0], [0, 1]]
    assert table["error"].dropna().to_dict() == {"facets": 1e-2, "soft": 3e-1}
    laws = {one.label: one.law for one in first(run, "in space").places}
    assert laws == {"exact": "", "facets": POLYGON, "soft": ANOTHER_LAW}
    page = write_report(write_folder(tmp_path / "run", rows)).read_text(encoding="utf-8")
    assert "polygon, error 1e-2" in page
    assert "another law, error 3e-1" in page
    assert [place.label for place in first(run, "in space").places] == ["exact", "facets", "soft"]  # no mean but of a few
    assert np.isnan(first(run, "in space").places[1].mean)


def test_plane_and_space_are_ranked_apart():
    plane = [solve_row(name, f"p{i}", scene=f"s{i}", solve_time=t) for name, t in (("a", 1e-3), ("b", 2e-3)) for i in range(8)]
    space = [row | {"dimension": 3, "problem": f"{row['problem']}d"} for row in plane]
    space = [row | {"solve_time": 3e-3 - row["solve_time"], "key": f"{row['key']}d"} for row in space]
    run = run_of(*plane, *space)
    assert [(one.orders[1][0], one.unclear) for one in (first(run), first(run, "in space"))] == [("a", ""), ("b", "")]
    lines = headline({one.rank_by: choice.choices(one) for one in (run, run.ranked_by(RankBy.FORM))}, 1e-8)
    assert [line.partition(",")[0] for line in lines] == ["In the plane", "In space"]
    assert set(run.summaries[1e-8]["problem_class"]) >= {"in the plane", "in space"}
