"""The page of a run of batches. Rates that say nothing are refused, with the reason; the others follow from the raw times."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.reports.batches import rate_of, write_batches
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
    fastest = rate_of(batch_row("lemke", "packed", times=[3e-3, 1e-3], base_times=[4e-3, 5e-3]))
    assert fastest == ["lemke", "packed", "cold", "1,000", "4"]


def test_it_has_no_figures(folder: Path) -> None:
    for option in ("--paper", "--markdown"):
        assert str(CliRunner().invoke(app, ["report", str(folder), option]).exception).startswith(f"{option[2:]}: ")


@in_browser
def test_page_looks(folder: Path) -> None:
    assert faults(write_batches(folder)) == []


@pytest.mark.parametrize(
    ("facts", "why"),
    [
        ({"contacts": 0}, "no contacts"),
        ({"idle": 1.0}, "friction is idle in all problems"),
        ({"active": 0.0}, "friction is idle in all problems"),
        ({"verified": 0.9996, "verdict": "wrong"}, "99.9 % verified"),
        ({"verified": 0.0, "verdict": "relaxed"}, "0 % verified"),
        ({"residual": 1e-7}, "residual above the tolerance"),
        ({"verdict": "skipped", "verified": None, "reason": "osqp not installed"}, "skipped: osqp not installed"),
        ({"verdict": "timeout", "verified": None, "reason": ""}, "timeout"),
        ({"times": []}, "not timed"),
        ({"base_times": [float("nan")]}, "not timed"),
    ],
)
def test_rates_that_say_nothing_are_refused(facts: dict[str, object], why: str) -> None:
    assert rate_of(batch_row("lemke", "packed", **facts))[3:] == [why, "–"]
