"""Trouble with a command's output ends in an exit code of its own, never in that of a regression."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from frictionbench.commands import cli
from tests.helpers.made_results import solve_row, write_folder

SHELL = f"{sys.executable} -m frictionbench"


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> dict[str, Path]:
    home = tmp_path_factory.mktemp("runs")
    return {
        "before": write_folder(home / "before", [solve_row("µ→", "p")]),
        "same": write_folder(home / "same", [solve_row("µ→", "p")]),
        "worse": write_folder(home / "worse", [solve_row("µ→", "p", verdict="wrong")]),
    }


def shell(command: str, **environment: str) -> tuple[int, str]:
    """The exit code of the first command of a pipe, and all error output."""
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", command], env=os.environ | environment, capture_output=True, check=False, timeout=120
    )
    return done.returncode, done.stderr.decode()


@pytest.mark.parametrize(
    ("pair", "ending", "code", "told"),
    [
        ("before same", "", 0, ""),
        ("before worse", "> /dev/null", 1, ""),
        ("before worse", "| true", 141, ""),
        ("before worse", "> /dev/full", 2, "frictionbench: standard output: No space left on device\n"),
        ("before worse", ">&-", 1, ""),
        ("before same", ">&- 2>&-", 0, ""),
        ("before nowhere", "2> /dev/full", 2, ""),
    ],
)
def test_comparison_with_unwritable_output(runs, pair, ending, code, told) -> None:
    folders = " ".join(str(runs.get(name, name)) for name in pair.split())
    assert shell(f"{SHELL} compare {folders} {ending}") == (code, told)


@pytest.mark.parametrize(
    "environment", [{"PYTHONIOENCODING": "ascii"}, pytest.param({"LC_ALL": "C", "PYTHONUTF8": "0"}, marks=pytest.mark.slow)]
)
def test_comparison_in_ascii(runs, environment) -> None:
    for folder, code in (("same", 0), ("worse", 1)):
        assert shell(f"{SHELL} compare {runs['before']} {runs[folder]}", **environment) == (code, "")
    assert shell(f"{SHELL} compare --history {runs['before']} {runs['worse']}", **environment) == (0, "")


@pytest.mark.parametrize("environment", [{"PYTHONOPTIMIZE": "2"}, {"NUMBA_NUM_THREADS": "0"}])
def test_environments_in_which_no_command_runs(environment) -> None:
    code, told = shell(f"{SHELL} list scenes", **environment)
    assert (code, len(told.splitlines())) == (2, 1)


@pytest.mark.parametrize(("name", "told"), [("$'\\xff'", "not UTF-8 cannot be stored"), ("-q", "read it as an option")])
def test_names_that_are_refused(tmp_path, name, told) -> None:
    code, said = shell(f"cd {tmp_path} && {SHELL} run smoke --out {name}")
    assert (code, told in " ".join(said.split()), [*tmp_path.iterdir()]) == (2, True, [])


def test_error_of_our_own(monkeypatch, capsys) -> None:
    def broken() -> None:
        raise RuntimeError("broken")

    monkeypatch.setattr(cli, "app", broken)
    monkeypatch.setattr(cli, "_SIGNALS", ())
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 3
    assert "RuntimeError: broken" in capsys.readouterr().err
