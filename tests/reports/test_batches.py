"""The page of a run of batches."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.reports.batches import write_batches
from tests.helpers.browser import faults, in_browser
from tests.helpers.made_results import SETTINGS, batch_row, write_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rows = [batch_row("lemke", "packed"), batch_row("<b>", "calls", verified=0.5, verdict="relaxed", model="relaxation")]
    return write_folder(tmp_path, [], batches=rows, settings=SETTINGS | {"batches": [{"scene": "stack"}]})


def test_the_page_shows_rates_and_what_is_refused(folder: Path) -> None:
    assert CliRunner().invoke(app, ["report", str(folder)]).exit_code == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<td>1,000</td><td>2</td>" in page
    assert "<td>50 % verified</td><td>–</td>" in page
    assert "&lt;b&gt; (another law)" in page
    assert "lemke (" not in page
    assert "<b>" not in page


@pytest.mark.parametrize("option", ["--paper", "--markdown"])
def test_it_has_no_figures(option: str, folder: Path) -> None:
    done = CliRunner().invoke(app, ["report", str(folder), option])
    assert str(done.exception).startswith(f"{option[2:]}: ")


@in_browser
def test_page_looks(folder: Path) -> None:
    assert faults(write_batches(folder)) == []
