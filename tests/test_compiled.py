"""Compiled kernels are kept apart for every state of the source, wherever there is room for them."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from problems import compiled
from problems.forms.cone import nearest

ROOT = Path(__file__).resolve().parent.parent
KERNEL = """
from numba import njit
from problems.{module} import inner
@njit(cache=True)
def outer(): return inner()
"""


@pytest.fixture
def house(tmp_path) -> Path:
    """A house of two kernels, the one calling the other from another file."""
    for folder in compiled.FOLDERS:
        (tmp_path / folder).mkdir()
    problems = tmp_path / "problems"
    (problems / "__init__.py").write_text("from problems.compiled import keep_compiled\nkeep_compiled()\n")
    shutil.copy(ROOT / "problems" / "compiled.py", problems)
    (problems / "outer.py").write_text(KERNEL.format(module="inner"))
    write_inner(tmp_path, 1)
    return tmp_path


def write_inner(house: Path, value: int) -> None:
    (house / "problems" / "inner.py").write_text(f"from numba import njit\n@njit(cache=True)\ndef inner(): return {value}\n")


def call(house: Path, **environment: str) -> tuple[int, Path]:
    """What the outer kernel returns in a new process, and where its code is kept."""
    code = "from problems.outer import outer; from numba.core import config; print(outer()); print(config.CACHE_DIR)"
    settings = dict(os.environ, PYTHONPATH=str(house), XDG_CACHE_HOME=str(house / "cache")) | environment
    settings = {name: text for name, text in settings.items() if text or name != "NUMBA_CACHE_DIR"}
    done = subprocess.run([sys.executable, "-c", code], env=settings, cwd=house, capture_output=True, text=True, check=True)
    value, folder = done.stdout.splitlines()
    return int(value), Path(folder)


def test_an_edit_of_a_called_kernel_is_seen(house) -> None:
    first = call(house, NUMBA_CACHE_DIR="")
    write_inner(house, 2)
    second = call(house, NUMBA_CACHE_DIR="")
    assert (first[0], second[0]) == (1, 2)
    assert first[1] != second[1]
    assert list(first[1].rglob("*.nbi"))
    write_inner(house, 1)
    assert call(house, NUMBA_CACHE_DIR="") == first


def test_a_file_without_kernels_changes_nothing(house) -> None:
    before = compiled.state(house)
    (house / "solvers" / "plain.py").write_text("x = 1\n")
    assert compiled.state(house) == before


def test_the_user_says_where(house) -> None:
    _, folder = call(house, NUMBA_CACHE_DIR=str(house / "mine"))
    assert folder.parent == house / "mine"


def test_without_a_cache_folder_the_temporary_one_serves(house) -> None:
    (house / "cache").write_text("no folder can be made here")
    (house / "tmp").mkdir()
    value, folder = call(house, NUMBA_CACHE_DIR="", TMPDIR=str(house / "tmp"))
    assert value == 1
    assert folder.parent.parent == house / "tmp"
    assert folder.parent.stat().st_mode & 0o077 == 0


def test_a_part_called_from_python_says_what_it_is() -> None:
    with pytest.raises(TypeError, match="nearest is a part of kernels"):
        nearest(-1.0, 1.0, 0.5, 0.0)
