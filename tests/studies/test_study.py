"""The command `study`: its folder, how it goes on, what it refuses, and its pages."""

import json
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from frictionbench.harness import run_studies as running
from frictionbench.harness.progress import Progress
from frictionbench.harness.studies import STUDIES, Study
from frictionbench.reports import studies_page
from frictionbench.reports.drawing.figures import Panel
from frictionbench.reports.latex import Layout
from frictionbench.reports.studies import ACCOUNTS, Account
from frictionbench.reports.studies.account import Figure
from frictionbench.results.files import ResultsError
from frictionbench.results.studies import StudyTables, finished, open_study, read_study, write_rows
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

SCRIPT = "<script>alert(1)</script>"


@pytest.fixture
def short() -> Study:
    """The study of convexity with its quickest table."""
    study = STUDIES["convexity"]
    return replace(study, tables=tuple(table for table in study.tables if table.name == "jam"))


@pytest.fixture
def small(tmp_path, short) -> Path:
    """A folder with that study, its table written by hand."""
    open_study(tmp_path, short.description)
    write_rows(tmp_path, short.description, "jam", [dict.fromkeys(short.description.columns["jam"], 1.0)])
    return tmp_path


def test_every_study_is_told_and_documented() -> None:
    assert list(ACCOUNTS) == list(STUDIES)
    text = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    assert [name for name in STUDIES if f"\n## {name}\n" not in text] == []
    for study in STUDIES.values():
        assert study.question.endswith("?")
        assert set(study.description.columns) == {table.name for table in study.tables}


def test_tables_are_computed_once(tmp_path, short) -> None:
    running.run_studies([short], tmp_path, 1, Progress())
    path = tmp_path / "convexity" / "jam.json"
    assert len(read_study(tmp_path, "convexity")["jam"]) == 41
    path.write_text("[]", encoding="utf-8")
    running.run_studies([short], tmp_path, 1, Progress())
    assert path.read_text(encoding="utf-8") == "[]"


def test_tables_of_other_code_are_not_continued(small, short) -> None:
    path = small / "convexity" / "study.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"content": "other"}), encoding="utf-8")
    with pytest.raises(ResultsError, match=r"convexity: computed by .* choose another --out"):
        running.run_studies([short], small, 1, Progress())


def test_damaged_and_missing_tables_are_named(small, short) -> None:
    assert finished(small, "convexity")
    with pytest.raises(ResultsError, match="the rows of the table jam do not have the columns share"):
        write_rows(small, short.description, "jam", [{"share": 1.0}])
    for text in ("[{}]", "[1]", "{", "null"):
        (small / "convexity" / "jam.json").write_text(text, encoding="utf-8")
        with pytest.raises(ResultsError, match=r"jam\.json: cannot be read"):
            read_study(small, "convexity")
    (small / "convexity" / "jam.json").unlink()
    assert not finished(small, "convexity")
    with pytest.raises(ResultsError, match=r"jam\.json: missing; run the study again"):
        read_study(small, "convexity")


def test_claims_that_the_tables_do_not_hold_are_refused(short) -> None:
    tables = StudyTables(short.description, {"jam": pd.DataFrame()})
    tables.require(True, "nothing")
    with pytest.raises(ResultsError, match="convexity: the tables do not show what the text says: a claim"):
        tables.require(False, "a claim")


def test_pages_and_files_for_a_paper(small, monkeypatch) -> None:
    def account(found: StudyTables) -> Account:
        panel = Panel("a line", lambda ax: ax.plot(found["jam"]["share"], found["jam"]["velocity"]))
        return Account(f"Yes. {SCRIPT}", "Result.", "Limits.", (Figure("line", "A line.", (panel,)),))

    monkeypatch.setitem(studies_page.ACCOUNTS, "convexity", account)
    page = studies_page.write_studies(small)
    assert SCRIPT not in page.read_text(encoding="utf-8")
    assert SCRIPT not in (small / "studies.md").read_text(encoding="utf-8")
    assert "![A line.](studies/convexity_line.svg)" in (small / "studies.md").read_text(encoding="utf-8")
    before = (small / "studies" / "convexity_line.svg").read_bytes()
    studies_page.write_studies(small)
    assert (small / "studies" / "convexity_line.svg").read_bytes() == before
    paper = studies_page.write_paper(small, Layout())
    assert {"convexity_line.pdf", "captions.tex", "preview.tex"} <= {path.name for path in paper.iterdir()}
    assert "convexity_line" in (paper / "preview.tex").read_text(encoding="utf-8")


def test_unknown_studies_are_refused(tmp_path) -> None:
    done = frictionbench("study", "convexty", cwd=tmp_path)
    assert done.returncode == 2
    assert "study: unknown study 'convexty' (did you mean convexity?)" in done.stderr
    assert not list(tmp_path.iterdir())
