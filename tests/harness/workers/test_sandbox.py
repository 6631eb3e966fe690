"""A plug-in reaches neither the files nor the processes of the run, by each of the sandboxes that this kernel can build."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from frictionbench.harness import process
from frictionbench.harness.workers import pool, sandbox
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.results import store
from tests.helpers.paths import ROOT
from tests.helpers.plugin import write
from tests.helpers.runs import run_of, soon

# What a plug-in tries, each by a line of Python that raises OSError where it is refused; RUN, PID and FREE are put in.
ATTEMPTS = {
    "forge a shard": "open(RUN + '/shards/solves-0.jsonl', 'w').close()",
    "edit a problem": "open(RUN + '/problems/one.npz', 'r+').close()",
    "truncate a problem": "os.truncate(RUN + '/problems/one.npz', 0)",
    "delete a problem": "os.unlink(RUN + '/problems/one.npz')",
    "move the folder": "os.rename(RUN, RUN + '-moved')",
    "move the folder above": "os.rename(os.path.dirname(RUN), RUN + '-moved')",
    "edit by a relative path": "open(os.path.relpath(RUN) + '/problems/one.npz', 'r+').close()",
    "edit another solver": "open(LEMKE, 'r+').close()",
    "poison the cache of kernels": "open(CACHE + '/kernel.nbc', 'w').close()",
    "poison that of another version": "open(os.path.dirname(CACHE) + '/0123456789abcdef', 'w').close()",
    "poison what another worker keeps": "open(os.path.dirname(FREE) + '/kernel.nbc', 'w').close()",
    "remount": "libc = ctypes.CDLL(None); assert libc.mount(None, RUN.encode(), None, 4096 | 32, None) == 0 or 1 / 0",
}
KERNEL = {
    "have the kernel start a program": "open('/proc/sys/kernel/core_pattern', 'r+').close()",
    "make a control group": "os.mkdir('/sys/fs/cgroup/frictionbench-test')",
    "leave shared memory": "os.readlink('/proc/self/ns/ipc') == IPC or os.stat('/dev/shm').st_dev == SHARED or 1 / 0",
}
SIGNALS = {"kill": "os.kill(PID, 0)", "trace": "open(f'/proc/{PID}/mem', 'rb').close()"}
ALLOWED = {"write elsewhere": "open(FREE + '/log', 'w').close()", "start a program": "subprocess.run(['true'], check=True)"}
SCRIPT = """
import ctypes, json, os, subprocess, sys
from pathlib import Path
from numba.core import config
from frictionbench.harness.workers import sandbox
kind, RUN, FREE, LEMKE, attempts = sys.argv[1], *sys.argv[2:5], json.loads(sys.argv[5])
PID, CACHE = os.getppid(), config.CACHE_DIR
IPC, SHARED = os.readlink('/proc/self/ns/ipc'), os.stat('/dev/shm').st_dev
sandbox.confine(kind, Path(RUN), (), Path(FREE))
refused = []
for name, attempt in attempts.items():
    try:
        exec(attempt)
    except (OSError, ArithmeticError):
        refused.append(name)
print(json.dumps(refused))
"""


def usable() -> list[str]:
    """The sandboxes that this kernel can build."""
    best = "from frictionbench.harness.workers import sandbox; print(sandbox.best())"
    tried = subprocess.check_output([sys.executable, "-c", best], text=True, cwd=ROOT)
    version = sandbox.landlock_version()
    locks = [sandbox.LANDLOCK if version >= sandbox.SCOPES else sandbox.FILES_ONLY] if version else []
    return [*([sandbox.NAMESPACES] if tried.strip() == sandbox.NAMESPACES else []), *locks]


def refused(kind: str, tmp_path: Path, attempts: dict[str, str]) -> set[str]:
    """The attempts that the walls of one kind refuse."""
    folder = tmp_path / "work" / "run"
    (folder / "problems").mkdir(parents=True)
    (folder / "shards").mkdir()
    (tmp_path / "free").mkdir()
    (folder / "problems" / "one.npz").write_bytes(b"numbers")
    arguments = [kind, str(folder), str(tmp_path / "free"), str(ROOT / "solvers" / "lemke.py"), json.dumps(attempts)]
    told = subprocess.check_output([sys.executable, "-c", SCRIPT, *arguments], text=True, cwd=ROOT)
    assert (folder / "problems" / "one.npz").read_bytes() == b"numbers"
    return set(json.loads(told))


@pytest.mark.parametrize("kind", usable())
def test_walls_hold(kind, tmp_path) -> None:
    expected = set(ATTEMPTS) | (set() if kind == sandbox.FILES_ONLY else set(SIGNALS))
    kernel = KERNEL if kind == sandbox.NAMESPACES else {}  # what the others leave to root's rights, of which root is warned
    assert refused(kind, tmp_path, ATTEMPTS | SIGNALS | ALLOWED | kernel) == expected | set(kernel)


INHERITED = """
import contextlib, os
kinds = []
for name in os.listdir("/proc/self/fd"):
    with contextlib.suppress(OSError):  # the descriptor of the list itself
        kinds.append(os.readlink(f"/proc/self/fd/{name}").partition(":")[0])
