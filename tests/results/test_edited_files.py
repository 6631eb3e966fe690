"""Results folders and baselines that someone edited: every command ends in 0 or 2 with one line.

Each takes at most ten seconds of the processor and 500 MB in addition. A few cases by default; FRICTIONBENCH_MUTATIONS=1000
runs more.
"""

import json

import numpy as np
import pytest

from frictionbench.results.compare import accept
from tests.helpers import command_line
from tests.helpers.command_line import Done
from tests.helpers.edits import CASES, edited, little_memory, little_time
from tests.helpers.made_results import SETTINGS, simulation_row, solve_row, write_folder

pytestmark = pytest.mark.slow  # edits at random; the quick tests see those that are listed by name


def frictionbench(*arguments: str) -> Done:
    """Run a command; it must take little time."""
    with little_time():
        return command_line.frictionbench(*arguments)


def good(done: Done, compared: bool = False) -> None:
    """Assert that the command did what it can, or refused its input in one line; a comparison may find a regression."""
    assert done.returncode in ((0, 1, 2) if compared else (0, 2)), done
    if done.returncode == 2 and not compared:
        assert len(done.stderr.strip().splitlines()) == 1, done
    if done.returncode == 1:
        assert "worse" in done.stdout, done
    assert "\x1b" not in done.stdout + done.stderr


@pytest.fixture
def folder(tmp_path):
    rows = [solve_row(variant, problem, work='{"pivots": 3}') for variant in ("lemke", "nsgs") for problem in ("abc", "def")]
    return write_folder(tmp_path / "run", rows, [simulation_row("lemke")], settings=SETTINGS | {"memory_limit": 2**32})


def commands(case, run, before, tmp_path) -> None:
    good(frictionbench("compare", str(before), str(run)), compared=True)
    good(frictionbench("compare", str(run), str(before), "--out", str(tmp_path / "out")), compared=True)
    good(frictionbench("compare", "--history", str(before), str(run)))
    good(frictionbench("compare", str(tmp_path / "new.tsv"), str(run), "--accept"))
    if case % 20 == 19:  # it takes far longer than the others
        good(frictionbench("report", str(run), "--markdown"))


def test_edited_manifests(folder, tmp_path) -> None:
    random, path = np.random.default_rng(1), folder / "manifest.json"
    accept(folder, tmp_path / "before.tsv")
    manifest = json.loads(path.read_text(encoding="utf-8"))
    manifest["settings"] |= {"plugins": [{"source": "x", "solvers": {"a": {}}}], "maps": [], "sources": []}
    with little_memory():
        for case in range(CASES):
            path.write_text(json.dumps(edited(manifest, random)), encoding="utf-8")
            commands(case, folder, tmp_path / "before.tsv", tmp_path)


def test_edited_baselines(folder, tmp_path) -> None:
    random, path = np.random.default_rng(3), tmp_path / "before.tsv"
    accept(folder, path)
    lines = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines()]
    with little_memory():
        for _ in range(CASES):
            changed = edited(lines, random)
            text = "\n".join(
                "\t".join(map(str, line)) if isinstance(line, list) else str(line)
                for line in (changed if isinstance(changed, list) else [changed])
            )
            path.write_text(text, encoding="utf-8", errors="replace")
            done = frictionbench("compare", str(path), str(folder))
            assert done.returncode == 2 or (done.returncode == 0 and changed == lines), done
            assert len(done.stdout.strip().splitlines()) <= 3, done
            good(frictionbench("compare", "--history", str(path), str(folder)))
            good(frictionbench("compare", str(path), str(folder), "--accept"))
