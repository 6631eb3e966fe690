"""docs/executable.md works as it is written: solvers in C, as an executable and as a shared library."""

import re
import shlex
import shutil
import stat
import subprocess
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.catalogue import scene
from frictionbench.problems.residual import residual
from frictionbench.solvers import Status, executable, find
from tests.helpers.friction_problems import nothing, spatial, with_joints
from tests.helpers.paths import ROOT

pytestmark = pytest.mark.slow  # the quick tests call no executable and no library in C

PAGE = (ROOT / "docs" / "executable.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```", PAGE, re.M | re.S))
COMMANDS = re.findall(r"^    (cc|frictionbench (?:solve|check-solver)) (.*)$", PAGE, re.M)
SCRIPT = "#!/bin/sh\n"


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    made = tmp_path / "a folder"
    made.mkdir()
    monkeypatch.chdir(made)
    return made


def script(folder: Path, name: str, text: str) -> str:
    """The command of a script of the shell, which gets the paths of the problem and of the answer."""
    (folder / name).write_text(SCRIPT + text, encoding="utf-8")
    (folder / name).chmod(stat.S_IRWXU)
    return f"exec:'{folder / name}' {{problem}} {{answer}}"


def solved(command: str, problem: FrictionProblem, limit: int | None = None):
    """The answer of a command in this process."""
    name = executable.register(executable.absolute(command))
    _, solver = find(name)
    return solver.solve(solver.prepare(problem), 1e-8, limit)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_recipes_of_the_page(folder) -> None:
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    Path("sweeps.py").chmod(stat.S_IRWXU)
    shown = []
    for tool, rest in COMMANDS:
        if tool == "cc":
            subprocess.run(["cc", "-Wall", "-Werror", *shlex.split(rest)], check=True)
        else:
            done = CliRunner().invoke(app, [tool.split()[1], *shlex.split(rest)], env={"COLUMNS": "200"})
            assert done.exit_code == 0, done.output
            shown.append(done.output)
    results = (r"1 +sweeps +solved", r"1 +sweeps\.py +solved", r"^\d+ passed, \d+ not applicable$", r"1 +impulses +solved")
    for output, result in zip(shown, results, strict=True):
        assert re.search(result, output.strip(), re.M)
    for problem in (spatial(1, contacts=3), nothing(), with_joints(spatial(3, contacts=3), np.eye(1, 18))):
        for program in ("sweeps", "sweeps.py"):
            copy = shutil.copy(program, f"{program}{problem.contacts}{len(problem.joint_bias)}")
            answer = solved(f"exec:./{copy} {{problem}} {{answer}}", problem)
            assert answer.status is Status.SOLVED
            assert residual(problem, answer.impulse) <= 1e-8
            assert (answer.clock is None) == (program == "sweeps.py")
            assert answer.work["sweeps"] > 0 or not problem.contacts


