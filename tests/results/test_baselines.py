"""Baselines as text, acknowledged changes, and histories of runs."""

import json

import pytest

from frictionbench.reports.comparison import history as runs_over_time
from frictionbench.reports.comparison.markdown import markdown
from frictionbench.results import cells, known
from frictionbench.results.changes import Flip
from frictionbench.results.compare import accept, compare
from frictionbench.results.files import ResultsError
from frictionbench.results.schema import SCHEMA_VERSION
from tests.helpers.made_results import SETTINGS, simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.paths import ROOT

SMOKE = ROOT / "results" / "baselines" / "smoke.tsv"


def run(folder, pivots=10, verdict="solved", **manifest):
    solved = [solve_row("a", f"p{i}", work=json.dumps({"pivots": pivots, "restarts": 0})) for i in range(3)]
    return write_folder(
        folder,
        [*solved, solve_row("b", "p", verdict=verdict), unanswered_row("c", "p", "skipped")],
        [simulation_row("a")],
        **manifest,
    )


def test_baseline_equals_its_run(tmp_path):
    made, path = run(tmp_path / "run"), tmp_path / "baselines" / "made.tsv"
    before, told = accept(made, path)
    assert (before, told) == (None, f"accepted: {path}, 6 cells: 5 solved, 1 skipped")
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[:3] == [f"# schema: {SCHEMA_VERSION}", "# suite: made", "# tolerances: 1e-08 0.0001"]
    assert lines[5] == "# cells: 6"
    assert lines[8:] == sorted(lines[8:])
    (tmp_path / "windows.tsv").write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert compare(tmp_path / "windows.tsv", made).exit_code == 0
    assert (
        "a\tsolve\tbar[friction=0.2]\t0\tstep\tcold\t1e-08\tsolved\t1.0e-09\tpivots 10, restarts 0\t3e-03\t10\ta-p0-1e-08"
        in lines
    )
    same, worse = compare(path, made), compare(path, run(tmp_path / "after", pivots=11, verdict="wrong"))
    assert (same.exit_code, same.counts["same"]) == (0, 5)
    assert [found.name for found in worse.worse] == ["bar[friction=0.2] step 0 to 1e-08 (b-p-1e-08)", "pivots"]
    before, _ = accept(tmp_path / "after", path)
    assert before.worse == worse.worse
    assert compare(path, tmp_path / "after").exit_code == 0


def test_other_files_are_not_overwritten(tmp_path):
    made, path = run(tmp_path / "run"), tmp_path / "notes.tsv"
    path.write_text("my notes", encoding="utf-8")
    with pytest.raises(ResultsError, match=r"notes\.tsv: neither a baseline"):
        accept(made, path)
    assert path.read_text(encoding="utf-8") == "my notes"
    accept(made, tmp_path / "good.tsv")
    text = (tmp_path / "good.tsv").read_text(encoding="utf-8")
    for spoilt, told in (
        (text + "a\tb\n", r"spoilt\.tsv:15: 2 columns"),
        (text.replace("1.0e-09", "2.0e-09"), "was changed after `frictionbench compare --accept` wrote it; restore it"),
        (text.replace("# suite: made", "# suite: other"), "was changed after"),
        (text.rpartition("a\t")[0], "has 3 cells, but its head states 6; restore it"),
        ("\n".join(text.split("\n")[:10]), "has 2 cells, but its head states 6"),
        (text.replace("# cells: 6", "# cells: 5"), "has 6 cells, but its head states 5"),
        ("".join(line for line in text.splitlines(keepends=True) if "sha256" not in line), "neither a baseline"),
        (
            text.replace(f"# schema: {SCHEMA_VERSION}\n", ""),
            "schema version 1",
        ),
    ):
        (tmp_path / "spoilt.tsv").write_text(spoilt, encoding="utf-8")
        with pytest.raises(ResultsError, match=told):
            cells.read(tmp_path / "spoilt.tsv")
    with pytest.raises(ResultsError, match="the run is not finished"):
        accept(run(tmp_path / "broken", finished=""), tmp_path / "other.tsv")


def test_incomparable_runs_are_not_accepted(tmp_path):
    accept(run(tmp_path / "run"), path := tmp_path / "made.tsv")
    text = path.read_bytes()
    other = run(tmp_path / "other", settings=SETTINGS | {"suite": "another"})
    with pytest.raises(ResultsError, match=r"made\.tsv: the runs differ in their suite; delete the file"):
        accept(other, path)
    skipped = write_folder(tmp_path / "skipped", [unanswered_row("a", "p", "skipped")])
    for folder, baseline in ((skipped, path), (skipped, tmp_path / "new.tsv")):
        with pytest.raises(ResultsError, match="cannot be a baseline: no cell was measured"):
            accept(folder, baseline)
    assert (path.read_bytes(), (tmp_path / "new.tsv").exists()) == (text, False)


