"""rerun and shrink on rows and manifests that someone edited: exit 0 or 2 with one line."""

import json
import shutil

import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.recorded.native import save
from frictionbench.results import store
from frictionbench.results.conventions import DEFAULT_SCHEME
from tests.helpers.command_line import frictionbench
from tests.helpers.made_results import SETTINGS, simulation_row, solve_row, write_folder

KEEP = "<kept>"


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    problem = scene("stack", blocks=1).problem()
    given = {"scene": "stack", "parameters": '{"blocks": 1}', "verdict": "unsolved", "time_limit": 5.0}
    simulation = simulation_row("lemke", **given, scheme=DEFAULT_SCHEME, steps=2)
    folder = write_folder(
        tmp_path_factory.mktemp("run"),
        [solve_row("lemke", problem.hash, **given)],
        [simulation],
        settings=SETTINGS | {"memory_limit": 2**32},
    )
    (folder / "problems").mkdir()
    save(problem, folder / "problems" / f"{problem.hash}.npz")
    return folder


def edited(finished, tmp_path, table, settings, **columns):
    """A copy of the run with one row of the table and the settings changed; the row's key."""
    folder = shutil.copytree(finished, tmp_path / "run")
    manifest = store.read_manifest(folder)
    manifest["settings"] = {name: value for name, value in (manifest["settings"] | settings).items() if value is not KEEP}
    store.write_manifest(folder, manifest)
    row = next(iter(store.rows(folder, table).values())) | columns
    store.drop(folder, table, lambda _: True)
    (folder / "shards" / f"{table}-0.jsonl").write_text(json.dumps(row) + "\n", encoding="utf-8")
    return folder, row["key"]


VALUES = {
    **dict.fromkeys(("tol", "time_limit"), (None, -1.0, 0.0, float("nan"), float("inf"), 1e-200, 1e300)),
    **dict.fromkeys(("variant", "scene", "parameters", "work"), (None, "", "{", "[", "[1]", "\x1b[31m")),
    "problem": (None, "../../etc/passwd", "abc", "\x00"),
    "start": (None, "warmest", ""),
    "verdict": (None, "fine"),
}
COLUMNS = [{name: value} for name, values in VALUES.items() for value in values]


@pytest.mark.slow  # edited columns of solve rows: a worker each
@pytest.mark.parametrize("columns", COLUMNS, ids=str)
def test_edited_solve_rows(finished, tmp_path, columns) -> None:
    folder, key = edited(finished, tmp_path, "solves", {}, **({"verdict": "unsolved"} | columns))
    for words in ((), (key,), (key, "--shrink")):
        done = frictionbench("rerun", str(folder), *words)
        assert done.returncode in (0, 2), done
        assert len(done.stderr.strip().splitlines()) == (done.returncode == 2), done
        assert "\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize("columns", [{"scheme": None}, {"scheme": "x"}, {"steps": 10**15}], ids=str)
def test_edited_simulation_rows(finished, tmp_path, columns) -> None:
    folder, key = edited(finished, tmp_path, "simulations", {}, **columns)
    done = frictionbench("rerun", str(folder), key)
    assert (done.returncode, len(done.stderr.strip().splitlines())) == (2, 1), done


@pytest.mark.parametrize("limit", [KEEP, None, True, "much", 0, 10**40, float("nan")], ids=str)
def test_edited_memory_limit(finished, tmp_path, limit) -> None:
    folder, key = edited(finished, tmp_path, "solves", {"memory_limit": limit}, verdict="unsolved")
    for options in ((), ("--shrink",)):
        done = frictionbench("rerun", str(folder), key, *options)
        assert done.returncode == 2, done
        assert done.stderr.startswith("frictionbench: settings.memory_limit: cannot be"), done
