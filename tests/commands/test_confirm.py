"""`compare --confirm` repeats alerts with the old and the new code in turn before it fails."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from frictionbench.commands import confirm
from frictionbench.problems import InputError
from frictionbench.results import baseline, cells
from frictionbench.results.compare import Comparison, Limits, accept, compare
from frictionbench.solvers import plugins
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import SETTINGS, solve_row, write_folder
from tests.helpers.plugin import write

pytestmark = pytest.mark.slow  # whole runs in new processes: what a pair of codes does, which no quick test sees
SCENE = "stack[blocks=1,push=1]"
UNTIMED = Limits(times=False)


@pytest.fixture(scope="module")
def seen(tmp_path_factory) -> Comparison:
    """A plug-in that raises, in a folder of its own, against a baseline in which it did not."""
    home = tmp_path_factory.mktemp("repository")
    plugin = write(home / "solvers" / "guest.py", body="raise ValueError('no')")
    out = home / "now"
    done = frictionbench(*("run", "smoke", "--scene", SCENE, "--tol", "1e-6", "--solver", str(plugin), "--out", str(out)))
    assert done.returncode == 0, done.stderr
    accept(out, home / "smoke.tsv")
    facts, rows = baseline.read(home / "smoke.tsv")
    better = [["unsolved" if value == "crashed" else value for value in row] for row in rows]
    baseline.write(home / "smoke.tsv", facts, [(*values, key) for key, *values in better])
    return compare(home / "smoke.tsv", out, UNTIMED)


def again(seen: Comparison, code: str | None, named: tuple[str, ...] = ("solvers/guest.py",), limits=UNTIMED) -> Comparison:
    return confirm.confirmed(seen, limits, list(named), code, lambda line: None)


def test_alerts_are_repeated_with_both_codes(seen, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(seen.current.parent)
    monkeypatch.setattr(confirm, "PAIRS_UNTIMED", 1)
    assert {flip.after for flip in seen.worse} == {"crashed"}
    (tmp_path / "base").mkdir()
    write(tmp_path / "base" / "solvers" / "guest.py")
    stands = again(seen, str(tmp_path / "base"))
    assert (stands.exit_code, stands.worse) == (1, seen.worse)
    monkeypatch.setattr(confirm, "_cells", lambda *_: cells.read(seen.current))  # as if both did what the current one does
    falls = again(seen, str(tmp_path / "base"))
    assert falls.exit_code == 0
    ran: list[tuple[object, ...]] = []
    monkeypatch.setattr(confirm, "_cells", lambda *given: ran.append(given) or cells.read(seen.current))
    assert again(replace(seen, changes=()), str(tmp_path / "base")).exit_code == 0
    assert len(ran) == 2  # what the two runs did not show is looked for as well
    assert all("frictionbench-" in str(folder) for _, _, folder, _ in ran)  # the server removes it, also after a kill
    assert all(
        note.startswith("Not confirmed, in most repeats both versions give the same result: guest")
        for note in falls.notes[-len(seen.worse) :]
    )
    monkeypatch.setattr(confirm, "_cells", lambda *_: replace(cells.read(seen.current), loaded={}))
    same = replace(seen, changes=())
    assert [again(same, str(tmp_path / "base"), limits=each).exit_code for each in (UNTIMED, Limits())] == [0, 2]
    assert "guest loads no guest.py there" in again(same, str(tmp_path / "base"), limits=Limits()).unusable


def test_missing_code(seen, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(seen.current.parent)
    for code, told in (("nowhere", "neither a folder nor"), ("", "is empty"), (str(tmp_path), "solvers/guest.py is not in")):
        with pytest.raises(InputError, match=f"code: .*{told}"):
            again(seen, code)
    for place, told in ((str(tmp_path), "both versions would run it"), (sys.prefix, "holds no other executable")):
        with pytest.raises(InputError, match=told):
            confirm.baseline_code(place, ["exec:/bin/true {problem} {answer}"], tmp_path)
    ours = [write_folder(tmp_path / name, [solve_row("lemke", "p")], settings=SETTINGS | {"suite": "smoke"}) for name in "ab"]
    with pytest.raises(InputError, match=r"code: .* holds no frictionbench"):
        confirm.confirmed(compare(*ours, UNTIMED), UNTIMED, [], str(tmp_path), print)
    with pytest.raises(InputError, match="solver: guest is not part of frictionbench"):
        again(seen, None, ())


@pytest.mark.parametrize("fork", [False, True])
def test_baseline_revision_is_unpacked(fork, tmp_path, monkeypatch) -> None:
    """Also where the solver's file stands in a fork of frictionbench, or is an executable that is named through a link."""
    home, link = tmp_path / "home", tmp_path / "link"
    (home / "frictionbench").mkdir(parents=True)
    (home / "frictionbench" / ("__main__.py" if fork else "other.py")).touch()
    link.symlink_to(home)
    monkeypatch.chdir(home)
    guest = write(home / "solvers" / "guest.py", body="pass")
    guest.chmod(0o755)
    for command in (("init", "-q"), ("add", "."), ("-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "first")):
        subprocess.run(["git", *command], check=True)
    write(guest, body="raise ValueError")
    command = f"exec:{link}/solvers/guest.py {{problem}} {{answer}}"
    for scratch, place in ((tmp_path / "scratch", home), (tmp_path / "below", home / "solvers")):
        monkeypatch.chdir(place)
        code = confirm.baseline_code("HEAD", [str(guest), command], scratch)
        assert (code.command[-1] == str(scratch / "code")) == fork
        for moved in code.solvers:
            (file,) = plugins.files(moved)
            assert file.is_relative_to(scratch)
            assert "raise" not in file.read_text(encoding="utf-8")
    if fork:
        elsewhere = str(write(tmp_path / "elsewhere.py"))
        assert confirm.baseline_code("HEAD", [elsewhere], tmp_path / "scratch").solvers == [elsewhere]
    Path("HEAD").mkdir()
    with pytest.raises(InputError, match=r"both a folder and a revision; write \./HEAD or HEAD"):
        confirm.require_code("HEAD")


def test_a_run_of_another_content_is_refused(seen, monkeypatch) -> None:
    monkeypatch.chdir(seen.current.parent)
    changed, guest = cells.read(seen.current), Path("solvers/guest.py")
    changed.loaded["guest"]["guest.py"] = "0"
    monkeypatch.setattr(confirm, "_cells", lambda *_: changed)
    with pytest.raises(InputError, match=r"was made with another content of guest\.py"):
        again(seen, None)
    write(Path("other.py"))  # of a solver of the same name
    guest.write_bytes(guest.read_bytes() + b"# changed")
    for named in ("solvers/guest.py", "other.py"):
        for alerts in (seen, replace(seen, changes=())):
            with pytest.raises(InputError, match=rf"^DIR: .* was made with another content of .*/{named}"):
                again(alerts, None, (named,))
    monkeypatch.setattr(confirm.machine, "revision", lambda: "another")
    with pytest.raises(InputError, match="was made with another content of frictionbench"):
        again(seen, None)
