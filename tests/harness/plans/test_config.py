"""Options of a run in a file: the command line comes first, and a run is made like another from its manifest."""

import os
from typing import Any

import pytest

from frictionbench.harness.plans.choose import RunOptions, choose, read_options
from frictionbench.harness.plans.recorded import located
from frictionbench.harness.run import open_folder
from frictionbench.problems import InputError

TEXT = 'suite = "smoke"\nsolver = ["lemke", "nsgs[relaxation=1.3]"]\ntol = "1e-4"\ntime_limit = 2\nscene = ["stack"]\n'


def test_a_run_is_made_like_another(tmp_path) -> None:
    (tmp_path / "run.toml").write_text(TEXT)
    wanted = RunOptions(tol="1e-6").before(read_options(tmp_path / "run.toml"))
    plan = choose(wanted, tuple(wanted.solver))
    assert (plan.suite, plan.solvers, plan.tolerances, plan.time_limit) == ("smoke", tuple(wanted.solver), (1e-6,), 2)
    assert "options" not in plan.settings()
    open_folder(plan, tmp_path / "out")
    again = read_options(tmp_path / "out")
    assert choose(again, tuple(again.solver)) == plan


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('suit = "smoke"', r"unknown option 'suit' \(did you mean suite\?\); known are suite, "),
        ("solver = [1]", r"solver: expected a valid string, got \[1\]"),
        ("time_limit = true", "time_limit: expected a valid number, got True"),
        ('solver = ["exec:./program {problem} {answer}"]', "is code; name it with --solver"),
        ('solver = ["mine.py"]', "is code; name it with --solver"),
        ("suite = ", "Invalid value"),
        (r'out = "a\u0000b"', "out: .*, got 'a"),
        (r'data = ["a\u0000b"]', r"data: .*, got \['a"),
        ('out = ""', "out: .*, got ''"),
        (f"suite = {'[' * 9999}", "maximum recursion depth"),
    ],
)
def test_unusable_files_are_named(tmp_path, text, told) -> None:
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(InputError, match=f"^config: .*run.toml: {told}" if "code" not in told else f"^config: .*{told}$"):
        read_options(tmp_path / "run.toml")


def test_a_folder_of_data_that_cannot_be_read_is_told(tmp_path, monkeypatch) -> None:
    """Its problems must not be missing without a word."""
    (tmp_path / "closed").mkdir()
    (tmp_path / "run" / "problems").mkdir(parents=True)
    for name in ("a.npz", ".hidden.npz", "run/manifest.json", "run/problems/copy.npz"):
        (tmp_path / name).touch()
    assert [source.parameters["file"] for source in located(str(tmp_path))] == ["a.npz"]
    read = os.scandir

    def refused(folder: str) -> Any:
        if str(folder).endswith("closed"):
            raise PermissionError(13, "Permission denied", str(folder))
        return read(folder)

    monkeypatch.setattr("os.scandir", refused)
    with pytest.raises(PermissionError):
        located(str(tmp_path))
