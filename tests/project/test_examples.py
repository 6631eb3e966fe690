"""The examples of the pages on choosing a solver, on adding one, on engines and on Python run unchanged in an empty folder."""

import re

from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

PAGES = [(ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in ("choose", "plugin", "engines", "api")]
BLOCKS = [block for page in PAGES for block in re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)]


def test_problem_and_python_interface(tmp_path, monkeypatch) -> None:
    (tmp_path / "mine.py").write_text(next(block for block in BLOCKS if "@solver" in block), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    for block in BLOCKS:
        if "@solver" not in block:
            exec(block, {})
    solved = frictionbench("solve", "problem.npz", "--solver", "lemke", "--solver", "nsgs", cwd=tmp_path)
    assert "problem.npz: 2 contacts in the plane, 3 velocities\n" in solved.stdout
    assert "fastest on this problem: " in solved.stdout, solved.stderr
    for steps, creep in (("steps", "0.4"), ("made.npz", "1")):
        assert f"creep at {creep} mm/s" in frictionbench("judge", steps, cwd=tmp_path).stdout
