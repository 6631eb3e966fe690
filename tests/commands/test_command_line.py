"""Output of the command line on terminals and pipes: help, lists, tables, summaries, errors and interruptions."""

import json
import signal
import subprocess
import sys

import pytest
from numba import njit
from typer.testing import CliRunner

from frictionbench.commands.cli import app
from frictionbench.commands.summary import folder_for
from frictionbench.commands.table import columns
from frictionbench.harness import process
from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers import pool
from frictionbench.results import store
from frictionbench.results.files import ResultsError
from frictionbench.results.store import new_shard


@pytest.mark.parametrize(("cores", "jobs"), [(1, 1), (2, 1), (8, 7)])
def test_a_core_is_left_free_by_default(monkeypatch, cores, jobs) -> None:
    asked = []
    monkeypatch.setattr(process, "cores", lambda: list(range(cores)))
    monkeypatch.setattr("frictionbench.commands.single.solve_one", lambda *arguments, **_: asked.append(arguments[-1]))
    for option in ((), ("--jobs", str(cores))):
        CliRunner().invoke(app, ["solve", "stack", *option])
    assert asked == [jobs, cores]
    assert "all cores but one" in " ".join(CliRunner().invoke(app, ["run", "--help"]).output.split())


def compiled(module: str) -> int:
    """In a worker, compile a function as one of a module."""

    def successor(x: int) -> int:
        return x + 1

    successor.__module__ = module
    return int(njit(successor)(1))


def test_only_kernels_of_this_package_that_are_compiled_are_announced_and_once(capsys) -> None:
    pool.tell_of_kernels.cache_clear()
    with pool.scratch_pool() as workers:
        for module, told in (("plugin", 0), ("frictionbench.solvers.lemke", 1), ("frictionbench.solvers.nsgs", 0)):
            (outcome,) = Progress(quiet=True).follow("kernels", workers, [pool.Task(compiled, (module,), 60.0)])
            assert outcome.value == 2
            assert capsys.readouterr().err.count("kernels are compiled") == told


@pytest.mark.parametrize("what", ["scenes", "solvers", "suites"])
def test_lists_are_json_too(what) -> None:
    listed = json.loads(CliRunner().invoke(app, ["list", what, "--json"]).stdout)
    assert {"scenes": "cubes", "solvers": "lemke", "suites": "smoke"}[what] in listed
    assert all(facts["summary"].endswith((".", ")")) for facts in listed.values())
    named = {
        "scenes": "arch  (planar)",
        "solvers": "lemke  (family pivoting; model lcp; ",
        "suites": "lemke (2 variants), nsgs",
    }[what]
    assert named in CliRunner().invoke(app, ["list", what]).output


def test_default_folder_depends_on_settings() -> None:
    whole, same, other = (choose(RunOptions("smoke", tol=tol)) for tol in (None, "1e-4,1e-8", "1e-6"))
    assert str(folder_for(whole)) == str(folder_for(same)) == "runs/smoke"
    assert str(folder_for(other)).startswith("runs/smoke-")
    assert folder_for(other) == folder_for(choose(RunOptions("smoke", tol="1e-6")))


def test_long_names_are_continued_after_a_part_of_them(monkeypatch) -> None:
    monkeypatch.setattr("frictionbench.commands.table.screen", lambda: 38)
    lines = columns(("solver", "verdict"), [("siconos[method=friction_3d_nsgs,settings=newton]", "another law")])
    assert lines[1:] == ["siconos[method=friction_  another law", "3d_nsgs,settings=newton]"]
    assert len(columns(("solver", "reason"), [("siconos[method=friction_3d_nsgs]", "it stalls " * 6)])) == 5


def test_abbreviated_keys(tmp_path) -> None:
    for table, keys in (("solves", ("solve-12ab", "solve-12cd", "solve-12")), ("simulations", ("simulation-77",))):
        with new_shard(tmp_path, table, "test") as write:
            for key in keys:
                write({"key": key})
    found = [store.find_row(tmp_path, given)[1]["key"] for given in ("12a", "solve-12c", "solve-12", "7")]
    assert found == ["solve-12ab", "solve-12cd", "solve-12", "simulation-77"]
    for given, facts in (("12", r"3 rows.*'12'"), ("13", "no row.*'13'"), ("", "4 rows have a key")):
        with pytest.raises(ResultsError, match=facts):
            store.find_row(tmp_path, given)


@pytest.mark.parametrize("command", [pytest.param("solve stack", marks=pytest.mark.slow), "run smoke --out run"])
def test_interruption_message(tmp_path, command) -> None:
    code = "import os, signal; from frictionbench.harness.workers import pool; begin = pool.Pool.__init__\n"
    code += "pool.Pool.__init__ = lambda *given: (begin(*given), os.kill(os.getpid(), signal.SIGINT))[0]\n"
    code += "from frictionbench.commands.cli import main; main()"
    call = [sys.executable, "-c", code, *command.split()]
    ended = subprocess.run(call, capture_output=True, text=True, check=False, timeout=60, cwd=tmp_path)
    assert ended.returncode == 128 + signal.SIGINT
    assert ("SIGINT" in ended.stderr, "Traceback" in ended.stderr) == (True, False)
    if "--out" in command:
        told = (f"results are written to {tmp_path / 'run'}\n", "frictionbench report run")
        assert all(text in ended.stderr for text in told)
        assert store.read_manifest(tmp_path / "run")["settings"]["suite"] == "smoke"  # the same command continues it


def _version(code: str) -> subprocess.CompletedProcess[str]:
    """Run --version in a process that executes code first."""
    return subprocess.run([sys.executable, "-c", f"{code}cli.main()", "--version"], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("when", "number", "ends"),
    [
        ("streams.io.BufferedWriter", signal.SIGTERM, -signal.SIGTERM),
        ("signal.signal", signal.SIGTERM, -signal.SIGTERM),
        ("cli.app", signal.SIGTERM, 128 + signal.SIGTERM),
        ("cli.app", signal.SIGHUP, 128 + signal.SIGHUP),
    ],
)
def test_a_signal_at_any_time_is_no_regression(when, number, ends) -> None:
    """Exit code 1 would mean a regression: neither a signal before the command begins nor one after its end gives it."""
    module, name = when.rsplit(".", 1)
    code = "import os, signal; [signal.signal(n, signal.SIG_DFL) for n in (signal.SIGTERM, signal.SIGHUP)]\n"  # not ignored
    code += "from frictionbench.harness import streams; from frictionbench.commands import cli\n"
    code += f"before = {when}\n"
    code += f"interrupted = lambda *given, **named: (os.kill(os.getpid(), {int(number)}), before(*given, **named))[1]\n"
    code += f"setattr({module}, {name!r}, interrupted)\n"
    ended = _version(code)
    assert ended.returncode == ends, ended.stderr


def test_hangups_are_ignored_under_nohup() -> None:
    code = "import os, signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
    code += "from frictionbench.commands import cli\n"
    code += "app = cli.app; cli.app = lambda: (os.kill(os.getpid(), signal.SIGHUP), app())[1]\n"
    ended = _version(code)
    assert (ended.returncode, ended.stderr) == (0, "")