def test_the_problems_file_is_the_problem(folder) -> None:
    problem = with_joints(spatial(3, contacts=3), np.eye(1, 18))
    command = script(
        folder, "copies", f"cp $1 '{folder}/seen.txt'; printf 'status failed\\nimpulse\\n0 0 0\\n0 0 0\\n0 0 0\\n' > $2"
    )
    assert solved(command, problem, limit=7).status is Status.FAILED
    words = (folder / "seen.txt").read_text(encoding="ascii").split()
    head = f"tolerance 1e-08 velocity_tolerance {1e-8 * float(problem.units.min())!r} limit 7 dimension 3 contacts 3 "
    assert words[:14] == f"{head} velocities {len(problem.free_velocity)} joints 1".split()
    W, J = problem.W.toarray(), np.zeros((9, len(problem.free_velocity)))
    J[0::3], rows = problem.normal.toarray(), problem.tangent.toarray()
    J[1::3], J[2::3] = rows[0::2], rows[1::2]
    for name, dense in (("W", W), ("M", problem.mass.toarray()), ("J", J), ("F", problem.joints.toarray())):
        at = words.index(name) + 1
        entries = np.array(words[at + 1 : at + 1 + 3 * int(words[at])], float).reshape(-1, 3)
        found = np.zeros_like(dense)
        found[entries[:, 0].astype(int), entries[:, 1].astype(int)] = entries[:, 2]
        assert np.array_equal(found, dense), name
    for name, values in (
        *(("friction", problem.friction), ("friction_bias", problem.friction_bias), ("q", problem.q)),
        *(("v", problem.free_velocity), ("offset", problem.offset.ravel()), ("joint_bias", problem.joint_bias)),
    ):
        at = words.index(name) + 1
        assert np.array_equal(np.array(words[at + 1 : at + 1 + int(words[at])], float), values), name


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("exit 3", None),
        ("echo out of luck; exit 3", None),
        ("kill -9 $$", None),
        ("true", "wrote no file"),
        ("echo status solved > $2", "no line impulse"),
        ("head -c 4000 /dev/urandom > $2", "answer"),
        ("printf 'status solved\\nimpulse\\n1 x\\n' > $2", "could not convert"),
        ("printf 'status great\\nimpulse\\n' > $2", "status must be"),
        ("printf 'status solved\\nsweeps many\\nimpulse\\n' > $2", "invalid literal"),
    ],
)
def test_bad_executables_are_failures_or_errors(folder, text, said) -> None:
    problem = scene("stack", blocks=1).problem()
    command = script(folder, f"bad{abs(hash(text))}", text)
    if said is None:
        answer = solved(command, problem)
        assert answer.status is Status.FAILED
        assert ("exit code 3" in answer.detail) or ("signal 9" in answer.detail)
        assert ("out of luck" in answer.detail) == ("luck" in text)
    else:
        with pytest.raises(ValueError, match=said):
            solved(command, problem)


@pytest.mark.parametrize(
    ("first", "told"), [("", "needs a first line #!"), ("#!/no/shell\n", "or what its #! names"), ("#!/\n", "")]
)
def test_why_a_script_cannot_be_started(folder, first, told) -> None:
    command = script(folder, name := f"plain{len(first)}", "")
    (folder / name).write_text(f"{first}echo status solved > $2\n", encoding="utf-8")
    with pytest.raises(ValueError, match=f"{name}: ") as caught:
        solved(command, scene("stack", blocks=1).problem())
    assert (told in str(caught.value)) if told else "#!" not in str(caught.value)
    (folder / name).chmod(0o644)
    with pytest.raises(InputError, match=rf"is not an executable file; chmod \+x .*{name}$"):
        load_plugins([command])


def test_a_run_judges_hangs_and_wrong_shapes(folder) -> None:
    hangs = script(folder, "hangs", "sleep 1000")
    short = script(folder, "short", "printf 'status solved\\nimpulse\\n1 2\\n' > $2; echo here > here")
    garbage = script(folder, "garbage", "echo garbage > $2")
    shown = ""
    for limit, commands in (("2", [hangs]), ("60", [short, garbage])):
        named = [part for command in commands for part in ("--solver", command)]
        done = CliRunner().invoke(app, ["solve", "stack[blocks=1]", "--time-limit", limit, *named], env={"COLUMNS": "200"})
        assert done.exit_code == 0, done.output
        shown += done.output
    for name, verdict in (("hangs", "timeout"), ("short", "wrong"), ("garbage", "crashed")):
        assert re.search(rf"\d +{name} +{verdict}", shown), shown
    assert ("line 1" in shown, "(at " in shown) == (True, False)
    assert sorted(path.name for path in folder.iterdir()) == ["garbage", "hangs", "short"]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("exec:'./open {problem} {answer}", "is no command"),
        ("exec:./missing {problem} {answer}", "is not an executable file"),
        ("exec:sh {problem}", "lacks {answer}"),
    ],
)
def test_bad_commands_are_input_errors(command, said) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        load_plugins([command])
