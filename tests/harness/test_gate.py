"""What the gate for CI promises, as docs/ci.md tells it in a table: each line of it names a test, most of which are here."""

import json
import os
import py_compile
import re
import shutil
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numba.core import config
from scipy._lib import _ccallback_c

from frictionbench.commands.confirm import of_another_version, require_whole, run_options
from frictionbench.harness import dependencies
from frictionbench.harness.cells import batch, timing, worker
from frictionbench.harness.cells.batch import batch_of, time_batch
from frictionbench.harness.plans.choose import RunOptions, choose
from frictionbench.harness.plans.plan import BatchCell, Plugin, Source
from frictionbench.harness.workers import supervisor
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import FrictionProblem
from frictionbench.problems.recorded.native import save
from frictionbench.reports.comparison.markdown import markdown
from frictionbench.results import cells, store
from frictionbench.results.compare import Limits, accept, compare, confirm, other_loads
from frictionbench.results.files import ResultsError
from frictionbench.solvers import Answer, Status, find, plugins
from tests.helpers.friction_problems import block
from tests.helpers.made_results import SETTINGS, batch_row, simulation_row, solve_row, unanswered_row, write_folder
from tests.helpers.paths import ROOT
from tests.helpers.plugin import write
from tests.helpers.runs import run_of, small_plan


def alerts(before: Path, after: Path, limits: Limits = Limits()) -> dict[str, tuple[int | None, int | None]]:  # noqa: B008
    """The counters that are worse, before and after."""
    return {one.name: (one.before, one.after) for one in compare(before, after, limits).worse}


def test_times_that_are_gone_are_a_regression(tmp_path: Path) -> None:
    """Also against a baseline, whose times are not compared otherwise."""
    before = write_folder(tmp_path / "before", [solve_row("a", "p"), solve_row("a", "q")])
    after = write_folder(tmp_path / "after", [solve_row("a", "p"), solve_row("a", "q", solve_time=None)])
    accept(before, tmp_path / "made.tsv")
    for old in (before, tmp_path / "made.tsv"):
        assert alerts(old, after) == {"timed cells": (1, None)}
    assert alerts(after, before) == {}
    assert alerts(before, after, Limits(times=False)) == {}


def test_more_failures_within_a_simulation_or_batch(tmp_path: Path) -> None:
    """Two of 160 steps are wrong, then 117; or the motion ends earlier, with the same verdict; or half a batch fails."""
    rows = {
        name: simulation_row("a", verdict="wrong", steps=160, steps_done=done, problems=160, unsolved=unsolved)
        for name, done, unsolved in (("before", 160, 2), ("worse", 160, 117), ("shorter", 80, 2))
    }
    folders = {name: write_folder(tmp_path / name, [solve_row("a", "p")], [row]) for name, row in rows.items()}
    accept(folders["before"], tmp_path / "made.tsv")
    for old in (folders["before"], tmp_path / "made.tsv"):
        assert alerts(old, folders["worse"]) == {"unsolved_problems, simulation": (2, 117)}
        assert alerts(old, folders["shorter"]) == {"steps_not_done, simulation": (0, 80)}
        assert alerts(old, folders["before"]) == {}
    batches = [batch_row("a", "packed", verdict="unsolved", residual=1.0, verified=share) for share in (0.99, 0.5)]
    pair = [write_folder(tmp_path / f"{k}", [], None, [row]) for k, row in enumerate(batches)]
    assert alerts(*pair) == {"unsolved_problems, batch": (1, 50)}


def test_work_is_added_by_the_kind_of_cell(tmp_path: Path) -> None:
    """A tenth more sweeps in a long motion; and many times those of a solve without its start, which a motion would hide."""

    def folder(warm: int, motion: int) -> Path:
        solves = [solve_row("a", "p", start=start, key=start, work=f'{{"sweeps": {warm}}}') for start in ("cold", "warm")]
        return write_folder(tmp_path / f"{warm} {motion}", solves, [simulation_row("a", work=f'{{"sweeps": {motion}}}')])

    assert alerts(before := folder(5, 10000), folder(5, 11000)) == {"sweeps, simulation": (10000, 11000)}
    assert alerts(before, folder(290, 10000)) == {"sweeps": (5, 290), "sweeps, warm": (5, 290)}


