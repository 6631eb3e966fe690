"""Published results: runs stand beside each other, are checked, and what is damaged or unfinished is refused."""

import io
import json
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded.native import save
from frictionbench.results.files import ResultsError
from tests.helpers.browser import browse, faults, in_browser
from tests.helpers.made_results import SETTINGS, batch_row, solve_row, write_folder
from tests.helpers.paths import ROOT
from tools import performance
from tools.publish.__main__ import publish
from tools.publish.site import _csv, write_site
from tools.publish.summary import read

PROBLEM = random_problem(1, contacts=2)


def run(folder: Path, processor: str = "some", **manifest) -> Path:
    """A run of two solvers, one with a name that is no HTML, on a problem that the folder holds."""
    rows = [solve_row(solver, PROBLEM.hash, solve_time=1.234567e-3) for solver in ("lemke", "<nsgs>")]
    facts = {"machine": {"host": "here", "processor": processor, "cores": 2}, "finished": "2026-01-02T03:04:05"}
    write_folder(folder, rows, **facts | {"versions": {"frictionbench": "1.0"}} | manifest)
    (folder / "problems").mkdir()
    save(PROBLEM, folder / "problems" / f"{PROBLEM.hash}.npz")
    return folder


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Two machines' runs of one version."""
    home = tmp_path_factory.mktemp("published")
    runs = [run(home / name, name) for name in ("mine", "theirs")]
    (*_, index) = publish(runs, home / "site", home / "summaries")
    return index


def test_machines_stand_beside_each_other(site: Path) -> None:
    (page,) = [path for path in site.parent.glob("*.html") if path != site]
    text = page.read_text(encoding="utf-8")
    assert all('<h2 id="made-1.0-' in text and name in text for name in ("mine", "theirs"))
    assert "1 of 1 problems are those of the run of" in text
    assert "&lt;nsgs&gt;" in text
    assert "<nsgs>" not in text + site.read_text(encoding="utf-8")
    for folder in site.parent.glob("made-*/"):
        written = {path.name for path in folder.iterdir()}
        assert {"report.html", "solves.csv", "solves.parquet", "rankings.csv", "manifest.json"} <= written
    rows = pd.DataFrame({"scene": ["=1+1"], "times": [np.arange(2000.0)]})
    found = pd.read_csv(io.StringIO(_csv(rows))).loc[0]
    assert found["scene"] == "'=1+1", "no formula"
    assert json.loads(found["times"]) == rows["times"][0].tolist(), "nothing is left out"


def test_site_of_summaries_alone(site: Path, tmp_path: Path) -> None:
    summaries = site.parent.parent / "summaries"
    found = [read(path) for path in summaries.glob("*.json")]
    assert len(found) == 2
    assert all(holds for one in found for _, holds, _ in one["checks"])
    assert "host" not in found[0]["machine"]
    assert {place["mean"] for place in found[0]["rankings"]} == {0.00223457, 0.00173457}  # with form and setup
    (summaries / ".made-1.json").write_text("half-written when its program was killed", encoding="utf-8")
    (index,) = publish([summaries], tmp_path / "site", None)
    assert index.read_text(encoding="utf-8") == site.read_text(encoding="utf-8")


def test_leads_have_intervals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the table of several runs, and on a run's page for each kind of problem; an end of 1.00 decides nothing."""
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(ROOT / "docs/_ext")
    pages = import_module("published_results")
    standard = next(run for run in pages.entries() if run.summary["name"].startswith("standard-c5a9c9c"))
    close = standard._replace(summary=json.loads(json.dumps(standard.summary).replace("1.03 to", "1.00 to")))
    pairs = (standard, "lemke"), (close, "lemke"), (standard, "interior_point*")
    told = [pages.lead(run, "in the plane", "hybrid*", other).astext() for run, other in pairs]
    assert told == ["1.36 (1.03 to 1.46)", "1.36 (1.00 to 1.46), undecided", "1.44"]
    page = (write_site([standard], tmp_path).parent / standard.page).read_text(encoding="utf-8")
    assert page.count(" times ahead of ") == str([standard.summary[part] for part in ("headline", "classes", "checks")]).count(
        " ahead of "
    )


