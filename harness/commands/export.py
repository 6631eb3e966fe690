"""`frictionbench export`: problems of a scene, an instance or a run as files in FCLIB's HDF5 format."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

from frictionbench.harness.cells.collect import Entry, collect, stored_friction
from frictionbench.harness.plans.plan import Source
from frictionbench.harness.plans.spec import parse
from frictionbench.problems import InputError
from frictionbench.problems.recorded import fclib
from frictionbench.results import store


def export(what: str, out: Path, pick: int = 0) -> Iterator[Path]:
    """Write the problems and yield the files. Errors: InputError naming what is unknown or cannot be written."""
    if (Path(what) / "manifest.json").exists():
        store.read_manifest(Path(what))
        entries = [
            entry
            for listed in sorted((Path(what) / "problems").glob("source-*.json"))
            for entry in json.loads(listed.read_text(encoding="utf-8"))
        ]
        yield from _written(Path(what), entries, out)
    else:
        with tempfile.TemporaryDirectory() as folder:
            entries = collect(Path(folder), Source(*parse("scene", what), pick=pick))
            yield from _written(Path(folder), entries, out)


def _written(folder: Path, entries: list[Entry], out: Path) -> Iterator[Path]:
    if len(entries) != 1 and out.suffix:
        raise InputError(f"out: {len(entries)} problems need a folder, and {out} looks like a file")
    for entry in entries:
        problem = stored_friction(folder, entry["problem"])
        path = out if out.suffix else out / f"{entry['scene']}-{entry['step']:05d}-{entry['contacts']}-{entry['problem']}.hdf5"
        if path.exists():
            raise InputError(f"out: {path} is there already; nothing was written over it")
        path.parent.mkdir(parents=True, exist_ok=True)
        fclib.write(problem, path, entry["scene"], f"frictionbench {entry['scene']} {entry['parameters']} step {entry['step']}")
        yield path