def test_fewer_failures_make_up_for_none(tmp_path: Path) -> None:
    """A motion fails in more steps, and another in fewer; or no answer is wrong any more, but most are missing."""

    def folder(name: str, *motions: tuple[str, int]) -> Path:
        facts: dict[str, Any] = {"steps": 160, "steps_done": 160, "problems": 160}
        rows = [simulation_row("a", key=f"{i}", verdict=verdict, unsolved=n, **facts) for i, (verdict, n) in enumerate(motions)]
        return write_folder(tmp_path / name, [solve_row("a", "p")], rows)

    before, counter = folder("before", ("unsolved", 90), ("wrong", 2)), "unsolved_problems, simulation"
    assert alerts(before, folder("other", ("unsolved", 2), ("wrong", 90))) == {counter: (2, 90)}
    assert alerts(before, folder("missing", ("unsolved", 90), ("unsolved", 60))) == {counter: (2, 60)}
    assert alerts(before, folder("stopped", ("unsolved", 90), ("timeout", None))) == {counter: (2, None)}


def test_the_repeats_are_of_the_runs_own_problems() -> None:
    """A scene of the suite that is given with settings has other steps than those of the suite."""
    plan = choose(RunOptions(suite="smoke", scene=["two_blocks[friction=0.1]"]))
    suite, *_, scene = run_options({"settings": plan.settings(), "options": plan.options})
    assert choose(RunOptions(suite=suite, scene=[scene])).sources == plan.sources


def test_a_baselines_code_that_crashes_excuses_nothing(tmp_path: Path) -> None:
    """As where a file that it needs is not in the revision: neither verdicts nor times can be compared with it."""
    stored, crashed, lacking, slow = (
        cells.read(write_folder(tmp_path / row["verdict"], [solve_row("a", "p"), row])).table
        for row in (solve_row("a", "q"), *(unanswered_row("a", "q", verdict) for verdict in ("crashed", "unsolved", "timeout")))
    )
    for ran in ([crashed, stored], [slow, slow], [lacking, lacking]):  # of two cells one, which is not the code's doing
        require_whole("code: main", stored, ran)
    with pytest.raises(ResultsError, match=r"^code: main: a, bar\[friction=0.2\] \(a-q-1e-08\) is crashed here and solved"):
        require_whole("code: main", stored, [crashed, crashed])
    with pytest.raises(ResultsError, match="of 1 cells of a that the baseline solved 1 are not solved here, as if it lacked"):
        require_whole("code: main", stored.tail(1), [lacking])  # an executable behind a script, which is not in git


def test_unfinished_runs_are_no_baseline(tmp_path: Path) -> None:
    whole = write_folder(tmp_path / "whole", [solve_row("a", "p"), solve_row("a", "q")])
    part = write_folder(tmp_path / "part", [solve_row("a", "p")], finished=None)
    for pair in ((part, whole), (whole, part)):
        assert "the run is not finished" in compare(*pair).unusable


def test_another_file_of_the_same_name(tmp_path: Path) -> None:
    """It is another cell; of the one that is gone the comparison fails."""
    given = {"parameters": '{"file": "one.npz"}', "scene": "mine"}
    settings = SETTINGS | {"sources": [{"scene": "mine", "parameters": {"file": "one.npz"}, "file": "/there/one.npz"}]}

    def run(digest: str, *others: store.Row) -> Path:
        content = {"/there/one.npz": digest * 16}
        rows, folder = [solve_row("a", "p", **given), *others], tmp_path / f"{digest}{len(others)}"
        return write_folder(folder, rows, settings=settings, content=content, loaded={})

    one, other = run("aaaa"), run("bbbb")
    assert compare(one, one).exit_code == 0
    accept(one, tmp_path / "made.tsv")
    assert "no cell was measured in both runs" in compare(tmp_path / "made.tsv", other).unusable
    assert [one.worse for one in compare(*(run(digest, solve_row("a", "q")) for digest in ("aaaa", "bbbb"))).worse] == [True]


def loaded_by(folder: Path, digest: str, rows: list[store.Row]) -> Path:
    """A run of a plug-in that wraps a package of this content."""
    plugins = [{"source": "wrapper.py", "content": "c", "solvers": {"a": {}}}]
    loaded = {"wrapper.py": {"wrapper.py": "/here/wrapper.py", "wrapped": "/site/wrapped", "numpy": "version 2.1"}}
    content = {"/here/wrapper.py": "1" * 64, "/site/wrapped": digest * 64, "version 2.1": "2.1"}
    return write_folder(folder, rows, settings=SETTINGS | {"plugins": plugins}, loaded=loaded, content=content)


