"""The command line on a terminal: tables and lists at 80 columns, completion by shells, and names that are mistyped."""

import os
import subprocess
import sys

import pytest

from frictionbench.harness.commands import listing, table
from frictionbench.harness.commands.table import columns, paragraph
from tests.helpers.command_line import frictionbench
from tests.helpers.paths import ROOT


def test_columns_left_out_are_named() -> None:
    rows = [("lemke", "solved", "pivots 12" * 9)]
    *lines, told = columns(("solver", "verdict", "work"), rows, 80, ("work",))
    assert lines == ["solver  verdict", "lemke   solved"]
    assert told == "not shown on 80 columns: work; a wider terminal or a file has all"
    assert len(columns(("solver", "verdict", "work"), rows, None, ("work",))) == 2


def test_lines_break_between_words() -> None:
    (first, second) = paragraph("a " + "x" * 90, 80)
    assert (first.strip(), second.strip()) == ("a", "x" * 90)


def test_scenes_are_listed_once(capsys, monkeypatch) -> None:
    monkeypatch.setattr(table, "screen", lambda: 80)
    listing.show("scenes")
    told = capsys.readouterr().out
    assert "\nexample_3\n" not in told
    assert "also under the name example_3, which is two_blocks[]; example_4, which is two_blocks[friction=0.1]" in told.replace(
        "\n    ", " "
    )


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands(shell) -> None:
    words = {"bash": {"COMP_WORDS": "frictionbench sh", "COMP_CWORD": "1"}}.get(
        shell, {"_TYPER_COMPLETE_ARGS": "frictionbench sh"}
    )
    words |= {
        "_FRICTIONBENCH_COMPLETE": f"complete_{shell}",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "PYTHONPATH": str(ROOT),
    }
    call = "import sys; sys.argv = ['frictionbench']; from frictionbench.harness.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", call], env=os.environ | words, capture_output=True, text=True, check=True)
    assert "show" in done.stdout
    assert "shrink" in done.stdout
    assert "lemke" not in done.stdout


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (("sovle", "stack"), "Did you mean 'solve'?"),
        (("solve", "stak"), "scene: unknown scene 'stak' (did you mean stack?)"),
        (("solve", "stack[block=2]"), "block: the scene stack has no such parameter (did you mean blocks?)"),
        (("solve", "stack", "--solver", "lemka"), "solver: unknown solver 'lemka' (did you mean lemke?)"),
        (("solve", "stack", "--solver", "nsgs[relax=1]"), "solver: nsgs has no setting 'relax' (did you mean relaxation?)"),
        (("run", "smok"), "suite: unknown suite 'smok' (did you mean smoke?)"),
        (("show", "stack", "--scheme", "moro"), "scheme: unknown scheme 'moro' (did you mean moreau?)"),
    ],
)
def test_mistyped_names(command, told) -> None:
    done = frictionbench(*command)
    assert done.returncode == 2
    assert told in done.stderr
