"""Damaged and malicious results folders are rejected with one-line errors."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scene
from frictionbench.problems.recorded import fclib, native, read
from frictionbench.reports.page import write_report
from frictionbench.results import files, store
from frictionbench.results.cells import counts
from frictionbench.results.compare import accept, compare
from frictionbench.results.conventions import RankBy
from frictionbench.results.files import ResultsError
from frictionbench.results.maps import maps_of
from frictionbench.results.schema import SCHEMA_VERSION, arrow_schema
from frictionbench.results.store import new_shard
from tests.helpers.command_line import frictionbench
from tests.helpers.edits import CASES, edited, mutated
from tests.helpers.made_results import solve_row, write_folder
from tests.helpers.plugin import write
from tests.helpers.runs import run_of

SCHEMA = arrow_schema("solves")


@pytest.mark.parametrize("name", ["shards", "problems", "paper", "shrunk"])
def test_folder_links_are_not_followed(tmp_path, name) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ResultsError, match=f"{name}: is a symbolic link"):
        files.subfolder(tmp_path / "run", name)


def test_report_replaces_links(tmp_path) -> None:
    precious = tmp_path / "precious"
    precious.write_text("mine", encoding="utf-8")
    folder = write_folder(tmp_path / "run", [solve_row("a", "p")])
    for name in ("report.html", "manifest.json"):
        (folder / name).unlink(missing_ok=True)
        (folder / name).symlink_to(precious)
    with pytest.raises(FileNotFoundError), files.replaced(tmp_path / "nowhere" / "x"):
        pass
    store.write_manifest(folder, {"settings": {"suite": "made", "tolerances": [1e-4, 1e-8]}})
    write_report(folder)
    assert precious.read_text(encoding="utf-8") == "mine"
    assert "<html" in (folder / "report.html").read_text(encoding="utf-8")
    (folder / "shards" / "solves-1.jsonl").symlink_to(precious)
    with pytest.raises(OSError, match=r"solves-1\.jsonl"), new_shard(folder, "solves", "1"):
        pass


def test_unrepresentable_values_are_dropped(tmp_path) -> None:
    strange = solve_row("a", "p", reason="\ud800" + "x" * 10**6, residual="small", contacts=2**70, solve_times=[None])
    with new_shard(tmp_path, "solves", "1") as write:
        write(strange | {"no such column": 1})
        write(solve_row("b", "p"))
    with open(tmp_path / "shards" / "solves-1.jsonl", "ab") as shard:
        shard.write(b"[" * 10**5 + b"\n\xff\xfe\n{}\n")
    store.write_table(tmp_path, "solves", list(store.rows(tmp_path, "solves").values()))
    rows = store.read_table(tmp_path, "solves").set_index("key")
    assert list(rows.index) == ["a-p-1e-08", "b-p-1e-08"]
    assert len(rows.loc["a-p-1e-08", "reason"]) == store.LONGEST_TEXT
    assert rows.loc["a-p-1e-08", ["residual", "contacts"]].isna().all()
    assert rows.loc["b-p-1e-08", "verdict"] == "solved"


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda table: table.drop_columns(["verdict"]), "column verdict is missing"),
        (lambda table: table.set_column(0, "key", pa.array([1] * len(table))), "column key is int64"),
        (lambda table: _with("key", table, None), "column key holds (nan|None)"),
        (lambda table: _with("tol", table, float("inf")), "column tol holds inf"),
        (lambda table: _with("dimension", table, 7), "column dimension holds 7"),
        (lambda table: pa.table([pa.nulls(400_000, f.type) for f in SCHEMA], schema=SCHEMA), "values; the limit is"),
        (lambda table: _with("reason", pa.concat_tables([table] * 100), "x" * 10**6), "GiB; the limit is"),
    ],
)
def test_invalid_tables_are_refused(tmp_path, monkeypatch, spoil: Callable[[pa.Table], pa.Table], told) -> None:
    monkeypatch.setattr(store, "LARGEST_TABLE", 2**26)
    folder = write_folder(tmp_path, [solve_row("a", "p")])
    table = pq.read_table(folder / "solves.parquet")
    pq.write_table(spoil(table), folder / "solves.parquet", compression="zstd")
    with pytest.raises(ResultsError, match=rf"solves\.parquet: .*{told}"):
        store.read_table(folder, "solves")
    assert compare(folder, folder).exit_code == 2


def _with(name: str, table: pa.Table, value: object) -> pa.Table:
    field = SCHEMA.field(name)
    return table.set_column(SCHEMA.names.index(name), field, pa.array([value] * len(table), field.type))


def test_times_that_no_clock_shows_are_unknown(tmp_path) -> None:
    """As of a plug-in that replaces the clock; 0 is below a clock's resolution, and has no logarithm."""
    given = (-1.0, 1e300, float("nan"), 0.0, 1.0)
    rows = [solve_row("a", f"p{i}", **dict.fromkeys(("form_time", "setup_time", "solve_time"), t)) for i, t in enumerate(given)]
    write_folder(tmp_path, rows)
    for _ in range(2):  # from the table, then from the shards
        table = store.read_table(tmp_path, "solves").set_index("key").sort_index()
        np.testing.assert_array_equal(RankBy.BODIES.time(table), [np.nan] * 3 + [1e-9, 3.0])
        assert [times is None or times[0] for times in table["solve_times"]] == [True, True, True, 0.0, 1.0]
        (tmp_path / "solves.parquet").unlink(missing_ok=True)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 10**6,
        '{"settings": {"a": ' + "9" * 5000,
        f'{{"settings": {{}}, "schema": {SCHEMA_VERSION}, "machine": "x"}}',
        f'{{"settings": {{}}, "schema": {SCHEMA_VERSION + 1}}}',
    ],
)
def test_invalid_manifest(tmp_path, text) -> None:
    (tmp_path / "manifest.json").write_text(text, encoding="utf-8")
    with pytest.raises(ResultsError, match=r"manifest\.json: |has schema version"):
        store.read_manifest(tmp_path)


