"""Exported files: what their suffix says, in the folder that was named, also where the run's folder was edited."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from frictionbench.commands.export import export
from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.stored import stored_start
from frictionbench.harness.plans.plan import Source, origin
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scene
from frictionbench.problems.recorded import native
from tests.helpers.command_line import frictionbench
from tests.helpers.friction_problems import block
from tests.helpers.made_results import write_folder
from tests.helpers.runs import soon

MOTION = Source("stopping_block", {}, pick=3, steps=6)


def test_export_writes_what_the_suffix_says(tmp_path) -> None:
    (path,) = export("stack[blocks=2]", tmp_path / "stack.npz")
    assert native.load(path).hash == scene("stack", blocks=2).problem().hash
    with pytest.raises(InputError, match=r"^out: .*stack\.txt must end in .hdf5, .h5, .npz, or name a folder"):
        list(export("stack[blocks=2]", tmp_path / "stack.txt"))
    assert not (tmp_path / "stack.txt").exists()
    with pytest.raises(InputError, match=r"^DIR: .* holds no problems"):
        list(export(str(write_folder(tmp_path / "run", [])), tmp_path / "files"))


@pytest.fixture
def collected(tmp_path) -> Path:
    """A folder with the problems of a motion, without rows."""
    write_folder(tmp_path / "run", [])
    collect(tmp_path / "run", MOTION)
    return tmp_path / "run"


def test_a_problem_of_two_sources_is_written_once(collected, tmp_path) -> None:
    (path,) = collected.glob("problems/source-*.json")
    path.with_name("source-2.json").write_bytes(path.read_bytes())
    written = list(export(str(collected), tmp_path / "files"))
    assert len(written) == len(set(written)) == len(json.loads(path.read_text(encoding="utf-8")))
    written[0].unlink()
    assert list(export(str(collected), tmp_path / "files")) == written  # as after an interruption


def test_problems_that_fclib_cannot_represent(collected, tmp_path) -> None:
    """In a folder they are .npz; a file of another kind is refused with the problem's name."""
    biased = tmp_path / "biased.npz"
    native.save(block().replace(friction_bias=np.ones(1)), biased)
    collect(collected, Source("biased", {"file": biased.name}, file=str(biased)))
    assert sorted(path.suffix for path in export(str(collected), tmp_path / "files")) == [".hdf5"] * 3 + [".npz"]
    with pytest.raises(InputError, match=r"^out: FCLIB's format .* robot_step.*as \.npz"):
        list(export("robot_step[case=adroit_door-grasp-429]", tmp_path / "one.hdf5"))


EDITS = {
    "scene": ["../../escaped", 1, "\x1b[31m"],
    "step": ["1", None, 2**70],
    "contacts": ["../../escaped", 1.5],
    "problem": ["../../escaped", None],
    "starts": [None, {"cold": "", "other": ""}],
    "parameters": [None, "[" * 10**5],
    "dimension": [KeyError],
}


@pytest.mark.parametrize(("field", "value"), [(field, value) for field, values in EDITS.items() for value in values])
def test_edited_records(collected, tmp_path, field, value) -> None:
    """What is exported stays in the folder that was named; a resumed run collects again what it cannot use."""
    (path,) = collected.glob("problems/source-*.json")
    records = json.loads(path.read_text(encoding="utf-8"))
    last = {name: part for name, part in records[-1].items() if (name, value) != (field, KeyError)}
    edited = last if value is KeyError else last | {field: value}
    path.write_text(json.dumps([*records[:-1], edited]), encoding="utf-8")
    done = frictionbench("export", str(collected), "--out", str(tmp_path / "out" / "files"))
    assert done.returncode in (0, 2), done
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) <= 1
    assert not [*tmp_path.glob("*escaped*"), *Path("/").glob("escaped*")]
    assert collect(collected, MOTION) == records


def test_starts_of_another(collected) -> None:
    """A start that was edited since its problem was collected is not used."""
    (path,) = collected.glob("problems/source-*.json")
    record = json.loads(path.read_text(encoding="utf-8"))[-1]
    (starts,) = collected.glob(f"problems/{record['problem']}.*.starts.npz")
    given = collected, record["problem"], origin(record), "warm", record["starts"]["warm"]
    good = stored_start(*given)
    with np.load(starts) as stored:
        np.savez(starts, **{name: 2.0 * value for name, value in stored.items()})
    assert good.any()
    with pytest.raises(InputError, match=r"holds another start warm than the one that was collected"):
        stored_start(*given)


def test_a_killed_export_leaves_no_temporary_folder(tmp_path) -> None:
    code = "files = export('stack[blocks=1]', Path('one.npz')); next(files); os.kill(os.getpid(), 9)"
    code = f"import os; from pathlib import Path; from frictionbench.commands.export import export; {code}"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=os.environ | {"TMPDIR": str(tmp_path)}, check=False)
    assert soon(lambda: [path.name for path in tmp_path.iterdir()] == ["one.npz"])