Path(LOG).write_text(" ".join(kinds), encoding="utf-8")
"""


def test_workers_inherit_their_own_pipes_alone(tmp_path) -> None:
    """The ends of the tasks' pipe and of the replies' pipe, and no socket of a supervisor or of the server."""
    load_plugins([str(write(tmp_path / "guest.py", first=f"LOG = {str(tmp_path / 'log')!r}\n{INHERITED}"))])
    assert (tmp_path / "log").read_text(encoding="utf-8").split().count("pipe") == 2
    assert "socket" not in (tmp_path / "log").read_text(encoding="utf-8")


def test_executables_leave_nothing_behind(tmp_path) -> None:
    """One that is ended at its limit has written into its folder, and no file that is larger than they may be."""
    program, log = tmp_path / "slow.py", tmp_path / "log"
    program.write_text(
        f"#!{sys.executable}\nimport os, time\nopen({str(log)!r}, 'w').write(os.getcwd())\n"
        f"try:\n    os.truncate(os.open('big', os.O_CREAT | os.O_RDWR), {sandbox.MOST_FILE + 1})\n"
        f"except OSError:\n    open({str(log)!r}, 'a').write(' refused')\n"
        "open('small', 'w').write('left')\ntime.sleep(60)\n",
        encoding="utf-8",
    )
    program.chmod(0o755)
    rows = run_of(tmp_path / "run", f"exec:{program} {{problem}} {{answer}}", time_limit=1.0)
    assert list(rows["verdict"]) == ["timeout"]
    folder, told = log.read_text(encoding="utf-8").split()
    assert (told, Path(folder).exists()) == ("refused", False)


def test_root_is_warned(tmp_path, monkeypatch, capfd) -> None:
    plugin = write(tmp_path / "guest.py")
    for user, warned in ((0, True), (1000, False)):
        monkeypatch.setattr(os, "geteuid", lambda user=user: user)
        load_plugins([str(plugin)])
        assert ("run with root's rights" in capfd.readouterr().err) == warned


# On its first call it does what it can to the run, and afterwards answers with zeros.
STRAY = """
import contextlib, ctypes, os, signal
ctypes.CDLL(None).prctl(1, 0, 0, 0, 0)  # no signal when its parent ends
if os.fork() == 0:
    os.setsid()
    while True:
        signal.pause()
"""
HOSTILE = f"""{STRAY}
with contextlib.suppress(OSError):
    os.kill(os.getppid(), signal.SIGKILL)
"""


def test_hostile_plugin_in_a_run(tmp_path) -> None:
    """It forges rows, edits problems and kills workers; the rows of lemke equal those of a run without it."""
    if not usable():
        pytest.skip("this kernel has neither namespaces nor Landlock")
    run_folder = str(tmp_path / "with")
    body = f"with contextlib.suppress(OSError): next(Path({run_folder!r}).rglob('*.npz')).unlink()"
    plugin = write(tmp_path / "guest.py", first=HOSTILE, body=body)
    runs = run_of(tmp_path / "without", "lemke", jobs=2), run_of(tmp_path / "with", plugin, "lemke", jobs=2)
    alone, together = (rows.set_index("solver").loc[["lemke"], ["verdict", "residual", "work"]] for rows in runs)
    assert together.equals(alone)
    assert store.read_manifest(tmp_path / "with")["isolation"] == usable()[0]
    assert os.path.exists(tmp_path / "with" / "solves.parquet")


LEAVES_A_STRAY = f"""{STRAY}
os.kill(os.getppid(), signal.SIGKILL)
signal.pause()
"""


def test_server_ends_what_a_killed_supervisor_leaves(monkeypatch, tmp_path) -> None:
    """Where only process groups confine, a plug-in kills its supervisor and leaves a worker and a detached process."""
    groups = "from frictionbench.harness.workers import sandbox; sandbox.best = lambda: sandbox.GROUPS\nfrom frictionbench"
    monkeypatch.setattr(pool, "START", pool.START.replace("from frictionbench", groups, 1))
    monkeypatch.setattr(pool, "_server", None)
    plugin = write(tmp_path / "guest.py", body=LEAVES_A_STRAY.replace("\n", "\n        "))
    (row,) = run_of(tmp_path / "run", plugin).to_dict("records")
    assert (row["verdict"], row["reason"]) == ("crashed", "its processes were killed 3 times")
    assert store.read_manifest(tmp_path / "run")["isolation"] == sandbox.GROUPS
    server = pool._server
    assert soon(lambda: not process.descendants(server._process.pid))
    with pool.scratch_pool() as other:
        home = other.folder.parent  # where a killed command leaves its temporary folder
    server.close()
    assert (home.name[:14], home.exists()) == ("frictionbench-", False)
