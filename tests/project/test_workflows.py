"""The workflows of docs/ci.md run: each step of theirs is executed in a repository with a solver and its baseline."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

pytestmark = pytest.mark.slow  # the quick tests would not see a step of a workflow that fails

yaml = pytest.importorskip("yaml")
GITHUB, GITLAB = map(
    yaml.safe_load, re.findall(r"```yaml\n(.*?)```", (ROOT / "docs" / "ci.md").read_text(encoding="utf-8"), re.DOTALL)
)
MINE = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "plugin.md").read_text(encoding="utf-8"), re.DOTALL)[0]
SMALL = ("--scene", "stack[blocks=1,push=1]", "--tol", "1e-6")
# The command line with one pair of runs to confirm in place of eight, and one scene of the suite.
COMMAND = f"""#!{sys.executable}
import sys
sys.path.insert(0, {str(ROOT)!r})
from frictionbench.commands.cli import main
from frictionbench.commands import confirm
confirm.PAIRS = 1
sys.argv += {SMALL!r} if sys.argv[1] == "run" else ()
main()
"""


@pytest.fixture(scope="module")
def repository(tmp_path_factory) -> Path:
    """A repository with a solver, its baseline and the branch main, in which the suite is installed."""
    home = tmp_path_factory.mktemp("repository")
    (home / "solvers").mkdir()
    (home / "solvers" / "mine.py").write_text(MINE, encoding="utf-8")
    ran = frictionbench("run", "smoke", "--solver", "solvers/mine.py", "--out", "runs/first", *SMALL, cwd=home)
    assert ran.returncode == 0, ran.stderr
    assert frictionbench("compare", "baselines/smoke.tsv", "runs/first", "--accept", cwd=home).returncode == 0
    made = "git init -q -b main && git add solvers baselines && git -c user.name=a -c user.email=a@b commit -qm first"
    subprocess.run(["sh", "-c", f"{made} && git branch origin/main && git remote add origin ."], cwd=home, check=True)
    command = home / ".venv" / "bin" / "frictionbench"
    command.parent.mkdir(parents=True)
    command.write_text(COMMAND, encoding="utf-8")
    command.chmod(0o755)
    return home


def executed(steps: list[str], repository: Path, variables: dict[str, str]) -> str:
    """Run the steps in a shell and return the comparison that they write."""
    shutil.rmtree(repository / "runs", ignore_errors=True)
    shutil.rmtree(repository / "comparison", ignore_errors=True)
    for step in steps:
        done = subprocess.run(
            ["bash", "-ec", step], cwd=repository, env=os.environ | variables, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{step}\n{done.stdout}\n{done.stderr}"
    assert (repository / "comparison" / "junit.xml").exists()
    return (repository / "comparison" / "comparison.md").read_text(encoding="utf-8")


def test_github_workflow_of_a_fork(repository: Path, tmp_path: Path) -> None:
    (job,) = GITHUB["jobs"].values()
    assert job["timeout-minutes"] <= 60
    used = [step["uses"].partition("@")[0] for step in job["steps"] if "uses" in step]
    assert {"actions/cache", "actions/upload-artifact"} <= set(used)
    here = "head.repo.full_name == github.repository"
    own = [step for step in job["steps"] if "run" in step and here not in str(step.get("if", ""))]
    assert not any("gh " in step["run"] for step in own)
    assert "pip install" in own[0]["run"]
    given = {name: str(value) for name, value in GITHUB["env"].items()} | {"GITHUB_STEP_SUMMARY": str(tmp_path / "summary.md")}
    steps = [step["run"].replace("${{ github.base_ref }}", "main") for step in own[1:]]
    assert not any("${{" in step for step in steps)
    assert executed(steps, repository, given).startswith("## worse 0 ")
    assert (tmp_path / "summary.md").read_text(encoding="utf-8").startswith("## worse 0 ")


def test_gitlab_workflow(repository: Path) -> None:
    (job,) = GITLAB.values()
    assert job["artifacts"]["reports"]["junit"] == "comparison/junit.xml"
    assert "pip install" in job["script"][0]
    base = subprocess.run(["git", "rev-parse", "main"], cwd=repository, check=True, capture_output=True, text=True).stdout
    given = {"SOLVER": job["variables"]["SOLVER"], "CI_MERGE_REQUEST_DIFF_BASE_SHA": base.strip()}
    assert executed(job["script"][1:], repository, given).startswith("## worse 0 ")
