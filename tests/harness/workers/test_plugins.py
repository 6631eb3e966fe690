"""Plug-ins run only if the user names them, are identified by content, and their errors have file and line."""

import os
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from frictionbench.commands.shrink import shrink
from frictionbench.commands.single import rerun_row
from frictionbench.harness import machine
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import InputError
from frictionbench.results.files import ResultsError
from tests.helpers.plugin import write
from tests.helpers.runs import run_of


def test_plugin_is_imported_in_workers_only(tmp_path) -> None:
    trace, before = tmp_path / "trace", set(sys.modules)
    plugin = write(tmp_path / "guest.py", first=f"import os; open({str(trace)!r}, 'a').write(str(os.getpid()) + ' ')")
    variants, (made,) = load_plugins([str(plugin), "guest[factor=2.5]"])
    assert variants == ("guest", "guest[factor=2.5]")
    assert made.solvers["guest[factor=2.5]"]["version"].startswith("guest.py ")
    run_of(tmp_path / "run", plugin)
    importers = trace.read_text(encoding="utf-8").split()
    assert len(importers) == 3  # twice to be introduced, once to run
    assert str(os.getpid()) not in importers
    assert not any(name.startswith("frictionbench_plugin") for name in sys.modules.keys() - before)


@pytest.mark.parametrize(
    ("first", "told"),
    [
        ("raise ValueError('no licence')", r"ValueError: no licence \(at guest.py:6 in <module>\)"),
        ("import sys; sys.exit(4)", r"SystemExit: 4 \(at guest.py:6"),
        ("import sys; open(sys.argv[1])", "IndexError: list index out of range"),
        ("import os; os._exit(0)", "the process ended: exit code 0"),
        ("def broken(:", r"SyntaxError.*line 6"),
        ("while True: pass", "stopped at its limit"),
    ],
)
def test_import_error_has_file_and_line(tmp_path, monkeypatch, first, told) -> None:
    plugin = write(tmp_path / "guest.py", first=first)
    monkeypatch.setattr("frictionbench.harness.workers.inputs.IMPORT_SECONDS", 2.0)
    with pytest.raises(InputError, match=rf"solver: .*guest\.py.*{told}"):
        load_plugins([str(plugin)])


def test_import_error_in_worker_is_recorded(tmp_path) -> None:
    once = tmp_path / "once"
    first = f"if Path({str(once)!r}).exists(): raise OSError('only once')\nPath({str(once)!r}).touch()"
    (row,) = run_of(tmp_path / "run", write(tmp_path / "guest.py", first=first)).to_dict("records")
    assert row["verdict"] == "crashed"
    assert "guest.py cannot be imported (OSError: only once (at guest.py:6" in row["reason"]


def test_exception_has_file_line_and_frames(tmp_path) -> None:
    first = "def deep(n):\n    return 1 / n"
    plugin = write(tmp_path / "guest.py", first=first, body="deep(0)")
    (row,) = run_of(tmp_path / "run", plugin).to_dict("records")
    told = r"ZeroDivisionError: division by zero \(at guest.py:7 in deep < guest.py:\d+ in solve\)"
    assert re.fullmatch(told, row["reason"])
    _, again = rerun_row(tmp_path / "run", row["key"], [str(plugin)])
    assert again["reason"] == row["reason"]


def test_edited_plugin_is_refused(tmp_path) -> None:
    plugin = write(tmp_path / "guest.py")
    _, plugins = load_plugins([str(plugin)])
    run_of(tmp_path / "run", plugin)
    write(plugin, body="tol = 2")
    with pytest.raises(ResultsError, match="plugins"):
        run_of(tmp_path / "run", plugin)
    (row,) = run_of(tmp_path / "other", plugin, plugins=plugins).to_dict("records")  # edited while the run was under way
    assert "was changed since the run began; begin another run" in row["reason"]
    other = write(tmp_path / "other.py", first=f"Path({str(plugin)!r}).open('a').write('#')")
    with pytest.raises(InputError, match=r"guest\.py was changed while plug-ins were imported"):
        load_plugins([str(other), str(plugin)])


