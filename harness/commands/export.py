"""`frictionbench export`: problems of a scene, an instance or a run as files in FCLIB's HDF5 format."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from frictionbench.harness.cells.collect import Record, collect, stored_friction
from frictionbench.harness.plans.plan import Source
from frictionbench.problems import InputError
from frictionbench.problems.recorded import fclib
from frictionbench.problems.spec import parse
from frictionbench.results import store
from frictionbench.results.files import read_json


def export(what: str, out: Path, pick: int = 0) -> Iterator[Path]:
    """Write the problems and yield the files. Errors: InputError naming the argument that is unknown or cannot be written."""
    if (Path(what) / "manifest.json").exists():
        store.read_manifest(Path(what))
        records = [record for listed in sorted((Path(what) / "problems").glob("source-*.json")) for record in read_json(listed)]
        yield from _written(Path(what), records, out)
    else:
        with tempfile.TemporaryDirectory() as folder:
            records = collect(Path(folder), Source(*parse("scene", what), pick=pick))
            yield from _written(Path(folder), records, out)


def _written(folder: Path, records: list[Record], out: Path) -> Iterator[Path]:
    if len(records) != 1 and out.suffix:
        raise InputError(f"out: {len(records)} problems need a folder, and {out} has the suffix of a file")
    for record in records:
        problem = stored_friction(folder, record["problem"])
        path = (
            out if out.suffix else out / f"{record['scene']}-{record['step']:05d}-{record['contacts']}-{record['problem']}.hdf5"
        )
        if path.exists():
            raise InputError(f"out: {path} exists; it was not overwritten")
        path.parent.mkdir(parents=True, exist_ok=True)
        fclib.write(
            problem, path, record["scene"], f"frictionbench {record['scene']} {record['parameters']} step {record['step']}"
        )
        yield path
