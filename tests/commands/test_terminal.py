"""The command line on a terminal: tables and lists at 80 columns, completion by shells, and names that are mistyped."""

import pytest
import rich.console

from frictionbench.commands import listing, table
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import solve_row, write_folder


def test_scenes_are_listed_once(capsys, monkeypatch) -> None:
    monkeypatch.setattr(table, "screen", lambda: 80)
    listing.show("scenes")
    told = capsys.readouterr().out
    assert "\nexample_3  (" not in told
    assert "\nbox_tower  (spatial)\n" in told
    assert "\nlocal_graph  (planar; a problem of one step)\n" in told
    assert "walls lower it." in told
    assert "also under the name example_3, which is two_blocks[]; example_4, which is two_blocks[friction=0.1]" in told.replace(
        "\n    ", " "
    )


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (("sovle", "stack"), "Did you mean 'solve'?"),
        (("solve", "stack[block=2]"), "block: the scene stack has no such parameter (did you mean blocks?)"),
        (("solve", "stack", "--solver", "lemka"), "solver: unknown solver 'lemka' (did you mean lemke?)"),
        (("solve", "stack", "--solver", "nsgs[relax=1]"), "solver: nsgs has no setting 'relax' (did you mean relaxation?)"),
        (("run", "smok"), "suite: unknown suite 'smok' (did you mean smoke?)"),
        (("solve", "recorded_step[case=near_jab]"), "case: unknown step 'near_jab' (did you mean near_jam?)"),
        (("solve", "cubs"), "scene: unknown scene 'cubs' (did you mean cubes?)"),
        (("show", "stack", "--scheme", "moro"), "scheme: unknown scheme 'moro' (did you mean moreau?)"),
    ],
)
def test_mistyped_names(command, told) -> None:
    done = frictionbench(*command)
    assert done.returncode == 2
    assert told in done.stderr


def test_a_comparison_is_laid_out_on_a_terminal(tmp_path, monkeypatch) -> None:
    """And Markdown in a pipe."""
    runs = [str(write_folder(tmp_path / name, [solve_row("lemke", "p", verdict=name)])) for name in ("solved", "wrong")]
    piped = frictionbench("compare", *runs)
    assert piped.stdout.startswith("## worse 1 ")
    monkeypatch.setattr(rich.console.Console, "is_terminal", property(lambda self: True))
    shown = frictionbench("compare", *runs)
    assert (shown.returncode, piped.returncode) == (1, 1)
    assert "##" not in shown.stdout
    assert "worse 1" in shown.stdout