def test_suites_of_others_name_no_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = run(tmp_path / "run", settings=SETTINGS | {"suite": "../made"})
    with pytest.raises(ResultsError, match="is not the name of a file"):
        accept(folder, None)
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_committed_baseline():
    smoke = cells.read(SMOKE)
    assert (smoke.suite, smoke.tolerances) == ("smoke", (1e-8, 1e-4))
    assert {"lemke", "nsgs", "interior_point"} <= set(smoke.measured["variant"])


KNOWN = """
[[known]]
solver = "a"
change = "pivots"
ratio = 1.2
reason = "a safer | step"

[[known]]
solver = "b"
change = "verdict"
after = "wrong"
reason = "under repair"

[[known]]
solver = "b"
change = "time"
ratio = 2
reason = "gone by"
"""


def test_acknowledged_changes_pass(tmp_path):
    (tmp_path / "known.toml").write_text(KNOWN, encoding="utf-8")
    acknowledged, before = known.read(tmp_path / "known.toml"), run(tmp_path / "before")
    result = known.acknowledge(compare(before, run(tmp_path / "after", 12, "wrong")), acknowledged)
    assert (result.exit_code, result.counts["acknowledged"]) == (0, 2)
    text = markdown(result)
    assert "`acknowledged: a safer \\| step`" in text
    assert "Acknowledged change not found; delete its entry: b, time." in text
    further = known.acknowledge(compare(before, run(tmp_path / "further", 13, "crashed")), acknowledged)
    assert [found.after if isinstance(found, Flip) else found.name for found in further.worse] == ["crashed", "pivots"]


@pytest.mark.parametrize("change", ["gone", "skipped", "new", "pivots"])
def test_acknowledged_losses_pass(tmp_path, change):
    ratio = "ratio = inf" if change == "pivots" else ""
    (tmp_path / "known.toml").write_text(
        f"[[known]]\nsolver = 'b'\nchange = '{change}'\n{ratio}\nreason = 'x'", encoding="utf-8"
    )
    kept, solved = solve_row("a", "p"), solve_row("b", "p", work='{"pivots": 3}')
    after = {"gone": [], "skipped": [unanswered_row("b", "p", "skipped")], "pivots": [solve_row("b", "p")]}
    pair = (
        ([kept], [kept, solve_row("b", "p", verdict="wrong")]) if change == "new" else ([kept, solved], [kept, *after[change]])
    )
    folders = [write_folder(tmp_path / name, rows) for name, rows in zip(("before", "after"), pair, strict=True)]
    result = compare(*folders)
    assert result.exit_code == 1
    result = known.acknowledge(result, known.read(tmp_path / "known.toml"))
    assert (result.exit_code, result.counts["acknowledged"], result.notes) == (0, 1, ())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("known = 3", "known: Input should be a valid list"),
        ("[[known]]\nsolver = 3", "known 1 solver: Input should be a valid string"),
        ("[[known]]\nsolver = 'a'\nchange = 'time'\nreason = 'x'", "known 1: .*ratio is missing"),
        ("[[known]]\nsolver = 'a'\nchange = 'time'\nreason = 'x'\nratio = nan", "known 1 ratio: Input should be greater"),
        ("[[known]]\nsolver = 'a'\nchange = 'verdict'\nreason = 'x'\nratio = -1", "known 1 ratio: Input should be greater"),
        ("[[known]]\nsolver = 'a'\nchange = 'gone'", "known 1 reason: Field required"),
        ("[[known]]\nsolver = 'a'\nchange = 'gone'\nreason = 'x'\ncolour = 'a'", "known 1 colour: Unexpected keyword argument"),
        ("[[", "cannot be read"),
    ],
)
def test_unreadable_acknowledged_changes(tmp_path, text, told):
    (tmp_path / "known.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ResultsError, match=told):
        known.read(tmp_path / "known.toml")


def test_history_uses_common_cells(tmp_path):
    first = run(tmp_path / "first", finished="2026-01-02T00:00")
    second = run(tmp_path / "second", 20, "wrong", finished="2026-01-01T00:00")
    accept(first, tmp_path / "made.tsv")
    told = runs_over_time.history(runs_over_time.lines([first, second, tmp_path / "made.tsv"]))
    lines = [line.replace("|", " ").split() for line in told.splitlines()]
    assert [(line[0], line[1]) for line in lines if "pivots" in line][:2] == [("a", str(second)), (str(first), "2026-01-02")]
    assert [line[line.index("pivots") + 1] for line in lines if "pivots" in line] == ["60,", "30,", "30,"]
    assert sum("wrong" in line for line in lines) == 1
