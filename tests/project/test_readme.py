"""What the README tells a stranger to do works, word for word."""

import re
from pathlib import Path

import pytest

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
