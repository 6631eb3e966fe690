"""`frictionbench export SUITE`: the generated problems of suites as a data set that is used without this package.

DIR/README.md            the data card
DIR/problems.tsv         a line for each problem: where it comes from, sizes, rank, labels, hash, files, known answer
DIR/npz/HASH.npz         plain arrays
DIR/fclib/HASH.hdf5      FCLIB's format, where that can hold the problem, with the known answer as its solution
DIR/answers/HASH.npz     `impulse` (nc, d), N s, normal first, and the `residual` that was verified
DIR/SHA256SUMS           of all files
"""

import json
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from frictionbench.harness import machine
from frictionbench.harness.cells.collect import Record, collect, stored
from frictionbench.harness.cells.reference import ACCEPTED, NoReference, Reference
from frictionbench.harness.plans.choose import choose
from frictionbench.harness.plans.plan import Source
from frictionbench.problems import LCP, FrictionProblem, InputError
from frictionbench.problems.check import Array
from frictionbench.problems.recorded import fclib, own
from frictionbench.problems.residual import residual
from frictionbench.results.conventions import scene_title
from frictionbench.results.schema import SOLVES

FACTS = (
    *("scene", "parameters", "step", "phase", "dimension", "contacts", "velocities", "size"),
    *("rank", "condition", "redundancy", "pointedness", "p0_margin", "mass_ratio", "largest_friction", "islands"),
    *("trivial", "idle", "solutions", "existence"),
)
FILES = ("problem", "npz", "fclib", "answer", "answer_residual")
SUITES = ("standard", "spatial", "hard")


def dataset(suites: Sequence[str], scenes: Sequence[str], out: Path, tell: Callable[[str], None]) -> Path:
    """Write the problems of the suites, or of the scenes that are named; return the data card.

    Errors: InputError naming suite, scene or out.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"out: {out} exists and is not empty")
    sources = [source for suite in suites or SUITES for source in choose(suite, list(scenes), (), None, None).sources]
    rows: dict[str, dict[str, Any]] = {}
    for folder in ("npz", "fclib", "answers"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        for source in sources:
            for record in _records(Path(scratch), source, tell):
                if record["problem"] not in rows:
                    rows[record["problem"]] = _written(stored(Path(scratch), record["problem"]), record, out)
                    tell(f"{len(rows)}: {scene_title(record['scene'], record['parameters'])}")
    return _described(list(rows.values()), suites or SUITES, out)


def _records(folder: Path, source: Source, tell: Callable[[str], None]) -> list[Record]:
    if source.file:  # recorded by others, under licences of their own
        return []
    try:
        return collect(folder, source)
    except InputError as error:
        tell(f"{source.scene}: left out, {error}")
        return []


def _written(problem: FrictionProblem | LCP, record: Record, out: Path) -> dict[str, Any]:
    """Write the files of a problem; return its line."""
    name = problem.hash
    own.save(problem, out / "npz" / f"{name}.npz")
    row: dict[str, Any] = {fact: record[fact] for fact in FACTS} | {"problem": name, "npz": f"npz/{name}.npz"}
    if isinstance(problem, LCP):
        return row
    try:
        impulse = Reference()(problem)
    except NoReference:
        impulse = None
    if impulse is not None:
        found = residual(problem, impulse)
        np.savez(out / "answers" / f"{name}.npz", impulse=impulse, residual=found)
        row |= {"answer": f"answers/{name}.npz", "answer_residual": f"{found:.1e}"}
    if not problem.friction_bias.any():
        path = out / "fclib" / f"{name}.hdf5"
        title = f"frictionbench {scene_title(record['scene'], record['parameters'])} step {record['step']}"
        fclib.write(problem, path, record["scene"], title)
        if impulse is not None and not problem.joints.shape[0]:  # a solution with joints has their impulses as well
            _write_solution(problem, impulse, path)
        row["fclib"] = f"fclib/{name}.hdf5"
    return row


def _write_solution(problem: FrictionProblem, impulse: Array, path: Path) -> None:
    """Add FCLIB's group `solution`: velocities v where the form has them, contact velocities u, impulses r."""
    import h5py

    with h5py.File(path, "a") as file:
        if problem.mechanical:
            file["solution/v"] = problem.velocity(impulse)
        file["solution/u"] = problem.contact_velocity(impulse).ravel()
        file["solution/r"] = impulse.ravel()


def _described(rows: list[dict[str, Any]], suites: Sequence[str], out: Path) -> Path:
    columns = (*FILES, *FACTS)
    lines = ["\t".join(columns), *("\t".join(_text(row.get(column)) for column in columns) for row in rows)]
    (out / "problems.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    card = out / "README.md"
    card.write_text(_card(rows, suites), encoding="utf-8")
    written = sorted(path for path in out.rglob("*") if path.is_file())
    sums = [f"{sha256(path.read_bytes()).hexdigest()}  {path.relative_to(out).as_posix()}\n" for path in written]
    (out / "SHA256SUMS").write_text("".join(sums), encoding="utf-8")
    return card


def _text(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value) if isinstance(value, str | int) else json.dumps(value)


def _card(rows: list[dict[str, Any]], suites: Sequence[str]) -> str:
    meanings = {column.name: f"{column.meaning}{f' ({column.unit})' if column.unit else ''}" for column in SOLVES}
    scenes = Counter(row["scene"] for row in rows)
    values = {
        "suites": ", ".join(suites),
        "version": machine.revision(),
        "count": len(rows),
        "answered": sum("answer" in row for row in rows),
        "accepted": f"{ACCEPTED:g}",
        "fclib": sum("fclib" in row for row in rows),
        "scenes": "\n".join(_scene_line(scene, [row for row in rows if row["scene"] == scene]) for scene in sorted(scenes)),
        "columns": "\n".join(f"| `{name}` | {meanings[name]} |" for name in FACTS),
    }
    text = files("frictionbench.commands").joinpath("data_card.md").read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(f"{{{name}}}", str(value))
    return text


def _scene_line(scene: str, rows: list[dict[str, Any]]) -> str:
    contacts = [row["contacts"] for row in rows if row["contacts"] is not None]
    spread = f"{min(contacts)} to {max(contacts)}" if contacts else ""
    dimensions = ", ".join(sorted({f"{row['dimension']}" for row in rows}))
    return f"| `{scene}` | {len(rows)} | {dimensions} | {spread} | {sum(bool(row['trivial'] or row['idle']) for row in rows)} |"