@in_browser  # which enforces the security policy of the page's script
def test_history_offers_its_solvers(site: Path, tmp_path: Path) -> None:
    assert '<option value="lemke">lemke</option>' in browse(site, "--dump-dom")


@in_browser
@pytest.mark.parametrize(("suite", "accessible"), [("standard", True), ("*", False)])  # axe takes minutes for all
def test_pages_look(tmp_path: Path, suite: str, accessible: bool) -> None:
    (index,) = publish([*(ROOT / "results/published").glob(f"{suite}-*.json")], tmp_path / "site", None)
    assert 'data-value="None"' not in index.read_text(encoding="utf-8")  # which is no number to sort by
    for page in sorted(index.parent.glob("*.html")):
        assert faults(page, accessible) == [], page.name


def test_damaged_folders_are_refused(tmp_path: Path) -> None:
    other = run(tmp_path / "other")
    save(random_problem(2, contacts=2), other / "problems" / f"{PROBLEM.hash}.npz")
    twice, unfinished = [run(tmp_path / "a"), run(tmp_path / "b")], run(tmp_path / "unfinished", finished=None)
    for runs, told in (([other], "another problem"), ([unfinished], "finished"), (twice, "twice")):
        with pytest.raises(ResultsError, match=told):
            list(publish(runs, tmp_path / "site", None))
    assert not (tmp_path / "site").exists()


def test_a_manifest_that_no_summary_can_quote_is_refused(tmp_path: Path) -> None:
    timeless = {"settings": SETTINGS | {"time_limit": float("nan")}}
    for field, edit in {"workers": {"workers": [1]}, "machine.cores": {"machine": {}}, "settings.time_limit": timeless}.items():
        with pytest.raises(ResultsError, match=rf"{field}: {field} is missing or cannot be used$"):
            list(publish([run(tmp_path / field, **edit)], None, tmp_path / "summaries"))


def test_problems_that_are_missing_are_told(tmp_path: Path) -> None:
    folder = run(tmp_path / "run", versions={"frictionbench": "1.0-dirty-1"}, options={"suite": "made", "tol": "1e-4"})
    (folder / "problems" / f"{PROBLEM.hash}.npz").unlink()
    (path,) = publish([folder], None, tmp_path / "summaries")
    assert {what for what, holds, _ in read(path)["checks"] if not holds} == {"problems", "version", "whole suite"}


EDITS = {
    "name": ("../up", "Index-a-b", "made.HTML", "a" * 300, 1),
    "format": (2,),
    "cells": (-1, True, 10**30),
    "machine.cores": (None, "two"),
    "settings.tolerances": (None, ["a"]),
    "libraries": ([], {"numpy": {}}),
    "checks": ([["a"]], 3),
    "classes": (3, [1]),
    "rankings": ([1], {}),
    "rankings.target": (None, 0, "x", 1e309),
    "rankings.mean": ("x", -1.0, True),
    "scenes.scene": (None,),
}


@pytest.mark.parametrize("field", EDITS)
def test_edited_summaries_are_refused(field: str, tmp_path: Path) -> None:
    """Each names its field, and none reaches a page."""
    (path,) = publish([run(tmp_path / "run")], None, tmp_path / "summaries")
    text = path.read_text(encoding="utf-8")
    for value in (*EDITS[field], *[...] * (field != "classes")):  # which older runs do not have
        edited, (part, _, name) = json.loads(text), field.partition(".")
        places = edited[part] if isinstance(edited[part], list) and name else [edited[part] if name else edited]
        for place in places:
            place[name or part] = value
            if value is ...:
                del place[name or part]
        path.write_text(json.dumps(edited), encoding="utf-8")
        with pytest.raises(ResultsError, match=f"{path.name}: .*{field}"):
            read(path)


def test_rates_stand_in_a_table_for_each_batch(tmp_path: Path) -> None:
    rows = [batch_row("lemke", way) for way in ("calls", "packed")]
    rows += [batch_row("osqp", "calls", verified=0.5, verdict="relaxed")]
    told = performance.rates(write_folder(tmp_path, [], batches=rows))
    assert "### 4 contacts in the plane: stack[blocks=2]" in told
    assert "| lemke | packed | cold | 1,000 | 2 |" in told
    assert "| osqp | calls | cold | 50 % verified | – |" in told
    assert max(map(len, told.splitlines())) <= 128