def test_what_both_versions_load_dismisses_nothing(tmp_path: Path) -> None:
    """A package behind a wrapper is worse, and both versions of the wrapper load it."""
    solved, worse = [solve_row("a", "p")], [unanswered_row("a", "p", "crashed")]
    before, after = loaded_by(tmp_path / "before", "2", solved), loaded_by(tmp_path / "after", "3", worse)
    accept(before, tmp_path / "made.tsv")
    unread, limits = cells.read(loaded_by(tmp_path / "unread", "", solved)), Limits(times=False)
    for old in (before, tmp_path / "made.tsv"):
        first, now, recorded = compare(old, after, limits), cells.read(after), cells.read(old)
        equal = other_loads(recorded, now)
        assert equal == {"a": ["wrapped"]}
        stands = confirm(first, [(now.table, now.table)], True, limits, equal)
        assert stands.exit_code == 1
        assert "the version of --code loads wrapped with another content than the baseline was made with" in markdown(stands)
        assert other_loads(unread, unread) == {"a": ["wrapped"]}
        assert other_loads(recorded, recorded) == {}  # in an environment with the package as it was


def test_times_of_another_version_pass_nothing(tmp_path: Path) -> None:
    """A library is not in git, and a slow fallback takes its place; or both versions run the plug-in's new file."""
    stored = cells.read(loaded_by(tmp_path / "made", "2", [solve_row("a", "p")]))
    lacks, changed = (replace(stored, loaded={"a": stored.loaded["a"] | part}) for part in ({}, {"wrapper.py": "2" * 12}))
    del lacks.loaded["a"]["wrapped"]
    assert other_loads(stored, lacks) == {"a": ["wrapped"]}
    assert "a loads no wrapped there" in of_another_version(stored, lacks, stored, [])
    assert "both versions run the current wrapper.py" in of_another_version(stored, changed, changed, [Path("/here")])
    assert of_another_version(stored, changed, changed, [Path("/elsewhere")]) == ""
    assert of_another_version(stored, stored, changed, [Path("/here")]) == ""
    exact, fast = (
        replace(stored, loaded={"a": {"command": digest}}, places={"a": {"command": f"version:{digest}"}}) for digest in "12"
    )
    assert "both versions run the current command" in of_another_version(exact, fast, fast, [])
    assert of_another_version(exact, exact, fast, []) == ""  # a script of the repository that holds the command


@pytest.mark.parametrize(("place", "verdict"), [("first", "timeout"), ("body", "crashed")])
def test_what_ends_each_cell_is_known(place: str, verdict: str, tmp_path: Path) -> None:
    """A wrapped package, imported at once or within the call, is changed, and the worker is ended in its first call."""
    imports = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import frictionbench as fb, wrapped"
    parts = {"first": "", "body": "wrapped.solve(); return fb.solve(problem, 'lemke', tol=tol)"}
    plugin = write(tmp_path / "guest.py", **parts | {place: f"{imports}; {parts[place]}"})
    for name, body in ("before", "pass"), ("after", "time.sleep(99)" if verdict == "timeout" else "os._exit(3)"):
        (tmp_path / "wrapped.py").write_text(f"import os, time\ndef solve():\n    {body}", encoding="utf-8")
        assert set(run_of(tmp_path / name, plugin, time_limit=0.5)["verdict"]) == {"solved" if body == "pass" else verdict}
    now, limits = cells.read(tmp_path / "after"), Limits(times=False)
    equal = other_loads(cells.read(tmp_path / "before"), now)
    assert equal["guest"] == ["wrapped"]
    first = compare(tmp_path / "before", tmp_path / "after", limits)
    assert confirm(first, [(now.table, now.table)], True, limits, equal).exit_code == 1


