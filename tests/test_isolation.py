"""Workers run our code and nobody else's, end with the run whatever runs in them, and do not spoil one another."""

import subprocess
import sys
from pathlib import Path

import pytest

from harness import machine
from harness.workers import pool
from harness.workers.pool import Pool
from results import store
from results.store import ResultsError

SABOTAGE = "raise RuntimeError('the code of the current folder was run')"


def frictionbench(*arguments: str, **options) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "frictionbench", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300, **options)


@pytest.fixture
def saboteurs_folder(tmp_path) -> Path:
    for package in ("problems", "solvers", "harness", "results", "reports"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text(SABOTAGE, encoding="utf-8")
    (tmp_path / "numpy.py").write_text(SABOTAGE, encoding="utf-8")
    return tmp_path


def test_the_current_folder_is_not_imported_from(saboteurs_folder) -> None:
    options = ("run", "smoke", "--scene", "stack", "--solver", "nsgs", "--tol", "1e-4", "--out", "run")
    done = frictionbench(*options, cwd=saboteurs_folder)
    assert done.returncode == 0, done.stderr
    assert set(store.read_table(saboteurs_folder / "run", "solves")["verdict"]) == {"solved"}


def test_a_package_that_hides_ours_is_named(saboteurs_folder) -> None:
    script = saboteurs_folder / "script.py"
    script.write_text("import frictionbench", encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    told = done.stderr.strip().splitlines()[-1]
    assert told.startswith("ImportError: ")
    assert str(saboteurs_folder / "problems") in told
    assert "rename it" in told


def test_the_face_shows_what_a_user_needs() -> None:
    import frictionbench as fb

    problem = fb.scene("stack", blocks=2, push=1.0).problem()
    assert fb.solve(problem, "lemke", tol=1e-8).status is fb.Status.SOLVED
    assert all(hasattr(fb, name) for name in fb.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        fb.nonsense  # noqa: B018


def test_a_worker_of_other_code_is_refused(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(pool, "_server", None)
    monkeypatch.setattr(machine, "code", lambda: {"root": str(machine.ROOT), "content": "another"})
    with pytest.raises(ResultsError, match=r"workers: they run .*, not .*another"):
        Pool(tmp_path, 1, (), 2**30)