def test_files_of_equal_name(tmp_path) -> None:
    one, other = write(tmp_path / "one" / "guest.py"), tmp_path / "other" / "guest.py"
    write(other, body="PASS")
    other.write_text(other.read_text(encoding="utf-8").replace('"guest"', '"visitor"'), encoding="utf-8")
    variants, plugins = load_plugins([str(one), str(other)])
    assert variants == ("guest", "visitor")
    assert len({plugin.content for plugin in plugins}) == 2
    link = tmp_path / "link.py"
    for made, name in (one, "guest"), (other, "visit"):  # of one size and time: its compiled file would be of both
        made.write_text(made.read_text(encoding="utf-8").replace('"visitor"', '"visit"'), encoding="utf-8")
        os.utime(made, (1, 1))
        link.unlink(missing_ok=True)
        link.symlink_to(made)
        assert load_plugins([str(link)])[0] == (name,)
    with pytest.raises(InputError, match="guest is defined by two plug-ins; give one of them"):
        load_plugins([str(one), str(write(tmp_path / "other" / "guest.py"))])


@pytest.mark.slow  # five processes; the quick tests refuse a plug-in that has changed
def test_rerun_and_shrink_require_plugin_argument(tmp_path) -> None:
    trace, folder = tmp_path / "trace", tmp_path / "run"
    body = "import os; os.abort() if problem.contacts > 1 else None"
    plugin = write(tmp_path / "guest.py", first=f"open({str(trace)!r}, 'a').close()", body=body)
    (row,) = run_of(folder, plugin).to_dict("records")
    assert (row["verdict"], "SIGABRT" in row["reason"]) == ("crashed", True)
    trace.unlink()
    for command in (rerun_row, shrink):
        with pytest.raises(InputError, match=rf"guest is not part of frictionbench; the run loaded it from '{plugin}'"):
            command(folder, row["key"], [])
    assert not trace.exists()
    _, again = rerun_row(folder, row["key"], [str(plugin)])
    assert (again["verdict"], again["solver"]) == ("crashed", "guest")
    _, problem, *_ = shrink(folder, row["key"], [str(plugin)])
    assert problem.contacts == 2


def test_revision(tmp_path, monkeypatch) -> None:
    def git(*arguments: str) -> None:
        subprocess.run(["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b", *arguments], check=True)

    def revision(root: Path) -> str:
        monkeypatch.setattr(machine, "PACKAGE", root / "frictionbench")
        return machine.revision.__wrapped__()

    (tmp_path / "site-packages" / "frictionbench").mkdir(parents=True)
    (tmp_path / "solvers").mkdir()
    (tmp_path / "frictionbench").mkdir()
    (tmp_path / "frictionbench" / "solvers").symlink_to("../solvers")
    code = tmp_path / "solvers" / "method.py"
    code.write_text("x = 1", encoding="utf-8")
    git("init", "--quiet")
    git("add", ".")
    git("commit", "--quiet", "--message=a")
    monkeypatch.setattr(machine, "content", machine.content.__wrapped__)
    installed = revision(tmp_path / "site-packages")  # a plain install in somebody's repository
    clean = revision(tmp_path)
    monkeypatch.setenv("GIT_DIR", str(tmp_path / "elsewhere"))  # as in a hook of another repository
    assert revision(tmp_path) == clean
    code.write_text("x = 2", encoding="utf-8")
    dirty = revision(tmp_path)
    code.write_text("x = 3", encoding="utf-8")
    assert installed.startswith(f"{version('frictionbench')}+")
    assert "dirty" not in clean
    assert dirty.startswith(f"{clean}-dirty-")
    assert revision(tmp_path) not in (clean, dirty)
    (code.parent / "new.py").write_text("", encoding="utf-8")
    code.write_text("x = 1", encoding="utf-8")
    assert "dirty" in revision(tmp_path)  # for a file that nobody added
