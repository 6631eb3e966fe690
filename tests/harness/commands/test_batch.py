"""The page on rates of many problems: what it refuses to show."""

from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from frictionbench.harness.cli import app
from frictionbench.harness.commands import batch, large
from frictionbench.harness.commands.batch import Case, Rate, make_case, refusal, table
from frictionbench.solvers import available

MISSING = SimpleNamespace(missing="left out: it would be compiled")

CASE = Case(4, 2, (), active=0.9, idle=0.1)
RATE = Rate("lemke, packed", 5.0, 1.0, (0.1, 0.2, 0.3), 1.9)


@pytest.mark.parametrize(
    ("case", "rate", "why"),
    [
        (CASE, RATE, ""),
        (Case(0, 2, (), 0.0, 0.0), RATE, "no contacts"),
        (Case(4, 2, (), 0.9, 1.0), RATE, "friction is idle"),
        (Case(4, 2, (), 0.0, 0.1), RATE, "friction is idle"),
        (CASE, Rate("osqp, single calls", 9.0, 0.25), "25 % verified"),
    ],
)
def test_rates_that_say_nothing_are_refused(case: Case, rate: Rate, why: str) -> None:
    assert refusal(case, rate).startswith(why)
    assert bool(refusal(case, rate)) == bool(why)
    shown = table(case, [rate])
    assert (f"| {rate.ratio:.2g} |" in shown) == (not why)


@pytest.mark.parametrize(("dimension", "contacts"), [(2, 2), (3, 4)])
def test_cases_are_the_same_each_time(dimension: int, contacts: int) -> None:
    one, other = make_case(dimension, contacts, 3), make_case(dimension, contacts, 3)
    assert [problem.hash for problem in one.problems] == [problem.hash for problem in other.problems]
    assert len({problem.hash for problem in one.problems}) == 3
    assert np.isclose(one.active, 1.0)


def test_the_command_writes_a_table_of_verified_rates(tmp_path, monkeypatch) -> None:
    for name, value in {
        "ROUNDS": 1,
        "SHORT": 0.0,
        "ALONE": (),
        "available": lambda: {**available(), "quantecon": MISSING},
    }.items():
        monkeypatch.setattr(batch, name, value)
    shown = CliRunner().invoke(
        app, ["batch", "--contacts", "2,4", "--count", "3", "--solver", "lemke", "--out", str(tmp_path / "rates.tsv")]
    )
    assert shown.exit_code == 0
    assert shown.output.count("| lemke, packed |") == 2
    header, *rows = [line.split("\t") for line in (tmp_path / "rates.tsv").read_text().splitlines()]
    assert header == list(batch.COLUMNS)
    assert [(row[1], row[4]) for row in rows] == [
        (contacts, way) for contacts in "24" for way in ("lemke, single calls", "lemke, packed", "lemke, with packing")
    ]
    assert all(float(row[5]) > 0 and float(row[7]) == 1 for row in rows)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (["--contacts", "3"], "contacts"),
        (["--contacts", "two"], "contacts"),
        (["--count", "0"], "count"),
        (["--workers", "0"], "workers"),
        (["--solver", "lemkke"], "solver"),
        (["--space", "--contacts", "6"], "contacts"),
    ],
)
def test_what_cannot_be_timed_is_named(arguments: list[str], field: str) -> None:
    done = CliRunner().invoke(app, ["batch", *arguments])
    assert done.exit_code != 0
    assert str(done.exception).startswith(f"{field}:")


def test_large_problems_are_told_with_what_was_not_run(monkeypatch) -> None:
    monkeypatch.setattr(large, "FAMILIES", {"stack of boxes": ("stack", "blocks", (2, 4)), "chain": ("chain", "links", (3,))})
    monkeypatch.setattr(large, "ROUNDS", 1)
    monkeypatch.setattr(large, "STORAGE", 8 * 2 * 16**2)  # of two matrices of the first stack's size
    rows = [line.split("|")[1:-1] for line in large.section().splitlines() if line.startswith("| ") and "growth" not in line]
    assert [[cell.strip() for cell in row[:3]] for row in rows] == [["2", "4", "16"], ["4", "8", "32"], ["3", "6", "24"]]
    assert all(float(row[4]) > 0 for row in rows)
    assert float(rows[0][6]) > 0
    assert [row[6].strip() for row in rows[1:]] == ["–", "–"]
