"""Studies are computed once, anew where their code has changed, and written as a page."""

import os
import re
import subprocess
import sys

import pandas as pd
import pytest

from studies import running
from studies.__main__ import main
from studies.study import Summary
from tests.helpers.paths import ROOT
from tests.helpers.runs import MARK, marked, soon


def test_every_study_is_documented() -> None:
    page = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (\w+)$", page, re.MULTILINE) == list(running.NAMES)
    assert {path.stem for path in running.HERE.glob("text/*.md")} == {*running.NAMES, "page"}


def test_a_table_is_kept_until_its_code_changes(tmp_path, monkeypatch) -> None:
    path = running.write_rows(tmp_path, "convexity", "jam")
    assert len(pd.read_parquet(path)) == 41
    monkeypatch.setattr(running, "NAMES", ("convexity",))
    only = running.study("convexity")._replace(rows=running.study("convexity").rows[:1])
    monkeypatch.setattr(running, "study", lambda name: only)
    before = path.stat().st_mtime_ns
    running.compute(["convexity"], tmp_path, 1)
    assert path.stat().st_mtime_ns == before
    monkeypatch.setattr(running, "code", lambda name: "other")
    assert not running._kept(tmp_path, "convexity", "jam")


@pytest.mark.slow  # the quick tests kill no process
def test_a_killed_study_leaves_no_process(tmp_path) -> None:
    command = [sys.executable, "-m", "studies", "convexity", "--jobs", "1", "--out", str(tmp_path)]
    begun = subprocess.Popen(command, env=os.environ | {MARK: str(tmp_path)}, cwd=ROOT)
    assert soon(lambda: len(marked(str(tmp_path))) > 2, seconds=300.0)  # with the process of a table
    begun.kill()
    begun.wait()
    assert soon(lambda: not marked(str(tmp_path)))


def test_unusable_arguments_are_refused_first(tmp_path, capsys) -> None:
    (tmp_path / "file").touch()
    for given, told in ((("--jobs", "0"), "--jobs: must be"), (("--out", str(tmp_path / "file")), "File exists")):
        with pytest.raises(SystemExit, match="2"):
            main(["convexity", *given])
        assert told in capsys.readouterr().err


def test_what_draws_and_writes_is_no_code_of_a_table(tmp_path, monkeypatch) -> None:
    for name in ("motions.py", "convexity.py"):
        (tmp_path / name).write_text((running.HERE / name).read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(running, "HERE", tmp_path)
    before, path = running.code("convexity"), tmp_path / "convexity.py"
    path.write_text(path.read_text(encoding="utf-8") + "# drawn otherwise", encoding="utf-8")
    assert running.code("convexity") == before
    path.write_text("# computed otherwise" + path.read_text(encoding="utf-8"), encoding="utf-8")
    assert running.code("convexity") != before


def test_numbers_that_the_prose_lacks_are_errors() -> None:
    with pytest.raises(Exception, match="undefined"):
        running.text("convexity", Summary({}, {}))
