"""Compiled kernels are cached separately for every state of the source, in the first writable cache folder."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba import config
from numba.core import caching

from frictionbench.problems import compiled
from frictionbench.problems.forms.cone import nearest
from frictionbench.solvers.plugins import describe_error
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT

KERNEL = """
from numba import njit
from frictionbench.problems.{module} import inner
@njit(cache=True)
def outer(): return inner()
"""


@pytest.fixture
def package(tmp_path) -> Path:
    """A package of two kernels, the one calling the other from another file."""
    home = tmp_path / "frictionbench"
    for folder in compiled.FOLDERS:
        (home / folder).mkdir(parents=True)
    problems = home / "problems"
    (home / "__init__.py").touch()
    (problems / "__init__.py").write_text("import frictionbench.problems.compiled\n")
    shutil.copy(ROOT / "frictionbench" / "problems" / "compiled.py", problems)
    (problems / "outer.py").write_text(KERNEL.format(module="inner"))
    write_inner(home, 1)
    return home


def write_inner(package: Path, value: int) -> None:
    (package / "problems" / "inner.py").write_text(f"from numba import njit\n@njit(cache=True)\ndef inner(): return {value}\n")


def call(package: Path, **environment: str) -> tuple[int, Path]:
    """What the outer kernel returns in a new process, and where its code is kept."""
    code = "from frictionbench.problems import outer; from numba.core import config; print(outer.outer(), config.CACHE_DIR)"
    settings = dict(os.environ, PYTHONPATH=str(package.parent), XDG_CACHE_HOME=str(package / "cache")) | environment
    settings = {name: text for name, text in settings.items() if text or name != "NUMBA_CACHE_DIR"}
    done = subprocess.run([sys.executable, "-c", code], env=settings, cwd=package, capture_output=True, text=True, check=True)
    value, folder = done.stdout.split(maxsplit=1)
    return int(value), Path(folder.strip())


def test_edited_callee_is_recompiled(package) -> None:
    first = call(package, NUMBA_CACHE_DIR="")
    write_inner(package, 2)
    second = call(package, NUMBA_CACHE_DIR="")
    assert (first[0], second[0]) == (1, 2)
    assert first[1] != second[1]
    assert list(first[1].rglob("*.nbi"))
    write_inner(package, 1)
    assert call(package, NUMBA_CACHE_DIR="") == first


def test_file_without_kernels_does_not_change_cache(package) -> None:
    before = compiled.state(package)
    (package / "solvers" / "plain.py").write_text("x = 1\n")
    assert compiled.state(package) == before


def test_temporary_cache_folder(package) -> None:
    (package / "cache").write_text("no folder can be made here")
    (package / "tmp").mkdir()
    value, folder = call(package, NUMBA_CACHE_DIR="", TMPDIR=str(package / "tmp"))
    assert value == 1
    assert folder.parent.parent == package / "tmp"
    assert folder.parent.stat().st_mode & 0o077 == 0


def test_damaged_kernels_are_told(tmp_path, monkeypatch) -> None:
    kept = caching.IndexDataCacheFile(str(tmp_path), "kernel", None)
    (tmp_path / "kernel.nbi").touch()
    with pytest.raises(EOFError) as caught:
        kept.load("signature")
    assert describe_error(caught.value).endswith(f"; compiled kernels are damaged: delete {config.CACHE_DIR}")
    monkeypatch.setattr("frictionbench.commands.cli._run", lambda: kept.load("signature"))
    done = frictionbench("export")
    assert (done.returncode, done.stderr.endswith(f"are damaged: delete {config.CACHE_DIR}\n")) == (2, True)


def test_intrinsic_called_from_python() -> None:
    with pytest.raises(TypeError, match="nearest can only be called from a compiled kernel"):
        nearest(-1.0, 1.0, 0.5, 0.0)
