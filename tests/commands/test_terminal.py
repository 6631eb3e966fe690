"""The command line on a terminal: tables and lists at 80 columns, completion by shells, and names that are mistyped."""

import pytest

from tests.helpers.command_line import frictionbench


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
