"""The numbers of the report on tables small enough to check by hand, and its page for various folders."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from markupsafe import Markup

from frictionbench.reports import accuracy, choice, tables
from frictionbench.reports.charts import CHARTS, MAPS, growth, pareto, speed_accuracy, steps
from frictionbench.reports.drawing.files import save_sheet
from frictionbench.reports.markdown import write_markdown
from frictionbench.reports.page import view, write_report
from frictionbench.reports.paper import write_paper
from frictionbench.reports.printed import printed
from frictionbench.reports.run import Run, annotate, annotate_simulations, outcomes, read_run
from frictionbench.reports.tables import hard_shares, reliabilities, sentences
from frictionbench.reports.templates import environment
from frictionbench.results.conventions import ENDINGS
from frictionbench.results.histories import ConvergenceHistory, write_histories
from frictionbench.results.schema import SOLVES, arrow_schema
from tests.helpers.browser import browse, in_browser
from tests.helpers.made_results import simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.page import Page, digest, with_more_script

PLANE = "in the plane"


def table(name, rows):
    return pa.Table.from_pylist(list(rows), arrow_schema(name)).to_pandas()


def annotated(*rows):
    return annotate(table("solves", rows))


def run_of(*rows):
    settings = {"plugins": [{"source": "mine.py", "solvers": {"a": {}}}]}
    return Run({"settings": settings}, annotated(*rows), annotate_simulations(table("simulations", [])))


def by_label(table, problem_class="bar"):
    return table[table["problem_class"] == problem_class].set_index("label")


def test_least_time_within_target():
    rows = annotated(
        solve_row("a", "p", 1e-4, residual=5e-5, form_time=0.0, setup_time=0.0, solve_time=1.0),
        solve_row("a", "p", 1e-6, residual=9e-9, form_time=0.2, setup_time=0.3, solve_time=1.5),
        solve_row("a", "p", 1e-8, residual=1e-9, form_time=0.2, setup_time=0.3, solve_time=2.5),
    )
    found = {target: accuracy.times_to(rows, target).iloc[0] for target in accuracy.TARGETS}
    assert [row["charged"] for row in found.values()] == [1.0, 2.0, 2.0]
    assert found[1e-8][["form_time", "setup_time", "solve_time"]].tolist() == [0.2, 0.3, 1.5]
    claim = annotated(solve_row("a", "p", 1e-8, verdict="wrong", residual=1e-5))  # counts at its accuracy
    assert [accuracy.times_to(claim, target)["reached"].item() for target in (1e-4, 1e-6)] == [True, False]


@pytest.mark.parametrize(
    "miss",
    [
        solve_row("a", "q", verdict="wrong", residual=1e-3, solve_time=1e-6),
        solve_row("a", "q", verdict="relaxed", residual=1e-3),
        solve_row("a", "q", verdict="unsolved", claimed=False, residual=float("inf")),
        solve_row("a", "q", verdict="timeout", residual=1e-12, solve_time=11.0),
        unanswered_row("a", "q", "crashed"),
        unanswered_row("a", "q", "skipped"),
    ],
    ids=lambda row: row["verdict"],
)
def test_unsolved_is_charged_at_limit(miss):
    rows = annotated(solve_row("a", "p", form_time=0.0, setup_time=0.0, solve_time=0.1), miss)
    summary = by_label(accuracy.summary(accuracy.times_to(rows, 1e-8))).loc["a"]
    assert (summary["problems"], summary["reached"], summary["share"]) == (2, 1, 0.5)
    assert summary["mean"] == pytest.approx(np.sqrt(0.1 * 10), rel=1e-3)
    assert summary["solve"] == 0.1


def test_skipped_class_has_no_value():
    rows = annotated(solve_row("a", "p"), unanswered_row("b", "p", "skipped"), unanswered_row("c", "p", "crashed"))
    assert accuracy.times_to(rows, 1e-8)["label"].tolist() == ["a", "c"]
    some = accuracy.times_to(annotated(solve_row("b", "p"), unanswered_row("b", "q", "skipped")), 1e-8)
    assert (some["skipped"].tolist(), some["charged"].notna().all()) == ([False, True], True)


def test_problems_that_are_not_ranked_are_counted():
    run = run_of(solve_row("a", "p"), solve_row("a", "q", trivial=True), solve_row("a", "r", verdict="wrong", trivial=True))
    assert run.summaries[1e-8]["problems"].tolist() == [1, 1]
    row = tables.solvability(run).iloc[0]
    assert (row["cells"], row["left_out"], row["solved"], row["wrong"]) == (1, 2, 1, 0)
    assert view(run)["claims"]["problem"].tolist() == ["r"]
    run = run_of(solve_row("a", "p"), solve_row("a", "q", contacts=None), unanswered_row("a", "", "skipped", contacts=None))
    assert tables.exclusions(run) == "Left out of all rankings: 1 that cannot be read or made, 1 given as an LCP."
    assert run.ranked["problem"].tolist() == ["p"]


def test_solvability_counts_every_verdict():
    verdicts = ("solved", "relaxed", "near_miss", "unjudgeable", "wrong", "unsolved")
    answers = [solve_row("a", v, verdict=v, claimed=v != "unsolved") for v in verdicts]
    lost = [unanswered_row("a", v, v) for v in ("timeout", "crashed", "skipped")]
    row = tables.solvability(run_of(*answers, *lost)).iloc[0]
    assert (row["cells"], row["claimed"]) == (9, 5)
    assert all(row[ending] == (ending != "polygon") for ending in ENDINGS)


def test_sizes_of_a_scene_are_separate():
    sizes = {"p": 8, "q": 99, "r": 100, "s": 1000}
    rows = annotated(
        *(solve_row("a", name, size=n, parameters=f'{{"blocks": {n}}}') for name, n in sizes.items()),
        unanswered_row("b", "s", "skipped", size=None, parameters='{"blocks": 1000}'),
        solve_row("a", "t", scene="rod", size=5000),
    )
    classes = rows["problem_class"].tolist()
    assert classes == ["bar, n < 100"] * 2 + ["bar, n < 1000", "bar, n from 1000", "bar, n from 1000", "rod"]


def assert_only_our_script_runs(path: Path, page: Page) -> None:
    (ours,) = page.scripts[""]
    assert ours == environment().globals["script"]("cards.js", "page.js")[0]
    assert f"script-src {digest(ours)}" in path.read_text(encoding="utf-8")
    assert page.scripts.keys() <= {"", "application/json"}
    for data in page.scripts["application/json"]:
        json.loads(data)


RUN = [
    *(
        solve_row("nsgs", f"p{i}", tol, contacts=n, size=4 * n, rank=rank)
        for i, (n, rank) in enumerate(((2, 4), (4, 8), (8, 8)))
        for tol in (1e-4, 1e-8)
    ),
    solve_row("lemke", "p0", residual=0.0, model_residual=0.0),
    solve_row("lemke", "p1", verdict="wrong", residual=0.3, key="cell with 'quotes'; and a blank"),
    solve_row("ccp", "p0", model="relaxation", verdict="relaxed", residual=1e-3, model_residual=1e-9),
    unanswered_row("nsgs", "p9", "timeout", rank=2),
    unanswered_row("path", "p0", "skipped"),
]
for _row in RUN[:-2]:
    _row |= {"sensitivity": 2.0, "backward_error": 1e-9, "work": '{"iterations": 3}'}


def test_page_is_complete_and_self_contained(tmp_path):
    torn = unanswered_row(
        "nsgs", "", "skipped", scene="Chain", parameters='{"file": "torn.dat"}', contacts=None, dimension=None
    )
    simulations = [simulation_row("nsgs"), simulation_row("ccp", energies=[2.0, 2.1, 2.3])]
    folder = write_folder(tmp_path / "run", [*RUN, torn], simulations)
    path = write_report(folder)
    page = Page(path)
    sections = ("Recorded problems", "At a glance", "Solvability", "Speed and accuracy", "Time to equal accuracy", "Energy in")
    least = "In the plane, 4 problems, to a verified residual of 1e-8: nsgs solves "
    again = f"frictionbench rerun {tmp_path / 'run'} 'cell with '\"'\"'quotes'\"'\"'; and a blank'"
    for part in (*sections, least, again, "no problem: for a reason", "1 wrong claim", "energy gained"):
        assert part in page.text
    assert "has not finished" not in page.text
    assert page.count["main"] == 1
    drawings = re.findall(r"<svg[^>]*>", path.read_text(encoding="utf-8"))
    assert [drawing for drawing in drawings if "aria-label=" not in drawing and "aria-hidden=" not in drawing] == []
    ids = re.findall(r' id="(\w[^"]*)"', path.read_text(encoding="utf-8"))
    assert len(ids) == len(set(ids)) > len(drawings) / 2 > 0
    assert not page.count.keys() & {"link", "iframe", "object", "form"}
    assert_only_our_script_runs(path, page)
    assert all(reference[1:] in ids or reference.startswith("data:image/png") for reference in page.references)


@pytest.mark.parametrize(
    ("solves", "simulations"),
    [
        ([], []),
        ([], [simulation_row("a", energies=[], times=[]), simulation_row("b", energies=None, times=None, energy_scale=None)]),
        ([solve_row("a", "p", trivial=True)], []),
        ([unanswered_row("a", "p", "skipped", size=None, contacts=None, dimension=None, condition=None)], []),
        ([solve_row("a", "p", residual=float("inf"), verdict="unsolved")], []),
        ([solve_row("a", "p")], [simulation_row("a", energies=[1.0, float("inf"), float("nan")])]),
        ([solve_row("a", "p", disturbed=True)], [simulation_row("a", times=[float("nan")] * 3)]),
    ],
    ids=["nothing", "simulations alone", "trivial", "skipped", "no residual", "one solver", "no finite time"],
)
def test_partial_run_page(tmp_path, solves, simulations):
    write_folder(tmp_path, solves, simulations)
    (tmp_path / "manifest.json").write_text('{"schema": 3, "settings": {}}')
    page = Page(write_report(tmp_path))
    assert "has not finished" in page.text
    assert "Known limitations" in page.text
    assert ("Most times are disturbed" in page.text) == any(row.get("disturbed") is True for row in solves)
    assert ("No answer is claimed as solved yet" in page.text) == (not any(row["claimed"] for row in solves))
    assert write_paper(tmp_path, read_run(tmp_path)).is_dir()


def test_untrusted_text_is_escaped(tmp_path):
    markup = '_<script>alert(1)</script>$x^{" onload="alert(1)"&\x00\x1b\u202e&#60; {{ 7 * 7 }}'
    texts = [column.name for column in SOLVES if str(column.type) == "string"]
    row = solve_row("a", "p") | dict.fromkeys(texts, markup) | {"verdict": "wrong", "start": "warm"}
    simulation = simulation_row("a") | dict.fromkeys(("scene", "parameters", "variant", "scheme", "reason", "key"), markup)
    manifest = {"machine": {markup: markup}, markup: {markup: [markup]}}
    rows = [row | {"parameters": markup}, row | {"key": "b", "scene": "c"}]
    path = write_report(write_folder(tmp_path, rows, [simulation], **manifest))
    page = Page(path)
    assert_only_our_script_runs(path, page)
    assert page.handlers == []
    assert "alert(1)" in page.text
    assert "{{ 7 * 7 }}" in page.text
    assert "&lt;script&gt;" in path.read_text(encoding="utf-8")
    sheet = (write_paper(tmp_path, read_run(tmp_path)) / "speed_accuracy.svg").read_text(encoding="utf-8")
    assert "<script" not in sheet
    assert "&lt;script&gt;" in sheet


def test_figures_are_deterministic(tmp_path):
    runs = {name: run_of(*RUN) for name in "ab"}
    for name, run in runs.items():
        save_sheet(speed_accuracy.panels(run), run.looks, tmp_path / name)
    assert str(speed_accuracy.panels(run_of(solve_row("a", "p")))[0].dots).endswith("rerun DIR a-p-1e-08 --solver mine.py']}")
    assert all((tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes() for kind in ("svg", "pdf"))
    rows = [solve_row(name, "p", work='{"pivots": 3}', members=of) for name, of in (("a", ""), ("b", "c"))]
    assert CHARTS["work"].panels(run_of(*rows)) == []  # b is a portfolio, and a alone has no other to be compared with


@pytest.mark.slow  # every chart drawn on the page and for the paper: a chart that fails in one of the two
def test_charts_on_page_and_in_paper(tmp_path):
    given = {"contacts": 20, "size": 80, "rank": 40, "work": '{"iterations": 3}'}
    larger = [solve_row("nsgs", f"larger {i}", tol, **given) for i in range(2) for tol in (1e-4, 1e-8)]
    folder = write_folder(tmp_path, [*RUN, *larger], [simulation_row("nsgs")])
    history = ConvergenceHistory("bar", "{}", 0, "nsgs", 2, [1, 2], [1.0, 1e-9])
    write_histories(folder, [history])
    page, paper = Page(write_report(folder)), write_paper(folder, read_run(folder))
    run = read_run(folder)
    drawn = [chart for chart in CHARTS.values() if chart.panels(run)]
    assert [chart for chart in CHARTS.values() if chart not in drawn] == [*MAPS, steps.CHART]
    files = {f"{chart.name}.{kind}" for chart in drawn for kind in ("svg", "pdf")}
    assert {file.name for file in paper.iterdir() if file.suffix in (".svg", ".pdf")} == files
    assert page.count["figure"] == sum((1 + chart.ranked) * len(chart.panels(run)[chart.on_page]) for chart in drawn)
    for chart in drawn:
        assert chart.title in page.text
        assert Markup(chart.caption).striptags() in page.text


def test_which_solver_by_hand():
    def entry(name, *times):
        return [
            solve_row(name, f"p{i}", solve_time=t, contacts=c) for i, (t, c) in enumerate(zip(times, (2, 2, 50), strict=True))
        ]

    rows = [*entry("a", 1e-3, 1e-3, 1.0), *entry("b", 4e-3, 4e-3, 1e-2)]
    rows += entry("c", 1e-6, 1e-6, 1e-6)[:2]  # the fastest, but it did not run on every problem
    rows += [unanswered_row("c", "p2", "skipped", contacts=50)]
    found = {kind.name: kind.choices[1e-8] for kind in choice.choices(run_of(*rows))}
    assert {name: one.orders[1] for name, one in found.items()} == {
        "in the plane": ["b", "a", "c"],
        "in the plane, up to 10 contacts": ["c", "a", "b"],
        "in the plane, 11 to 100 contacts": ["b", "a", "c"],
    }
    small = found["in the plane, up to 10 contacts"]
    assert (small.places[0].reached, small.problems, small.interval, small.unclear) == (2, 2, None, "too few to rank")
    # with the shift and the millisecond of form and setup
    assert small.lead == pytest.approx((2e-3 + 1e-5 - 1e-5) / (1.001e-3), rel=1e-12)


def test_pareto_front_and_the_means_in_it_of_solvers_of_all_problems():
    time, residual = np.array([1.0, 2.0, 3.0, 2.0]), np.array([1e-2, 1e-6, 1e-6, 1e-8])
    assert pareto.front(time, residual).tolist() == [0, 3]
    rows = [solve_row("a", "p"), solve_row("a", "q"), solve_row("b", "p"), unanswered_row("b", "q", "skipped")]
    assert pareto.means(run_of(*rows).ranked)["label"].tolist() == ["a"]


HANDS = """
const seen = [];
const faint = () => document.querySelectorAll("g.faint").length;
const [chip] = document.querySelectorAll("button[data-label]");
seen.push(chip.disabled, document.getElementById("rest") !== null, faint());
chip.click(); seen.push(chip.getAttribute("aria-pressed"), document.getElementById("rest") !== null, faint() > 0);
chip.click(); seen.push(chip.getAttribute("aria-pressed"), faint());
const table = [...document.querySelectorAll("table.sorts")].find((each) => each.rows[0].cells[1].textContent === "cells");
const claimed = table.rows[0].cells[1];
for (const way of ["up", "down"]) {
  claimed.click(); seen.push(claimed.getAttribute("aria-sort"), table.querySelector("td").textContent.trim());
}
const dot = document.querySelector("g[data-dots] use");
dot.dispatchEvent(new PointerEvent("pointerenter")); seen.push(note.hidden, note.textContent.includes("frictionbench rerun"));
dot.dispatchEvent(new PointerEvent("pointerleave")); seen.push(note.hidden);
const shut = () => document.querySelectorAll("details:not([open], .raw)").length;
const before = shut();
dispatchEvent(new Event("beforeprint")); seen.push(before > 0, shut());
dispatchEvent(new Event("afterprint")); seen.push(shut() === before);
seen.push(table.tHead.rows.length, table.tBodies[0].querySelector("th") === null);  // printed on each page
document.documentElement.dataset.seen = seen.join(" ");
"""


@in_browser
def test_page_controls(tmp_path):
    families = ("odd", "even")
    rows = [solve_row(f"s{i}", f"p{k}", solve_time=1e-3 * (i + 1), family=families[i % 2]) for i in range(12) for k in (0, 1)]
    rows += [solve_row("s0", "p9", residual=1.0, verdict="unsolved", claimed=False, reason="stalled")]  # a folded part
    path = write_report(write_folder(tmp_path / "run", [*rows, *(solve_row("s0", f"p{k}") for k in range(2, 9))]))
    with_more_script(path, HANDS)
    (opening,) = re.findall(r"<html[^>]*>", browse(path, "--dump-dom"))
    wanted = "false true 0 true false true false 0 ascending s1 descending s0 false true true true 0 true 1 true"
    assert f'data-seen="{wanted}"' in opening


def test_common_denominator():
    """Ten problems, four of them of a class that b is skipped on; warm starts are judged by the three that have one."""
    names = [(scene, f"{scene}{i}") for scene, n in (("bar", 6), ("rod", 4)) for i in range(n)]
    rows = [solve_row("a", name, scene=scene, solve_time=4e-3) for scene, name in names]
    rows += [solve_row("b", name, scene=scene) for scene, name in names[:6]]
    rows += [unanswered_row("b", name, "skipped", scene=scene) for scene, name in names[6:]]
    rows += [solve_row("a", name, scene=scene, start="warm", key=f"warm {name}") for scene, name in names[:3]]
    run = run_of(*rows)
    shares = by_label(run.summaries[1e-8], PLANE)["share"]
    profiles = accuracy.profiles(accuracy.overall(run.times[1e-8])[PLANE])
    reached = {label: profile.share(np.array([1e9]))[0] for label, profile in profiles.items()}
    assert reached == pytest.approx(shares.to_dict())
    assert reached == pytest.approx({"a": 1.0, "b": 0.5, "a, warm": 1.0})  # each scene has half of the weight
    (times,) = [table for table in printed(run) if table.name == "times"]
    assert {row[0]: row[1] for row in times.rows} == {"a": "10/10", "b": "6/10, 4 not run", "a, warm": "3/3"}


def test_growth_exponent_by_hand():
    sizes = np.array([10.0, 20.0, 50.0, 100.0])
    assert growth.exponent(sizes, 3e-6 * sizes**1.5) == pytest.approx((1.5, 0.0), abs=1e-12)
    slope, error = growth.exponent(sizes, 3e-6 * sizes**1.5 * np.array([1.1, 0.9, 1.1, 0.9]))
    assert abs(slope - 1.5) < 2 * error < 0.5
    assert np.isnan(growth.exponent(sizes[:2], sizes[:2])[0])


def test_accuracy_by_hand(tmp_path):
    """Two problems: one solver solves both, one only its own model, one claims falsely once, one crashes once."""
    rows = [solve_row(name, problem, version="ours") for name in "ab" for problem in "pq"]
    rows += [solve_row("soft", problem, model="relaxation", residual=0.1, verdict="relaxed") for problem in "pq"]
    rows += [solve_row("false_claims", "p", version="lib 2")]
    rows += [solve_row("false_claims", "q", version="lib 2", residual=0.1, model_residual=0.1, verdict="wrong")]
    rows += [solve_row("weak", "p"), unanswered_row("weak", "q", "crashed")]
    folder = write_folder(tmp_path / "run", [{"version": "ours"} | row for row in rows], versions={"frictionbench": "ours"})
    run = read_run(folder)
    assert [(one.label, one.exact, one.own, one.wrong, one.crashed) for one in reliabilities(run).itertuples()] == [
        ("a", 2, 2, 0, 0),
        ("b", 2, 2, 0, 0),
        ("false_claims", 1, 1, 1, 0),
        ("weak", 1, 1, 0, 1),
        ("soft", 0, 2, 0, 0),
    ]
    for_another_law = "for another law, the convex relaxation or soft contact, median error in brackets"
    assert dict(sentences(run)) == {
        "Solve every problem that they accept to 1e-8": "a; b",
        f"Solve every problem that they accept to 1e-8 {for_another_law}": "soft (1e-1)",
        "Wrong claims, with a residual above ten times the tolerance": "false_claims (1 of 2 problems to 1e-8)",
        "Crashed": "weak (1 of 2 problems to 1e-8)",
    }
    space = [solve_row("a", "s", dimension=3), unanswered_row("b", "s", "timeout", dimension=3)]
    assert dict(sentences(run_of(*rows, *space)))["Solve every problem that they accept to 1e-8"] == "a; b (in the plane)"
    told = write_markdown(folder, read_run(folder)).read_text(encoding="utf-8")
    assert "**Crashed**: weak (1 of 2 problems to 1e-8)." in told
    assert "| in the plane | 2 | a | 3 ms | 1.00 | too few to rank | 2 |" in told
    assert "Wrong claims, with a residual above ten times the tolerance" in write_report(folder).read_text(encoding="utf-8")


def test_untested_targets_are_not_missed(tmp_path) -> None:
    asked = [solve_row(name, problem, 1e-6, residual=1e-7) for name in ("a", "b") for problem in ("p", "q")]
    run = read_run(write_folder(tmp_path / "asked", asked))
    assert list(run.times) == [1e-6]
    assert all(times["reached"].all() for times in run.times.values())
    loose = read_run(write_folder(tmp_path / "loose", [row | {"tol": 1e-2} for row in asked]))
    assert list(loose.times) == [1e-4]
    assert "within 1e-8" not in write_report(tmp_path / "asked").read_text()


def test_outcomes_are_counted_by_problem() -> None:
    distances = {
        "one": [1e-9, 1e-12, 5e-4, np.nan],
        "two": [0.0, 0.3, 0.3 + 1e-9, np.nan],
        "three, one of them between": [0.05, 0.0, 0.3, 0.3001],
        "unknown": [np.nan] * 4,
        "enumerated": [0.0] * 4,
        "infinitely many": [0.0] * 4,
    }
    rows = pd.DataFrame({"problem": [*distances], "outcome_distance": [*distances.values()]}).explode("outcome_distance")
    rows = rows.reset_index(drop=True).astype({"outcome_distance": float})
    rows["outcomes"] = rows["problem"].map({"enumerated": 1.0})
    found = rows.assign(found=outcomes(rows)).drop_duplicates("problem")["found"]
    assert found.fillna(-1).tolist() == [1, 2, 3, -1, 1, 1]


HEAVY, LARGE = {"mass_ratio": 1e6}, {"contacts": 200}
ROWS = [
    solve_row("one", "a", **HEAVY),
    solve_row("one", "b", step=1, **HEAVY, **LARGE),
    solve_row("one", "c", step=2),
    solve_row("two", "a", verdict="wrong", residual=1.0, **HEAVY),
    solve_row("two", "b", step=1, **HEAVY, **LARGE),
    unanswered_row("two", "c", "timeout", step=2),
    unanswered_row("three", "a", "skipped", **HEAVY),
]


def test_shares_by_label(tmp_path) -> None:
    rows = [*ROWS, *(solve_row(name, "d", step=3, dimension=3, **HEAVY) for name in ("one", "four"))]
    found, space = hard_shares(read_run(write_folder(tmp_path, rows)))
    assert (space.where, space.problems["all"], set(space.table["label"])) == ("in space", 1, {"one", "four"})
    assert found.problems == {"all": 3, "masses": 2, "large": 1, "none of these": 1}
    table = found.table.set_index("label")
    assert list(table.index) == ["one", "two"]  # a solver that was skipped everywhere has no share
    assert table.loc["one"].to_list() == [1, 1, 1, 1]
    assert table.loc["two"].to_list() == pytest.approx([1 / 3, 1 / 2, 1, 0])
