"""Links, files, subpackages, commands, options and constants named in the documents exist; columns are those of the schema."""

import csv
import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.harness.workers import pool, supervisor
from frictionbench.problems.recorded import archive, fclib, siconos
from frictionbench.results import store
from tests.helpers.paths import ROOT
from tools.columns import describe

DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
each_document = pytest.mark.parametrize("document", DOCUMENTS, ids=[path.name for path in DOCUMENTS])
RUNS = [json.loads(path.read_text(encoding="utf-8")) for path in (ROOT / "results/published").glob("*.json")]
SUITES = ("standard", "peers")
FOLDERS = ("problems", "solvers", "harness", "results", "reports", "tests", "docs", "frictionbench", "studies", "tools")
# Written by recipes or by a user's own repository.
EXAMPLES = re.compile(r"brick|plate|pushes|midpoint|jacobi|scipy_nnls|charts/solved|plain_json|solvers/mine")


@each_document
def test_links_exist(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    headings = {
        "#" + re.sub(r"[^\w -]", "", line.lstrip("# ").lower()).replace(" ", "-")
        for line in text.splitlines()
        if line.startswith("##")
    }
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    assert [link for link in links if link not in headings and not (document.parent / link.partition("#")[0]).exists()] == []


@each_document
def test_named_files_exist(document: Path) -> None:
    named = re.findall(rf"`((?:{'|'.join(FOLDERS)})/[\w/.]*)`", document.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists() and not EXAMPLES.search(name)] == []


@each_document
def test_commands_and_options_exist(document: Path) -> None:
    lines = re.findall(r"^    frictionbench ([a-z][\w-]*)([^#\n]*)", document.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for command, rest in lines:
        known = CliRunner().invoke(app, [command, "--help"])
        assert known.exit_code == 0, command
        assert [option for option in re.findall(r"--[\w-]+", rest) if option not in known.output] == []


def test_leads_in_the_paper_are_those_of_published_runs() -> None:
    """What a new published run changes is changed in the paper, too; no winner is named where the run names none."""
    text = " ".join((ROOT / "docs/paper/paper.md").read_text(encoding="utf-8").split())
    lead = re.compile(r"([\d.]+) times ahead of (\w+)\*? \(([\d.]+) to ([\d.]+)(\): no clear winner)?")
    told = " ".join(line for run in RUNS if run["version"][:7] in text for line in run["headline"] + run.get("classes", []))
    assert text.count(" times ahead of ") == len(lead.findall(text)) > 6
    assert set(lead.findall(text)) <= set(lead.findall(told))
    solved, version = re.findall(r"convex relaxation of (\d+) of the 126 problems of `standard` \((\w+)\)", text)[0]
    standard, peers = (next(run for run in RUNS if (run["suite"], run["version"][:7]) == (name, version)) for name in SUITES)
    assert {row["own"] for row in standard["reliability"] if row["solver"].startswith("clarabel")} == {int(solved)}
    waited = [
        int(re.findall(r"cells (\d+) shared or waited", str(run["checks"]))[0]) / run["cells"] for run in (standard, peers)
    ]
    assert "{:.0%} of the cells of `standard` and {:.0%} of `peers`".format(*waited).replace("%", " %") in text


def test_leads_on_the_published_page_are_those_of_published_runs() -> None:
    """But for two of runs that were discarded."""
    text = " ".join((ROOT / "docs/published.md").read_text(encoding="utf-8").split())
    told = " ".join(str([run[part] for part in ("headline", "classes", "checks") if part in run]) for run in RUNS)
    quoted = re.findall(r"(\d[\d.]*)[^()\d]* \((?:95 % interval (?:over problems )?)?([\d.]+) to ([\d.]+)\)", text)
    of_runs = re.findall(r"([\d.]+) times ahead of \S+ \(([\d.]+) to ([\d.]+)\)", told)
    assert set(quoted) - set(of_runs) == {("1.36", "1.00", "1.48"), ("1.28", "0.964", "1.45")}


def test_certified_answers_are_those_of_the_table() -> None:
    """docs/hard.md and the paper count what docs/certified.tsv lists."""
    with (ROOT / "docs/certified.tsv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    listed = [("all", row) for row in rows] + [(row["family"], row) for row in rows]
    counts = {family: [0, 0] for family, _ in listed}
    for family, row in listed:
        counts[family][0] += 1
        counts[family][1] += bool(row["radius"])
    table = re.findall(r"^\| ([^|]+) \| (\d+) \| (\d+) \|[^|]*\|$", (ROOT / "docs/hard.md").read_text("utf-8"), re.MULTILINE)
    assert {family: [int(problems), int(certified)] for family, problems, certified in table} == counts
    paper = " ".join((ROOT / "docs/paper/paper.md").read_text(encoding="utf-8").split())
    told = re.search(r"each of the (\d+) problems of the suite `hard` .*? For (\d+) of them the interval Newton", paper)
    assert told
    assert [int(told[1]), int(told[2])] == counts["all"]


def test_readme_is_one_screen() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 60


def test_security_limits() -> None:
    text = " ".join((ROOT / "SECURITY.md").read_text(encoding="utf-8").split())
    assert (store.LARGEST_TABLE, store.LARGEST_MANIFEST) == (2**30, 2**25)
    assert "unpack to more than 1 GiB; so are manifests above 32 MiB" in text
    assert (archive.MAX_BYTES, fclib.MAX_BYTES, siconos.MAX_BYTES, fclib.MAX_SECONDS) == (4 * 2**30, 2**29, 2**29, 120.0)
    assert "(4 GiB for `.npz`, 512 MiB for HDF5 and text)" in text
    assert "ended after 120 s" in text
    assert pool.TRIES == 3
    assert supervisor.FOREIGN_SECONDS == 180.0
    assert "three limits and 180 s" in text
    assert "tried again, three times in all" in text


def test_page_of_columns_is_generated() -> None:
    written = (ROOT / "docs" / "columns.md").read_text(encoding="utf-8")
    assert written == describe(), "python -m tools.columns > docs/columns.md"
