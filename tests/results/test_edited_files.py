"""Results folders, baselines and problems that someone edited: every command ends in 0 or 2 with one line.

A few cases by default; FRICTIONBENCH_MUTATIONS=1000 runs more, and fails where the process needs more than 500 MB in addition.
"""

import json
import os
import resource
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from frictionbench.harness.commands.accept import accept
from frictionbench.problems import scene
from frictionbench.problems.recorded import own
from frictionbench.results.schema import arrow_schema
from tests.helpers.command_line import Done, frictionbench
from tests.helpers.made_results import SETTINGS, simulation_row, solve_row, write_folder

CASES = int(os.environ.get("FRICTIONBENCH_MUTATIONS", "10"))
MOST_MEMORY = 500_000  # KiB
STRANGE: list[Any] = [
    None,
    True,
    -1,
    0,
    2**70,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "{",
    "../x",
    "\x00\x1b[31m",
    "ü" * 9,
    [],
    {},
]
STRANGE += [[[]], {"a": 1}, [1e308], "x" * 10**5, "\ud800", -(10**30), [None] * 9]


def edited(value: Any, random: np.random.Generator) -> Any:
    """The value with one part of it replaced, doubled or taken away."""
    if isinstance(value, dict) and value and random.random() < 0.9:
        name = list(value)[random.integers(len(value))]
        if random.random() < 0.2:
            return {key: part for key, part in value.items() if key != name}
        return value | {name: edited(value[name], random)}
    if isinstance(value, list) and value and random.random() < 0.8:
        i = int(random.integers(len(value)))
        return [*value[:i], edited(value[i], random), *value[i + (random.random() < 0.8) :]]
    return STRANGE[random.integers(len(STRANGE))]


def good(done: Done, compared: bool = False) -> None:
    """Assert that the command did what it can, or refused its input in one line; a comparison may find a regression."""
    assert done.returncode in ((0, 1, 2) if compared else (0, 2)), done
    if done.returncode == 2 and not compared:
        assert len(done.stderr.strip().splitlines()) == 1, done
    if done.returncode == 1:
        assert "worse" in done.stdout, done
    assert "\x1b" not in done.stdout + done.stderr


@pytest.fixture
def folder(tmp_path):
    rows = [solve_row(variant, problem, work='{"pivots": 3}') for variant in ("lemke", "nsgs") for problem in ("abc", "def")]
    return write_folder(tmp_path / "run", rows, [simulation_row("lemke")], settings=SETTINGS | {"memory_limit": 2**32})


def memory() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def commands(case, run, before, tmp_path) -> None:
    good(frictionbench("compare", str(before), str(run)), compared=True)
    good(frictionbench("compare", str(run), str(before), "--out", str(tmp_path / "out")), compared=True)
    good(frictionbench("history", str(before), str(run)))
    good(frictionbench("accept", str(run), str(tmp_path / "new.tsv")))
    if case % 20 == 19:  # it takes far longer than the others
        good(frictionbench("report", str(run), "--markdown"))


def test_edited_manifests(folder, tmp_path) -> None:
    random, path, used = np.random.default_rng(1), folder / "manifest.json", memory()
    accept(folder, tmp_path / "before.tsv")
    manifest = json.loads(path.read_text(encoding="utf-8"))
    manifest["settings"] |= {"plugins": [{"source": "x", "solvers": {"a": {}}}], "maps": [], "sources": []}
    for case in range(CASES):
        path.write_text(json.dumps(edited(manifest, random)), encoding="utf-8")
        commands(case, folder, tmp_path / "before.tsv", tmp_path)
    assert memory() < used + MOST_MEMORY


@pytest.mark.parametrize("table", ["solves", "simulations"])
def test_edited_tables(folder, tmp_path, table) -> None:
    random, path, used = np.random.default_rng(2), folder / f"{table}.parquet", memory()
    accept(folder, tmp_path / "before.tsv")
    rows, schema = pq.read_table(path).to_pylist(), arrow_schema(table)
    for case in range(CASES):
        while True:
            try:
                content = pa.Table.from_pylist([row for row in edited(rows, random) if row], schema=schema)
                break
            except (pa.ArrowException, TypeError, ValueError, AttributeError, OverflowError):
                continue  # a value that the column cannot hold
        pq.write_table(content, path)
        commands(case, folder, tmp_path / "before.tsv", tmp_path)
    assert memory() < used + MOST_MEMORY


def test_edited_baselines(folder, tmp_path) -> None:
    random, path, used = np.random.default_rng(3), tmp_path / "before.tsv", memory()
    accept(folder, path)
    lines = [line.split("\t") for line in path.read_text(encoding="utf-8").splitlines()]
    for _ in range(CASES):
        changed = edited(lines, random)
        text = "\n".join(
            "\t".join(map(str, line)) if isinstance(line, list) else str(line)
            for line in (changed if isinstance(changed, list) else [changed])
        )
        path.write_text(text, encoding="utf-8", errors="replace")
        done = frictionbench("compare", str(path), str(folder))
        assert done.returncode == 2 or (done.returncode == 0 and changed == lines), done
        assert len(done.stdout.strip().splitlines()) <= 3, done
        good(frictionbench("history", str(path), str(folder)))
        good(frictionbench("accept", str(folder), str(path)))
    assert memory() < used + MOST_MEMORY


def test_edited_problems(tmp_path) -> None:
    random, path, used = np.random.default_rng(4), tmp_path / "problem.npz", memory()
    own.save(scene("stack", blocks=2).problem(), path)
    with np.load(path) as stored:
        arrays = dict(stored)
    for _ in range(CASES):
        name = list(arrays)[random.integers(len(arrays))]
        flat = arrays[name].ravel().tolist()
        try:
            changed = np.array(edited(flat, random) if flat else [1.0]).astype(arrays[name].dtype)
        except (TypeError, ValueError, OverflowError):
            continue
        np.savez(path, **arrays | {name: changed if random.random() < 0.8 else changed.astype(str)})
        good(frictionbench("export", str(path), "--out", str(tmp_path / "out.hdf5")))
        (tmp_path / "out.hdf5").unlink(missing_ok=True)
        try:
            own.load(path)
        except own.InputError as error:
            assert "\n" not in str(error)  # noqa: PT017
    assert memory() < used + MOST_MEMORY