WRAPPER = """
import sys
sys.path[:0] = [{home!r} + '/one', {home!r} + '/two', {home!r}]
import wrapped, spread.first, spread.second
"""
READS = (
    "import ctypes, sched, numpy, runpy; runpy.run_path({home!r} + '/run.py'); "
    "[numpy.load({home!r} + place) for place in ('/a.npy', '/two/a.npy')]; "
    "open({home!r}.encode() + b'/named.txt').close(); open({home!r} + '/both.txt', 'r+').close(); import os, subprocess; "
    "subprocess.run(['./run.sh'], cwd={home!r}); subprocess.run('sh.sh', shell=True, env={{'PATH': {home!r}}}); "
    "os.system({home!r} + '/by_os.sh 1'); import multiprocessing; fork = multiprocessing.get_context('fork'); "
    "opened = (numpy.load, 'child.npy'), (open, 'made.txt', 'w'), (open, 'made.txt'), (ctypes.CDLL, 'child.so'); "
    "children = [fork.Process(target=call, args=({home!r} + '/' + name, *mode)) for call, name, *mode in opened]; "
    "[child.start() or child.join() for child in children]; [open({home!r} + '/' + name).close() for name in {odd!r}]; "
    "import contextlib, _ctypes; _ctypes.dlclose(ctypes.CDLL({home!r} + '/closed.so')._handle)\n"
    "        for name in ({home!r} + '/loop', '/proc/1/ns/mnt'):\n            with contextlib.suppress(OSError): open(name)"
)
ARRAYS = ("a.npy", "two/a.npy", "child.npy")
ODD = ("x.nbi", "x.pyc", "Gr\udcfc\u200d; ..dat", "1\x01.dat", "1\x02.dat", "1% .dat", "1;.dat", "1,.dat")
LIBRARIES = ("closed.so", "child.so")
TEXTS = ("wrapped/to/one.py", "run.py", "named.txt", "both.txt", "run.sh", "sh.sh", "by_os.sh", "sched.py")
READ = (*ARRAYS, *LIBRARIES, *ODD, *TEXTS)
OTHERS = ("two/spread/second.py", *READ[1:], "problem.npz")
SPREAD = {"spread": "one/spread", "spread:2": "two/spread"}  # a package of two folders


