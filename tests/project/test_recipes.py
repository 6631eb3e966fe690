"""The recipes of CONTRIBUTING.md work unchanged in a copy of the source."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import config
from numba.core.caching import _CacheLocator

from frictionbench.problems.compiled import PACKAGE
from tests.helpers.paths import ROOT

pytestmark = pytest.mark.slow  # the quick tests read the recipes, and would not see one that fails as it stands

RECIPES = dict(
    re.findall(r"^### (.+?)\n(.*?)(?=^### |\Z)", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.M | re.S)
)
# What each recipe's last command must print; a wrong claim must be reported as wrong.
SHOWS = {
    "Add a scene": ("lemke", "solved"),
    "Add an instance": ("8 contacts", "nsgs", "solved"),
    "Add a time-stepping scheme": ("brick.html",),
    "Add a solver": ("jacobi", "solved"),
    "Add an outside solver": ("scipy_nnls", "wrong"),
    "Add a chart": ("report:", "paper:"),
    "Add a study": ("studies.md",),
    "Add a suite": ("solved", "lemke"),
    "Add a check to the contract": ("counts its work",),
    "Add a file format": ("one.json: 1 contact", "solved"),
}


@pytest.fixture(scope="module")
def source(tmp_path_factory) -> Path:
    copy = tmp_path_factory.mktemp("source")
    for package in ("frictionbench", "studies", "tests"):
        shutil.copytree(ROOT / package, copy / package)
    for folder in ("problems", "solvers", "harness", "results", "reports"):
        (copy / folder).symlink_to(f"frictionbench/{folder}")
    share_compiled(copy)
    return copy


def share_compiled(copy: Path) -> None:
    """Copy the compiled kernels of this source for use by the copy, whose files have equal times and sizes."""
    kept = Path(config.CACHE_DIR)
    for folder in {path.parent for path in copy.rglob("*.py")}:
        here, there = (
            _CacheLocator.get_suitable_cache_subpath(str(home / folder.relative_to(copy) / "any.py"))
            for home in (PACKAGE, copy / "frictionbench")
        )
        if (kept / here).is_dir():
            shutil.copytree(kept / here, copy / "compiled" / kept.name / there)


def called(copy: Path, command: str | list[str]) -> str:
    """What a command prints in the copy, in the shell if it is a text."""
    environment = os.environ | {"PYTHONPATH": str(copy), "COLUMNS": "200", "NUMBA_CACHE_DIR": str(copy / "compiled")}
    piped = {"shell": isinstance(command, str), "capture_output": True, "text": True, "timeout": 300}
    done = subprocess.run(command, cwd=copy, env=environment, check=False, **piped)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def follow(recipe: str, copy: Path) -> str:
    """Write the files that a recipe gives, make its changes, run its commands; what the last one printed."""
    for name, text in re.findall(r"Write\s`([\w/.]+)`:\n\n```(?:python|markdown)\n(.*?)```", recipe, re.S):
        lines = [line for line in text.splitlines() if line.strip()]
        assert len(lines) <= 20, f"{name} is too long for a recipe"
        (copy / name).write_text(text, encoding="utf-8")
    for name, changes in re.findall(r"```diff\n--- ([\w/.]+)\n(.*?)```", recipe, re.S):
        for hunk in changes.split("@@\n"):
            change(copy / name, hunk.splitlines())
    printed = ""
    for command in re.findall(r"^    ((?:frictionbench|python|echo) .+)$", recipe, re.M):
        program, *words = shlex.split(command)
        call = words if program == "python" else ["-c", "from frictionbench.commands.cli import main; main()", *words]
        printed = called(copy, command if program == "echo" else [sys.executable, *call])
    return printed


def change(path: Path, hunk: list[str]) -> None:
    """Replace the lines of a hunk that begin with a space or - by those that begin with a space or +."""
    before, after = ("\n".join(line[1:] for line in hunk if line[0] in kind) for kind in (" -", " +"))
    text = path.read_text(encoding="utf-8")
    assert text.count(before) == 1, f"{path.name} has {text.count(before)} times:\n{before}"
    path.write_text(text.replace(before, after), encoding="utf-8")


@pytest.fixture(scope="module")
def printed(source) -> dict[str, str]:
    return {name: follow(recipe, source) for name, recipe in RECIPES.items()}


@pytest.mark.parametrize("name", RECIPES)
def test_recipe(name, printed) -> None:
    for word in SHOWS[name]:
        assert word in printed[name]


QUICK = [  # what make quick checks of the package, and of its tests those that take in what is new
    *("ruff check frictionbench", "ruff format --check frictionbench", "mypy frictionbench"),
    "pytest --numprocesses=0 tests/harness/test_contract.py -k counts_its_work",
    "pytest --numprocesses=0 tests/problems tests/solvers -k 'test_every_solver and jacobi or test_interface and scipy_nnls "
    "or test_scenes and brick or test_schemes and (brick or ball or tower) or test_rotation and midpoint or every_parameter'",
]


@pytest.mark.parametrize("check", QUICK)
def test_recipes_pass_what_make_quick_checks(check, source, printed) -> None:
    shutil.copy(ROOT / "pyproject.toml", source)
    called(source, [sys.executable, "-m", *shlex.split(check)])


def test_recipe_chart_is_drawn(source, printed) -> None:
    run = source / "runs" / "brick"
    assert "Cells solved, trivial problems left out." in (run / "report.html").read_text(encoding="utf-8")
    assert (run / "paper" / "solved.pdf").exists()
