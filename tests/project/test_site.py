"""The documentation as a site, in a browser: pages with tables, code, the public face and figures."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.browser import faults, in_browser
from tests.helpers.paths import ROOT

LONG = ("api", "battery", "peers", "studies", "commands")  # for their tables and sections axe takes minutes


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    pytest.importorskip("furo")
    made = tmp_path_factory.mktemp("html")
    command = ["-m", "sphinx", "--quiet", "--fail-on-warning", "--doctree-dir", made / "trees", ROOT / "docs", made / "site"]
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, done.stderr
    return made / "site"


@in_browser
@pytest.mark.parametrize("name", ["index", "published", "figures", "search", "notebooks/choose", *LONG])
def test_pages_look(site, name) -> None:
    assert faults(site / f"{name}.html", accessible=name not in LONG) == []
    assert '<span class="unbroken">--paper</span>' in (site / "figures.html").read_text(encoding="utf-8")
