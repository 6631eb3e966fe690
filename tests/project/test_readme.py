"""What the README tells a stranger to do works, word for word."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from frictionbench.harness.cli import app
from tests.helpers.command_line import frictionbench
from tests.helpers.places import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


@pytest.fixture
def stranger(tmp_path) -> Path:
    """A folder with the plug-in of the README, and where its other Python blocks were run."""
    (tmp_path / "mine.py").write_text(next(block for block in BLOCKS if "@solver" in block), encoding="utf-8")
    return tmp_path


def test_the_plug_in_is_short_keeps_the_contract_and_solves(stranger) -> None:
    assert len([line for line in (stranger / "mine.py").read_text().splitlines() if line]) <= 15
    checked = frictionbench("check-solver", "mine.py", cwd=stranger)
    assert (checked.returncode, "broken" in checked.stdout) == (0, False), checked.stdout
    solved = frictionbench("solve", "stack[blocks=2,push=1]", "--solver", "mine.py", cwd=stranger)
    assert re.search(r"1  mine +solved", solved.stdout), solved.stdout + solved.stderr


def test_a_problem_of_ones_own_is_a_file(stranger, monkeypatch) -> None:
    monkeypatch.chdir(stranger)
    for block in BLOCKS:
        if "@solver" not in block:
            exec(block, {})
    solved = frictionbench("solve", "problem.npz", "--solver", "lemke", "--solver", "nsgs", cwd=stranger)
    assert "problem.npz: 2 contacts" in solved.stdout
    assert "use " in solved.stdout, solved.stderr


def test_every_command_and_option_of_the_readme_is_there() -> None:
    told = re.findall(r"^    frictionbench ([\w-]+)([^#\n]*)", README, flags=re.MULTILINE)
    assert {command for command, _ in told} >= {"list", "run", "report", "compare", "accept", "solve", "map", "shrink"}
    for command, rest in told:
        known = CliRunner().invoke(app, [command, "--help"])
        assert known.exit_code == 0, command
        assert [option for option in re.findall(r"--[\w-]+", rest) if option not in known.output] == []


def test_every_link_leads_somewhere() -> None:
    links = re.findall(r"\]\(([^)]+)\)", README)
    headings = {
        "#" + re.sub(r"[^\w -]", "", line[3:].lower()).replace(" ", "-") for line in README.splitlines() if line[:3] == "## "
    }
    root = ROOT
    assert [link for link in links if link not in headings and not (root / link).exists()] == []
