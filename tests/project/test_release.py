"""What a release needs: one version everywhere, placeholders in one place, workflows that are read and bounded."""

import re
import tomllib

import pytest

from tests.helpers.paths import ROOT
from tools.publish.summary import read

yaml = pytest.importorskip("yaml")
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def test_version_is_the_same_everywhere() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["version"] == VERSION
    assert re.search(r"^## (\S+?)[, \n]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)[1] == VERSION


def test_placeholders_stand_in_one_place() -> None:
    """CITATION.cff holds them, each marked; no other file has an address or a DOI that is still to come."""
    cited = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()
    unmarked = [line for line in cited if re.search(r"example\.org|10\.0000|1970-01-01", line) and "TO FILL IN" not in line]
    assert unmarked == []
    texts = {*ROOT.glob("*.md"), *ROOT.glob("*.toml"), *(ROOT / "docs").rglob("*.md"), *WORKFLOWS}
    assert [path.name for path in texts if re.search(r"example\.org|10\.0000/", path.read_text(encoding="utf-8"))] == []


def test_published_summaries_are_read_and_small() -> None:
    found = sorted((ROOT / "results" / "published").glob("*.json"))
    assert [read(path)["name"] for path in found] == [path.stem for path in found]
    assert found
    assert sum(path.stat().st_size for path in found) < 4 * 2**20


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_are_bounded_and_do_not_pile_up(workflow) -> None:
    text = workflow.read_text(encoding="utf-8")
    read = yaml.safe_load(text)
    assert read["concurrency"]["group"]
    assert all(job["timeout-minutes"] <= 180 for job in read["jobs"].values())
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    commands = [step["run"] for job in read["jobs"].values() for step in job["steps"] if "run" in step]
    assert [
        name for command in commands for name in re.findall(r"^make ([\w-]+)", command) if f"\n{name}:" not in makefile
    ] == []
