"""Baselines as text, and histories of runs."""

import json

import pytest

from frictionbench.harness.dependencies import quoted
from frictionbench.reports.comparison.history import history
from frictionbench.results import baseline as baselines, cells
from frictionbench.results.compare import accept, compare
from frictionbench.results.files import ResultsError
from frictionbench.results.schema import SCHEMA_VERSION
from tests.helpers.made_results import SETTINGS, simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.paths import ROOT

SMOKE = ROOT / "results" / "baselines" / "smoke.tsv"


def run(folder, pivots=10, verdict="solved", **manifest):
    rows = [solve_row("a", f"p{i}", work=json.dumps({"pivots": pivots, "restarts": 0})) for i in range(3)]
    rows += [solve_row("b", "p", verdict=verdict), unanswered_row("c", "p", "skipped")]
    return write_folder(folder, rows, [simulation_row("a")], **manifest)


def test_baseline_equals_its_run(tmp_path):
    made, path = run(tmp_path / "run"), tmp_path / "baselines" / "made.tsv"
    assert accept(made, path) == (None, f"accepted: {path}, 6 cells: 5 solved, 1 skipped")
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[:3] == [f"# schema: {SCHEMA_VERSION}", "# suite: made", "# tolerances: 1e-08 0.0001"]
    assert lines[5] == "# cells: 6"
    assert lines[8:] == sorted(lines[8:])
    (tmp_path / "windows.tsv").write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert compare(tmp_path / "windows.tsv", made).exit_code == 0
    line = "a\tsolve\tbar[friction=0.2]\t0\tstep\tcold\t1e-08\tsolved\t1.0e-09\tpivots 10, restarts 0\t3e-03\t10\ta-p0-1e-08"
    assert line in lines
    same, worse = compare(path, made), compare(path, run(tmp_path / "after", 11, "wrong", finished="later"))
    assert (same.exit_code, same.counts["same"]) == (0, 5)
    assert (same.notes, worse.notes) == (("The baseline is this very run, which cannot be worse than itself.",), ())
    assert [found.name for found in worse.worse] == ["bar[friction=0.2] step 0 to 1e-8 (b-p-1e-08)", "pivots"]
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
        (text.replace(f"# schema: {SCHEMA_VERSION}\n", ""), "schema version 1"),
    ):
        (tmp_path / "spoilt.tsv").write_text(spoilt, encoding="utf-8")
        with pytest.raises(ResultsError, match=told):
            cells.read(tmp_path / "spoilt.tsv")
    with pytest.raises(ResultsError, match="the run is not finished"):
        accept(run(tmp_path / "broken", finished=""), tmp_path / "other.tsv")


@pytest.mark.parametrize(
    ("column", "value"),
    [("verdict", "great"), *(("limit", limit) for limit in ("", "nan", "inf", "-1")), ("work", "pivots nan")]
    + [("work", f"pivots {count}") for count in (-5, 10**30)],
)
def test_unknown_values_are_refused(column, value, tmp_path):
    """Also where the hash is that of the changed lines: they would turn a check off."""
    made, path = run(tmp_path / "run"), tmp_path / "made.tsv"
    accept(made, path)
    facts, rows = baselines.read(path)
    rows[0][1 + baselines.COLUMNS.index(column)] = value
    baselines.write(path, facts, [(*row[1:], row[0]) for row in rows])
    assert f"unknown {column} " in compare(path, made).unusable


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


def test_committed_baseline():
    smoke = cells.read(SMOKE)
    assert (smoke.suite, smoke.tolerances) == ("smoke", (1e-8, 1e-4))
    assert {"lemke", "nsgs", "interior_point"} <= set(smoke.measured["variant"])


def test_history_uses_common_cells(tmp_path):
    first = run(tmp_path / "first", finished="2026-01-02T00:00")
    second = run(tmp_path / "second", 20, "wrong", finished="2026-01-01T00:00")
    accept(first, tmp_path / "made.tsv")
    told = history([first, second, tmp_path / "made.tsv"])
    lines = [line.replace("|", " ").split() for line in told.splitlines()]
    assert [(line[0], line[1]) for line in lines if "pivots" in line][:2] == [("a", str(second)), (str(first), "2026-01-02")]
    sums = [line[line.index("pivots") - 1 : line.index("pivots") + 2] for line in lines if "pivots" in line]
    assert sums == [["4", "pivots", "60,"], *[["4", "pivots", "30,"]] * 2]
    assert sum("wrong" in line for line in lines) == 1


def test_names_with_the_separators_of_a_baseline(tmp_path):
    """Else what a plug-in loaded would be unknown, and a version of --code that lacks it would not be refused."""
    settings = SETTINGS | {"plugins": [{"source": "a.py", "solvers": {"a": {}, "a[file=c:x]": {}}}]}
    loaded = {quoted(name): quoted(name) for name in ("/x/a.py", "/x/t; 2.txt", "/x/t\n3: 4.txt")}
    content = {place: str(i) * 64 for i, place in enumerate(loaded.values())}
    accept(run(tmp_path / "run", settings=settings, loaded={"a.py": loaded}, content=content), tmp_path / "made.tsv")
    for path in "made.tsv", "run":
        known = cells.read(tmp_path / path).loaded["a[file=c:x]"]
        assert known == {"a.py": "0" * 12, "t%3B%202.txt": "1" * 12, "t%0A3:%204.txt": "2" * 12}