@pytest.mark.parametrize(
    "changed", ["wrapped/core.py", "a.npy", *(pytest.param(name, marks=pytest.mark.slow) for name in OTHERS)]
)
def test_a_run_is_not_resumed_after_its_inputs_changed(changed: str, tmp_path: Path) -> None:
    """A module of the wrapped packages, files that the solver reads and programs that it starts, libraries that it closes or
    that its child loads, the file of a problem. A path that cannot be resolved is no error."""
    for folder, module in ("one", "first"), ("two", "second"):
        (tmp_path / folder / "spread").mkdir(parents=True)
        (tmp_path / folder / "spread" / f"{module}.py").write_text("GAIN = 1.0", encoding="utf-8")
    (tmp_path / "wrapped").mkdir()
    (tmp_path / "wrapped" / "to").symlink_to(tmp_path / "two")
    (tmp_path / "wrapped" / "__init__.py").write_text("import wrapped.core, wrapped.to.one", encoding="utf-8")
    (tmp_path / "wrapped" / "core.py").write_text("GAIN = 1.0", encoding="utf-8")
    for name in ARRAYS:
        np.save(tmp_path / name, np.ones(3))
    for name in (*ODD, *TEXTS):
        (tmp_path / name).write_text("#!/bin/sh" if name.endswith(".sh") else "1", encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    for name in LIBRARIES:
        shutil.copy(_ccallback_c.__file__, tmp_path / name)
    (tmp_path / "loop").symlink_to("loop")
    save(block(), tmp_path / "problem.npz")
    home = str(tmp_path)
    plugin = write(tmp_path / "guest.py", first=WRAPPER.format(home=home), body=READS.format(home=home, odd=ODD))
    source = Source("mine", {"file": "problem.npz"}, file=str(tmp_path / "problem.npz"))

    def again() -> None:
        assert set(run_of(tmp_path / "run", plugin, sources=(source,))["verdict"]) == {"unsolved"}

    again()
    loaded = store.read_manifest(tmp_path / "run")["loaded"][str(plugin)]
    read = [str(tmp_path / place) for place in READ]
    assert [dependencies.unquoted(dependencies.quoted(path)) for path in read] == read
    assert dependencies.place_hash(dependencies.quoted(f"{dependencies.VERSION}1.0+a")) == "1.0+a"
    found = {name: place for name, place in loaded.items() if not place.startswith(dependencies.VERSION)}
    named = {name: str(tmp_path / place) for name, place in SPREAD.items()} | {"wrapped": str(tmp_path / "wrapped")}
    assert found == {"guest.py": str(plugin)} | named | {path: path for path in map(dependencies.quoted, read)}
    again()
    (tmp_path / changed).write_bytes((tmp_path / changed).read_bytes() + b" ")
    place = changed if changed in (*READ, "problem.npz") else changed.rpartition("/")[0]
    with pytest.raises(ResultsError, match=f"{dependencies.quoted(str(tmp_path / place))}: has another content"):
        again()


def test_files_of_one_name_are_told_apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    paths = {"/x/a/a.npy": "1", "/x/b/a.npy": "2", "/y/wrapper.py": "3"}
    loaded = {"wrapper.py": {path: path for path in paths} | {"wrapper.py": "/x/a/a.npy"}}
    given = [{"source": "wrapper.py", "solvers": {"a": {}}}]
    made = write_folder(tmp_path, [], settings=SETTINGS | {"plugins": given}, loaded=loaded, content=paths)
    wanted = {"a/a.npy": "1", "b/a.npy": "2", "y/wrapper.py": "3", "wrapper.py": "1"}
    assert cells.read(made).loaded["a"] == wanted
    # Parts of a namespace package: of another distribution, or the name of an editable package's finder, which is no path.
    parts = ["corp.__path_hook__", str(tmp_path)]
    spec = SimpleNamespace(origin=None, submodule_search_locations=parts)
    monkeypatch.setitem(sys.modules, "corp", SimpleNamespace(__path__=parts, __spec__=spec))
    monkeypatch.setattr(plugins, "_point", lambda _: SimpleNamespace(module="corp.made.solvers"))
    assert [write(tmp_path / "made" / "__init__.py").parent] == plugins.places("guest")
    assert dependencies._module("corp", set()) == {"corp:2": str(tmp_path)}


def test_what_a_worker_reports_is_bounded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It may name a file at which a read never ends, more than a manifest can hold, or lists that fill the memory."""
    (tmp_path / "empty.py").touch()
    assert dependencies.place_hash(str(tmp_path / "empty.py")) == sha256().hexdigest()
    assert dependencies.place_hash("/proc/self/status") == ""  # not regular: it states no size
    record = dependencies.LoadRecord(write_folder(tmp_path, [], loaded={}, content={}))
    monkeypatch.setattr(store, "LARGEST_MANIFEST", 2**12)
    for number in (1, 100):
        record.add("guest.py", {f"{k}": f"{dependencies.VERSION}1" for k in range(number)})
        assert len(store.read_manifest(tmp_path)["loaded"]["guest.py"]) == 1
    assert b"malformed reply" in supervisor._checked(b'{"value": [' + b"[], " * supervisor.MOST_LISTS + b"1]}\n")[0]


def test_a_run_does_not_finish_with_inputs_that_changed(tmp_path: Path) -> None:
    """As where a package is installed anew while a run that needs it goes on."""
    home, wrapped = str(tmp_path), tmp_path / "wrapped.py"
    wrapped.touch()
    changes = f"open({str(wrapped)!r}, 'a').write('#')"
    plugin = write(tmp_path / "guest.py", first=f"import sys; sys.path.insert(0, {home!r}); import wrapped", body=changes)
    with pytest.raises(ResultsError, match=f"{wrapped}: has another content than when the run began"):
        run_of(tmp_path / "run", plugin, tolerances=(1e-4, 1e-6))
    assert "finished" not in store.read_manifest(tmp_path / "run")


def test_command_of_an_executable_is_recorded(tmp_path: Path) -> None:
    """The same binary with other words is another content; the folder it lies in is not."""
    program = tmp_path / "solve.sh"
    program.write_text("#!/bin/sh\n", encoding="utf-8")
    program.chmod(0o755)
    plugins = [Plugin(f"exec:{program} {words} {{problem}} {{answer}}", "content", {}) for words in ("--exact", "--fast")]
    exact, fast = (dependencies.initial_content(small_plan(plugins=(plugin,)))["loaded"][plugin.source] for plugin in plugins)
    assert exact["solve.sh"] == fast["solve.sh"] == str(program)
    assert exact["command"] != fast["command"]
    folder = write_folder(tmp_path / "run", [solve_row("a", "p")])
    store.write_manifest(folder, store.read_manifest(folder) | {"loaded": {"exec": exact}, "content": {}})
    dependencies.LoadRecord(folder).add("exec", {str(program): str(program)})  # a worker reads the program to hash it
    assert store.read_manifest(folder)["loaded"]["exec"] == exact


class Lazy:
    """An impulse that is computed when it is converted, which takes so many seconds of the test's clock."""

    def __init__(self, clock, impulse):
        self.clock, self.impulse = clock, impulse

    def __array__(self, dtype=None, copy=None):
        self.clock.now += 4.0
        return self.impulse


def test_work_done_while_an_answer_is_read_is_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(timing, "perf_counter", lambda: clock.now)
    lazy = Answer(Lazy(clock, np.zeros((1, 2))), Status.STALLED)
    found = timing.time_solver(find("lemke")[1], block(), lambda ready: lazy, lambda: None, lambda *_: 0)
    assert found.solve == [4.0]


def test_nudges_are_drawn_in_each_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """So that no file on disk holds the answers to them."""
    drawn: list[int] = []
    nudged = timing.nudged
    monkeypatch.setattr(timing, "SLOW_NEW", -1.0)
    monkeypatch.setattr(timing, "SLOW_FIRST", 0.0)
    monkeypatch.setattr(timing, "nudged", lambda problem, ulps: (drawn.append(ulps), nudged(problem, ulps))[1])
    _, solver = find("lemke")
    for _ in range(4):
        timing.time_solver(solver, block(), lambda ready: solver.solve(ready, 1e-8, None), lambda: None, lambda *_: 0, 3)
    assert len(set(drawn)) > 2
    assert max(drawn) > 2


def batch_times(monkeypatch: pytest.MonkeyPatch, solve) -> tuple[store.Row, int]:
    """The row of a batch of three problems that are solved by this function, and the number of different ones."""
    seen: set[str] = set()

    def calls(problems: tuple[FrictionProblem, ...], spec: str, tol: float) -> list[Answer]:
        seen.update(problem.hash for problem in problems)
        return [solve(problem, spec, tol=tol) for problem in problems]

    monkeypatch.setattr(batch, "_calls", calls)
    for name, value in {"ROUNDS": 2, "SAMPLE": 1}.items():
        monkeypatch.setattr(batch, name, value)
    cell = BatchCell("stack", {"blocks": 1}, 3, "lemke", "calls", 1e-8)
    return time_batch(cell, batch_of.__wrapped__("stack", '{"blocks": 1}', 3), find("lemke")[0]), len(seen)


def test_batches_differ_in_each_round(monkeypatch: pytest.MonkeyPatch) -> None:
    row, different = batch_times(monkeypatch, batch.solve)
    assert (row["verdict"], different) == ("solved", 9)


def test_batches_are_verified_on_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    def rob(problem: FrictionProblem, spec: str, tol: float) -> Answer:
        problem.friction.setflags(write=True)  # code in C can write without it
        problem.friction[:] = 0
        return batch.solve(problem, spec, tol=tol)

    assert batch_times(monkeypatch, rob)[0]["verdict"] == "wrong"


def test_writing_into_a_start_is_wrong(tmp_path: Path) -> None:
    """The repeats would begin at the answer, and a slower solver would look fast."""
    plugin = write(tmp_path / "guest.py", body="start is None or start.fill(1.0)")
    rows = run_of(tmp_path / "run", plugin, sources=(Source("stopping_block", {}, pick=3, steps=6),), starts=("cold", "warm"))
    assert rows.groupby("start")["verdict"].agg(set).to_dict() == {"cold": {"unsolved"}, "warm": {"wrong"}}


def test_waiting_counts_in_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seconds of sleep are none of the processor's."""
    clock = {"now": 0.0}

    def sleeps(problem: FrictionProblem, spec: str, tol: float) -> Answer:
        clock["now"] += 5.0
        return batch.solve(problem, spec, tol=tol)

    monkeypatch.setattr(batch, "perf_counter", lambda: clock["now"])
    monkeypatch.setattr(batch.process, "waited", lambda: 0.0)
    row, _ = batch_times(monkeypatch, sleeps)
    assert row["times"] == [5.0, 5.0]


def test_leaving_its_core_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "_worker", SimpleNamespace(core=0), raising=False)
    monkeypatch.setattr(worker.process, "waited", lambda: 0.0)  # on a busy machine it waits, and counts as disturbed too
    monkeypatch.setattr(worker.os, "sched_setaffinity", lambda *_: None)
    for cores in ({0}, {0, 1}):
        monkeypatch.setattr(worker.os, "sched_getaffinity", lambda _, allowed=cores: allowed)
        assert worker._machine_columns(0.0, 1.0)["disturbed"] is (cores != {0})


