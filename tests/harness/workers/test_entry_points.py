"""Solvers of installed distributions are found by their entry points and treated like plug-ins."""

import sys
from pathlib import Path

import pytest

from frictionbench.commands import confirm
from frictionbench.commands.single import all_variants
from frictionbench.harness.plans.choose import read_options
from frictionbench.harness.workers import pool
from frictionbench.harness.workers.inputs import load_plugins
from frictionbench.problems import InputError
from frictionbench.results import cells, store
from frictionbench.results.compare import Limits, compare
from frictionbench.solvers import plugins
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import SETTINGS, solve_row, write_folder
from tests.helpers.plugin import PLUGIN

METADATA = "Metadata-Version: 2.1\nName: made-up\nVersion: 1.2\n"
POINTS = "[frictionbench.solvers]\nguest = made_up.solvers\nabsent = made_up.solvers\nbroken = made up[\n"
POINTS += "main = __main__\nloaded = json\n\x1bred = made_up\n"


@pytest.fixture
def distribution(tmp_path, monkeypatch) -> Path:
    """Folder of a made-up distribution, importable in this process and in its children, and of one with damaged metadata."""
    home = tmp_path / "site"
    for name, metadata in (("made_up", METADATA), ("damaged", "Name: \xff")):
        (home / f"{name}-1.2.dist-info").mkdir(parents=True)
        (home / f"{name}-1.2.dist-info" / "METADATA").write_text(metadata, encoding="latin-1")
        (home / f"{name}-1.2.dist-info" / "entry_points.txt").write_text(POINTS, encoding="latin-1")
    (home / "made_up").mkdir()
    (home / "made_up" / "__init__.py").write_text("FACTOR = 0.0", encoding="utf-8")
    code = PLUGIN.format(first=f"from made_up import FACTOR\nopen({str(tmp_path / 'trace')!r}, 'a').close()", body="pass")
    (home / "made_up" / "solvers.py").write_text(code.replace("= 0.0", "= FACTOR"), encoding="utf-8")
    monkeypatch.syspath_prepend(home)
    monkeypatch.setenv("PYTHONPATH", str(home))
    monkeypatch.setattr(pool, "_server", None)
    yield home
    if pool._server is not None:
        pool._server.close()


def test_installed_solver(distribution, tmp_path) -> None:
    listed = frictionbench("list", "solvers")
    assert "made-up 1.2" in next(line for line in listed.stdout.splitlines() if line.startswith("guest "))
    assert "?red  (distribution made-up 1.2)" in listed.stdout
    assert not (tmp_path / "trace").exists()
    (file := tmp_path / "run.toml").write_text('solver = ["guest[factor=2]"]', encoding="utf-8")
    with pytest.raises(InputError, match=r"run.toml: solver: guest\[factor=2\] is code; name it with --solver$"):
        read_options(file)
    assert read_options(file, ["guest"]).solver == ["guest[factor=2]"]
    assert ": the module __main__ does not exist\n" in frictionbench("solve", "stack", "--solver", "main").stderr
    solved = frictionbench("solve", "stack[blocks=1,push=1]", "--solver", "guest", "--solver", "nsgs")
    assert solved.returncode == 0, solved.stderr
    assert set(solved.stdout.split()) >= {"guest", "nsgs"}
    run = ("run", "smoke", "--scene", "stack[blocks=1,push=1]", "--solver", "guest[factor=2]", "--out", str(tmp_path / "run"))
    ran = frictionbench(*run)
    assert ran.returncode == 0, ran.stderr
    rows = store.read_table(tmp_path / "run", "solves")
    assert set(rows["variant"]) == {"guest[factor=2]"}
    assert set(rows["verdict"]) == {"unsolved"}
    assert rows["version"].str.startswith("made-up 1.2 ").all()
    (distribution / "made_up" / "__init__.py").write_text("FACTOR = 1.0", encoding="utf-8")
    again = frictionbench(*run)
    assert (again.returncode, again.stderr.count("guest (content ")) == (2, 2)  # the stored one and the present one
    told = frictionbench("rerun", str(tmp_path / "run"), rows["key"][0])
    assert told.returncode == 2
    assert "guest[factor=2] is not part of frictionbench; the run loaded it from 'guest'" in told.stderr


@pytest.mark.slow  # all checks of a solver; the quick tests check files
def test_installed_solver_is_treated_as_plugin(distribution) -> None:
    variants, (made,) = load_plugins(["nsgs", "guest"])
    assert variants == ("guest", "nsgs")
    assert made.solvers.keys() == {"guest"}
    assert made.content == plugins.content("guest")
    checked = frictionbench("check-solver", "guest")
    assert checked.stdout.startswith("guest\n  passed"), checked.stderr


def test_unusable_entry_points(distribution) -> None:
    with pytest.raises(InputError, match=r"solver: made_up\.solvers of made-up 1\.2 defines no solver absent"):
        load_plugins(["absent"])
    with pytest.raises(InputError, match=r"^solver: broken of made-up 1\.2 names no module, but 'made up\['$"):
        load_plugins(["broken"])
    with pytest.raises(InputError, match=r"^solver: json of made-up 1\.2 defines no solver loaded$"):
        load_plugins(["loaded"])
    (distribution / "made_up" / "solvers.py").write_text("\n1 / 0", encoding="utf-8")
    with pytest.raises(InputError, match=r"guest of made-up 1\.2 cannot be imported \(ZeroDivisionError.*at solvers\.py:2"):
        load_plugins(["guest"])
    twin = distribution / "damaged-1.2.dist-info"
    (twin / "METADATA").write_text(METADATA.replace("made-up", "twin"), encoding="utf-8")
    with pytest.raises(InputError, match=r"guest is declared by made-up 1\.2 and by twin"):
        load_plugins(["guest"])
    assert load_plugins(["nsgs"]) == (("nsgs",), ())
    variants, known, complaints = all_variants()  # for a bare `solve`, which goes on without them
    assert ("nsgs" in variants, known) == (True, ())
    assert [complaint.split()[:2] for complaint in complaints] == [["skipped:", "solver:"]] * 6
    (twin / "entry_points.txt").write_text("[other]\nno value", encoding="utf-8")
    assert plugins.version("guest").startswith("made-up 1.2 ")


@pytest.mark.parametrize(("named", "changed"), [("guest", "made_up"), ("solvers.py", "made_up/__init__.py")])
def test_new_code_that_both_environments_find_passes_nothing(distribution, named, changed, tmp_path, monkeypatch) -> None:
    """A package, or a module beside the plug-in's file: its times would be equal, however slow it is."""
    source = str(distribution / "made_up" / named) if named.endswith(".py") else named
    settings = SETTINGS | {"suite": "smoke", "sources": [], "plugins": [{"source": source, "solvers": {"guest": {}}}]}
    place = str(distribution / changed)
    known = {"settings": settings, "loaded": {source: {"made_up": place}}}
    runs = [write_folder(tmp_path / n, [solve_row("guest", "p")], **known, content={place: n * 64}) for n in "12"]
    monkeypatch.setattr(confirm, "_cells", lambda *_: cells.read(runs[1]))
    found = confirm.confirmed(compare(*runs), Limits(), [source], sys.prefix, print)
    assert (found.exit_code, "both versions run the current made_up" in found.unusable) == (2, True)
