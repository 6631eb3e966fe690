"""The examples of the pages on choosing a solver, on adding one and on Python run unchanged in an empty folder."""

import re
from pathlib import Path

import pytest

from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

PAGES = [(ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("choose", "plugin", "api")]
BLOCKS = [block for page in PAGES for block in re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)]


@pytest.fixture
def newcomer(tmp_path) -> Path:
    """A folder with the plug-in, and where the other Python blocks were run."""
    (tmp_path / "mine.py").write_text(next(block for block in BLOCKS if "@solver" in block), encoding="utf-8")
    return tmp_path


def test_plugin(newcomer) -> None:
    assert len([line for line in (newcomer / "mine.py").read_text().splitlines() if line]) <= 16
    checked = frictionbench("check-solver", "mine.py", cwd=newcomer)
    assert (checked.returncode, "broken" in checked.stdout) == (0, False), checked.stdout
    solved = frictionbench("solve", "stack[blocks=2,push=1]", "--solver", "mine.py", cwd=newcomer)
    assert re.search(r"1  mine +solved", solved.stdout), solved.stdout + solved.stderr


def test_problem_and_python_interface(newcomer, monkeypatch) -> None:
    monkeypatch.chdir(newcomer)
    for block in BLOCKS:
        if "@solver" not in block:
            exec(block, {})
    solved = frictionbench("solve", "problem.npz", "--solver", "lemke", "--solver", "nsgs", cwd=newcomer)
    assert "problem.npz: 2 contacts in the plane, 3 velocities\n" in solved.stdout
    assert "use " in solved.stdout, solved.stderr