@pytest.mark.parametrize(
    ("body", "verdict"),
    [
        ("answer.impulse += 1", "wrong"),
        ("raise ValueError", "crashed"),
        pytest.param("answer.work = None", "wrong", marks=pytest.mark.slow),
        pytest.param("pass", "solved", marks=pytest.mark.slow),
    ],
)
def test_failure_of_the_first_call_of_a_process(body: str, verdict: str, tmp_path: Path) -> None:
    """As of a table that is filled by the first call, after it was read."""
    plugin = write(tmp_path / "guest.py", first="import frictionbench as fb\ncalls = []", body=FIRST.format(body=body))
    motions = (Source("stopping_block", {}, steps=5),)
    rows = run_of(tmp_path / "run", plugin, simulations=motions, simulation_solvers=("guest",), tolerances=(1e-6, 1e-8))
    rows = pd.concat([rows, store.read_table(tmp_path / "run", "simulations")])
    assert len(rows) == 3
    assert set(rows["verdict"]) == {verdict}
    assert rows["reason"].fillna("").str.contains(f"first call.* is {verdict}").all() == (verdict != "solved")


FIRST = """answer = fb.solve(problem, "lemke", tol=tol)
        calls.append(1)
        if len(calls) == 1:
            {body}
        return answer"""

HOMES = """
import os, tempfile
from pathlib import Path
places = [Path.home(), Path(os.environ["XDG_CACHE_HOME"]), Path(tempfile.gettempdir())]
known = [(place / "answers").exists() for place in places]
for place in places:
    (place / "answers").write_bytes(bytes(1000))
    os.chdir(place)
for _ in range(1100):  # deeper than Python's own functions remove
    os.mkdir("deep")
    os.chdir("deep")
Path({log!r}).open("a").write(f"{{known}} {{places[0]}}\\n")
"""


