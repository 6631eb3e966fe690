"""What cannot be used is refused before anything is built, started or written; scenes are built behind a worker's limits."""

import resource

import pytest

from frictionbench.harness.maps import plan_map
from frictionbench.harness.plans.choose import choose
from frictionbench.harness.workers import inputs
from frictionbench.problems import InputError, catalogue
from tests.helpers.command_line import frictionbench


def test_scenes_are_not_built_in_the_main_process(monkeypatch) -> None:
    assert catalogue.scenes() | catalogue.instances()  # registered
    monkeypatch.setattr(catalogue.Generator, "make", property(lambda self: pytest.fail("built")), raising=False)
    assert choose("smoke", ["stack[blocks=3000000]"], (), None, None).sources[0].parameters == {"blocks": 3000000}
    plan_map("stack[blocks=3000000]", "friction=.1:1:3", "push=0:1:3")


def test_scenes_that_cannot_be_made(tmp_path, monkeypatch) -> None:
    out = tmp_path / "out"
    for command in (
        ("run", "smoke", "--scene", "stack[blocks=-1]", "--out", str(out)),
        ("run", "smoke", "--scene", "cubes[boxes=-1]", "--out", str(out)),
        ("map", "stack", "--x", "friction=.1:1:3", "--y", "blocks=-1:3:3", "--out", str(out)),
    ):
        done = frictionbench(*command)
        assert (done.returncode, len(done.stderr.splitlines())) == (2, 1), done
        assert "must be" in done.stderr
        assert not out.exists()
    monkeypatch.setattr(inputs, "BUILD_SECONDS", 0.5)
    with pytest.raises(InputError, match=r"^scene: stack\[blocks=3000000\] cannot be made \(stopped at its limit of 0.5 s\)"):
        inputs.require_buildable([("stack", {"blocks": 3000000})])


def test_an_address_without_scheduler_is_refused_before_the_problems_are_made(tmp_path) -> None:
    done = frictionbench("run", "smoke", "--scene", "stack", "--cluster", "x", "--out", str(tmp_path / "out"))
    assert done.returncode == 2
    assert "cluster: no scheduler answers at x" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["export", "show"])
def test_scenes_beyond_the_memory_limit(command, tmp_path, monkeypatch) -> None:
    """They are refused in the process that builds them, which has the limit during that only."""
    assert frictionbench(command, "stack[blocks=2]", "--out", str(tmp_path / "small.hdf5")).returncode == 0  # compiles
    (tmp_path / "small.hdf5").unlink()
    before = resource.getrlimit(resource.RLIMIT_AS)
    monkeypatch.setattr(f"frictionbench.commands.{command}.MEMORY_LIMIT", 2**22)
    done = frictionbench(command, "stack[blocks=20000]", "--out", str(tmp_path / "out.hdf5"))
    assert (done.returncode, done.stderr) == (2, "frictionbench: memory: more than 0.00390625 GiB would be needed\n"), done
    assert not list(tmp_path.iterdir())
    assert resource.getrlimit(resource.RLIMIT_AS) == before


@pytest.mark.parametrize(
    ("command", "field"),
    [
        (("compare", "a"), "DIR"),
        (("compare", "a", "b", "c"), "DIR"),
        (("compare", "a", __file__), "DIR"),
        (("export", "stack"), "out"),
        (("export", "fclib/Chain", "--out", "x"), "out"),
    ],
)
def test_combinations_without_a_meaning(command, field, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = frictionbench(*command)
    assert (done.returncode, done.stderr.partition(": ")[2].split(":")[0]) == (2, field), done
    assert not list(tmp_path.iterdir())
