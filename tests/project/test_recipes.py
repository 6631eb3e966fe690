"""The recipes of docs/house.md, followed word for word in a copy of the house."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import config
from numba.core.caching import _CacheLocator

from frictionbench.problems.compiled import PACKAGE
from tests.helpers.places import ROOT

RECIPES = dict(
    re.findall(r"^### (.+?)\n(.*?)(?=^### |\Z)", (ROOT / "docs" / "house.md").read_text(encoding="utf-8"), re.M | re.S)
)
PIPED = {"capture_output": True, "text": True, "timeout": 300}
# What each recipe's last command must show; a claim that is wrong must be seen to be.
SHOWS = {
    "Add a scene": ("lemke", "solved"),
    "Add a solver": ("jacobi", "solved"),
    "Add an outside solver": ("scipy_nnls", "wrong"),
    "Add a chart": ("report:", "paper:"),
}


@pytest.fixture(scope="module")
def house(tmp_path_factory) -> Path:
    copy = tmp_path_factory.mktemp("house")
    for folder in ("problems", "solvers", "harness", "results", "reports"):
        shutil.copytree(ROOT / folder, copy / folder)
    shutil.copytree(ROOT / "frictionbench", copy / "frictionbench", symlinks=True)
    share_compiled(copy)
    return copy


def share_compiled(copy: Path) -> None:
    """What numba has compiled for this house serves the copy, whose files are as old and as long."""
    kept = Path(config.CACHE_DIR)
    for folder in {path.parent for path in copy.rglob("*.py")}:
        here, there = (
            _CacheLocator.get_suitable_cache_subpath(str(home / folder.relative_to(copy) / "any.py"))
            for home in (PACKAGE, copy / "frictionbench")
        )
        if (kept / here).is_dir():
            shutil.copytree(kept / here, copy / "compiled" / kept.name / there)


def follow(recipe: str, house: Path) -> str:
    """Write the files that a recipe gives, name its chart in the list, run its commands; what the last one printed."""
    for name, text in re.findall(r"Write `([\w/.]+)`:\n\n```python\n(.*?)```", recipe, re.S):
        lines = [line for line in text.splitlines() if line.strip()]
        assert len(lines) <= 20, f"{name} is no recipe of a few lines"
        (house / name).write_text(text, encoding="utf-8")
    if chart := re.search(r"add `(\w+)\.CHART` to `CHARTS`", recipe):
        charts = house / "reports" / "charts" / "__init__.py"
        text = charts.read_text(encoding="utf-8")
        text = re.sub(
            r"^(from frictionbench.reports.charts import) \(\n(.*?)^\)$",
            rf"\1 (\n\2    {chart[1]},\n)",
            text,
            flags=re.M | re.S,
        )
        text = re.sub(r"^CHARTS = \(\n(.*?)^\)$", rf"CHARTS = (\n\1    {chart[1]}.CHART,\n)", text, flags=re.M | re.S)
        charts.write_text(text, encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(house), "COLUMNS": "200", "NUMBA_CACHE_DIR": str(house / "compiled")}
    printed = ""
    for command in re.findall(r"^    frictionbench (.+)$", recipe, re.M):
        call = [sys.executable, "-c", "from frictionbench.harness.cli import main; main()", *command.split()]
        done = subprocess.run(call, cwd=house, env=environment, check=False, **PIPED)
        assert done.returncode == 0, done.stderr
        printed = done.stdout
    return printed


@pytest.fixture(scope="module")
def printed(house) -> dict[str, str]:
    return {name: follow(recipe, house) for name, recipe in RECIPES.items()}


@pytest.mark.parametrize("name", RECIPES)
def test_the_recipe_works(name, printed) -> None:
    for word in SHOWS[name]:
        assert word in printed[name]


def test_the_chart_is_on_the_page_and_in_the_paper(house, printed) -> None:
    run = house / "runs" / "brick"
    assert "Cells solved, trivial problems left out." in (run / "report.html").read_text(encoding="utf-8")
    assert (run / "paper" / "solved.pdf").exists()
    assert "paper:" in printed["Add a chart"]