def test_workers_have_folders_of_their_own(tmp_path: Path) -> None:
    """What one leaves in its home, its cache or among temporary files is not found by the next, and is removed at the end."""
    log = tmp_path / "log"
    plugin = write(tmp_path / "guest.py", first=HOMES.format(log=str(log)))
    for _ in range(2):
        load_plugins([str(plugin)])
    lines = log.read_text(encoding="utf-8").splitlines()
    assert {line.partition("]")[0] for line in lines} == {"[False, False, False"}
    homes = {Path(line.partition("] ")[2]) for line in lines}
    assert len(homes) == 2
    assert not any(home.exists() for home in homes)


def test_kernels_of_a_plugin_are_compiled_anew(tmp_path: Path) -> None:
    """A kernel that another one calls is changed: numba's cache would keep the caller as it was, and Python the module, whose
    source has the same size and second, as where a link leads elsewhere. Nothing is left behind. The module's folder is named
    almost as those of installed packages."""
    (own := tmp_path / "own-packages").mkdir()
    calls = "from numba import config, njit\nfrom helper import count\n@njit(cache=True)\ndef counted():\n    return count()"
    keeps = f"Path({str(tmp_path)!r}, 'log').write_text(config.CACHE_DIR); "
    body = f"{keeps} return Answer(np.zeros((problem.contacts, 2)), Status.STALLED, {{'count': counted()}})"
    plugin = write(tmp_path / "guest.py", first=f"import sys; sys.path.insert(0, {str(own)!r})\n{calls}", body=body)
    for count in (1, 2):
        helper = f"from numba import njit\n@njit(cache=True)\ndef count():\n    return {count}"
        (own / "helper.py").write_text(helper, encoding="utf-8")
        os.utime(own / "helper.py", (1e9, 1e9))
        py_compile.compile(str(own / "helper.py")) if count == 1 else None
        assert list(run_of(tmp_path / f"run-{count}", plugin)["work"].map(json.loads)) == [{"count": count}]
        kept = Path((tmp_path / "log").read_text(encoding="utf-8"))
        assert any(kept.rglob("*.nbi"))
    assert not kept.is_relative_to(Path(config.CACHE_DIR).parent)


def test_every_promise_has_a_test() -> None:
    """The table of docs/ci.md names tests that exist."""
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", (ROOT / "docs" / "ci.md").read_text(encoding="utf-8"))
    assert len(named) > 15
    for file, test in named:
        assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), f"{file}::{test}"