def complaints(*reads: Callable[[], object]) -> list[str]:
    """The messages of ResultsError and InputError raised by the given reads; other errors propagate."""
    found = []
    for one in reads:
        try:
            one()
        except (ResultsError, InputError) as error:
            found.append(str(error))
    return found


# Of the slow ones the quick tests see edits that are listed by name; each takes a child process or a report.
SLOW = [pytest.param(kind, marks=pytest.mark.slow) for kind in ("problem.hdf5", "manifest.json")]


@pytest.mark.parametrize("kind", ["problem.npz", "solves.parquet", *SLOW])
def test_mutated_files(tmp_path, kind) -> None:
    """Bytes changed, and of a manifest values, which stay JSON."""
    random = np.random.default_rng(12)
    folder = write_folder(tmp_path / "run", [solve_row("a", "p"), solve_row("b", "p")])
    native.save(scene("stack", blocks=2).problem(), folder / "problem.npz")
    fclib.write(scene("stack", blocks=2).problem(), folder / "problem.hdf5")
    content = (folder / kind).read_bytes()
    told = []
    for _ in range(CASES):
        whole = kind == "manifest.json"
        changed = json.dumps(edited(json.loads(content), random)).encode() if whole else mutated(content, random)
        (folder / kind).write_bytes(changed)
        if kind.startswith("problem"):
            told += complaints(lambda: read(folder / kind))
        else:
            told += complaints(lambda: compare(folder, folder), lambda: write_report(folder))
    assert told
    assert not any("\n" in text for text in told)


@pytest.mark.parametrize(
    ("room", "of", "unwritten"),
    [pytest.param(2000, "", "manifest.json", marks=pytest.mark.slow), (9000, "", "parquet"), (9000, "[blocks=50]", "OSError")],
)
def test_full_disk(tmp_path, room, of, unwritten) -> None:
    """The size of files is limited to the given number of bytes. A problem that cannot be stored is not skipped."""
    command = ["run", "smoke", "--scene", f"stack{of}", "--solver", "nsgs", "--out", str(tmp_path / "run")]
    full = "from resource import RLIMIT_FSIZE, setrlimit; from frictionbench.commands.cli import main; "
    full += f"setrlimit(RLIMIT_FSIZE, ({room}, {room})); main()"
    broken = subprocess.run([sys.executable, "-c", full, *command], capture_output=True, text=True, check=False, timeout=120)
    assert broken.returncode == 2
    assert re.match(f"frictionbench: {tmp_path}/run.*{unwritten}: .*File too large", broken.stderr.splitlines()[-1])
    assert frictionbench(*command).returncode == 0
    assert set(store.read_table(tmp_path / "run", "solves")["verdict"]) == {"unsolved" if of else "solved"}


