"""What cannot be used is refused before anything is built, started or written; scenes are built behind a worker's limits."""

import resource

import pytest

from frictionbench.harness.maps import plan_map
from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.harness.workers import inputs
from frictionbench.problems import InputError, catalogue
from tests.helpers.command_line import frictionbench

COMPILING = "kernels are compiled for their first use: a minute for a few solvers, minutes for all of them\n"


def test_scenes_are_not_built_in_the_main_process(monkeypatch) -> None:
    assert catalogue.scenes() | catalogue.instances()  # registered
    monkeypatch.setattr(catalogue.Generator, "make", property(lambda self: pytest.fail("built")), raising=False)
    assert choose(RunOptions("smoke", ["stack[blocks=3000000]"])).sources[0].parameters == {"blocks": 3000000}
    plan_map("stack[blocks=3000000]", "friction=.1:1:3", "push=0:1:3")


def test_scenes_that_cannot_be_made(tmp_path, monkeypatch) -> None:
    out = tmp_path / "out"
    for command in (
        ("run", "smoke", "--scene", "stack[blocks=-1]", "--out", str(out)),
        ("map", "stack", "--x", "friction=.1:1:3", "--y", "blocks=-1:3:3", "--out", str(out)),
    ):
        done = frictionbench(*command)
        said = done.stderr.removeprefix(COMPILING)  # of the first process only
        assert (done.returncode, len(said.splitlines())) == (2, 1), done
        assert ("must be" in done.stderr, out.exists()) == (True, False)
    done = frictionbench("run", "smoke", "--scene", "stack", "--out", str(tmp_path.parent))  # a folder that holds tmp_path
    assert done.stderr.removeprefix(COMPILING).startswith(
        f"frictionbench: {tmp_path.parent}: neither empty nor a results folder"
    ), done.stderr
    monkeypatch.setattr(inputs, "BUILD_SECONDS", 0.5)
    with pytest.raises(InputError, match=r"^scene: stack\[blocks=3000000\] cannot be made \(stopped at its limit of 0.5 s\)"):
        inputs.require_buildable([("stack", {"blocks": 3000000})])


def test_scenes_beyond_the_memory_limit(tmp_path, monkeypatch) -> None:
    """They are refused in the process that builds them, which has the limit during that only."""
    assert frictionbench("export", "stack[blocks=2]", "--out", str(tmp_path / "small.hdf5")).returncode == 0  # compiles
    (tmp_path / "small.hdf5").unlink()
    before = resource.getrlimit(resource.RLIMIT_AS)
    monkeypatch.setattr("frictionbench.commands.export.MEMORY_LIMIT", 2**22)
    done = frictionbench("export", "stack[blocks=20000]", "--out", str(tmp_path / "out.hdf5"))
    assert (done.returncode, done.stderr) == (2, "frictionbench: memory: more than 0.00390625 GiB would be needed\n"), done
    assert not list(tmp_path.iterdir())
    assert resource.getrlimit(resource.RLIMIT_AS) == before


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("run smoke --solver nothing_here.py", "nothing_here.py"),
        ("run smoke --time-limit 0", "time-limit: must be positive, got 0"),
        ("run smoke --scene stack --cluster x", "cluster: no scheduler answers at x"),
        ("run smoke --tol -1", "tol: must lie between 0 and 1, got -1"),
        ("compare a b --slowdown 0.9", "Invalid value for '--slowdown': "),
        ("report a --figures profiles", "frictionbench: paper: "),
        ("judge . --tol 0", "tol: must lie between 0 and 1, got 0"),
        ("compare a.tsv b", "no such baseline; compare --accept writes one"),
        ("compare --history a b --out c", "frictionbench: history: "),
        ("compare a b --slowdown inf", "slowdown: must be finite"),
        ("compare a b --accept --confirm", "frictionbench: accept: neither --history nor --accept can be combined with"),
        (f"compare a {__file__}", "frictionbench: DIR: "),
        ("solve stack[blocks=2,blocks=3]", "scene: the setting 'blocks' of stack is given twice"),
        ("solve stack[block=2]", "block: the scene stack has no such parameter (did you mean blocks?)"),
        ("solve stack --solver a/x.py[omega=1]", "solver; write --solver a/x.py --solver 'NAME[omega=1]'"),
        ("solve stack --solver ./x", "'./x'; write name or name[setting=value,...], FILE.py or"),
        ("run smoke --solver lemke[facets=7]", "solver: lemke[facets=7]: facets: must be even and at least 4, got 7"),
        ("solve stack --solver nsgs[precision=half]", "solver: nsgs[precision=half]: precision must be one of"),
        ("solve stack --solver lemka", "solver: unknown solver 'lemka' (did you mean lemke?)"),
        (f"solve {__file__}", "no problem file; known are .npz"),
        ("run --suite smoke", "the suite is an argument"),
    ],
)
def test_combinations_without_a_meaning(command, told, tmp_path) -> None:
    done = frictionbench(*command.split(), cwd=tmp_path)
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert told in done.stderr + done.stdout


def test_a_file_named_without_its_suffix(tmp_path) -> None:
    (tmp_path / "mine.py").touch()
    told = frictionbench("solve", "stack", "--solver", "mine", cwd=tmp_path).stderr
    assert "unknown solver 'mine' (did you mean the file mine.py?)" in told