RAW = re.compile("[\x1b\u202e\u2028]|(?i:\\\\u(001b|202e|2028))")  # also as JSON and scripts write them


def test_control_characters_reach_no_reader(tmp_path, monkeypatch) -> None:
    """In names and texts of tables, manifests and baselines, by which a terminal or a browser would be controlled."""
    evil = "x\x1b[31m\u202e\u2028"
    given: dict[str, Any] = dict.fromkeys(("solver", "family", "version", "scene", "status", "reason", "phase"), evil)
    given |= dict.fromkeys(("work", "parameters"), json.dumps({evil: 3}))
    rows = [solve_row(evil, "p", **given | {"verdict": verdict}) for verdict in ("solved", "wrong")]
    monkeypatch.setattr(store, "cleaned", lambda value: value)
    machine = {"host": evil, "processor": evil}
    one, two = (write_folder(tmp_path / row["verdict"], [row], machine=machine, versions={evil: evil}) for row in rows)
    monkeypatch.undo()
    accept(one, tmp_path / "one.tsv")
    compare_folders = ("compare", str(tmp_path / "one.tsv"), str(two), "--out", str(tmp_path / "compared"))
    told = [frictionbench(*command) for command in (compare_folders, ("report", str(one), "--markdown"), ("report", str(two)))]
    assert [done.returncode for done in told] == [1, 0, 0], told
    written = [*one.glob("report.*"), *two.glob("report.*"), *tmp_path.glob("compared/*"), tmp_path / "one.tsv"]
    assert len(written) == 7
    for text in [done.stdout + done.stderr for done in told] + [path.read_text(encoding="utf-8") for path in written]:
        assert not RAW.search(text)


def test_names_of_files_that_are_no_utf8(tmp_path) -> None:
    store.write_manifest(tmp_path, {"settings": {"sources": [{"scene": "a", "parameters": {}, "file": "/a/\udcff.npz"}]}})
    assert store.read_manifest(tmp_path)["settings"]["sources"][0]["file"] == "/a/?.npz"


def test_a_manifest_that_could_not_be_read_again_is_not_written(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(store, "LARGEST_MANIFEST", 2**20)
    with pytest.raises(ResultsError, match="run fewer data files at once"):
        store.write_manifest(tmp_path / "run", {"settings": {"sources": ["x" * 2**20]}})
    assert not (tmp_path / "run").exists()


@pytest.mark.slow  # a worker's own; the quick tests have them in files
def test_control_characters_of_a_worker(tmp_path) -> None:
    evil = "x\x1b[31m\u202e\u2028\u00a0y"
    answer = "Answer(np.zeros((problem.contacts, 2)), Status.STALLED, {evil: 3}, detail=evil)"
    plugin = write(tmp_path / f"{evil}.py", first=f"evil = {evil!r}", body=f"if problem.contacts > 1: return {answer}")
    for _ in ("run", "resumed"):
        (row,) = run_of(tmp_path / "run", plugin).to_dict("records")
        assert (row["reason"], counts(row["work"])) == ("x?[31m??\u00a0y", {"x?[31m??\u00a0y": 3})
    for options in ((), ("--json",)):
        done = frictionbench("solve", "stack[blocks=2]", "--solver", str(plugin), *options)
        assert "[31m" in done.stdout
        assert not RAW.search(done.stdout + done.stderr)


AXIS = {"parameter": "friction", "low": 0.1, "high": 1.0, "count": 3}
MAP = {"name": "m", "scene": "stack", "x": AXIS, "y": AXIS | {"parameter": "push"}, "thresholds": []}


CHANGES = [{"x": AXIS | {"low": low, "scale": "log"}} for low in (0.0, -1.0)] + [{"x": AXIS | {"high": float("inf")}}]
CHANGES += [{"x": AXIS | {"count": 10**6}, "y": AXIS | {"count": 10**6}}, {"x": AXIS | {"scale": "other"}}]
CHANGES += [{"name": "../../x"}, {"parameters": []}, {"thresholds": [1]}]


@pytest.mark.parametrize("change", CHANGES)
def test_edited_maps(change) -> None:
    assert maps_of({"settings": {"maps": [MAP]}})[0].name == "m"
    with pytest.raises(ResultsError, match="maps: cannot be read"):
        maps_of({"settings": {"maps": [MAP | change]}})
