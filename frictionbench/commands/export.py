"""`frictionbench export`: write problems of a scene, an instance or a run to files, in FCLIB's HDF5 format or as our .npz, and
fetch recorded problems from their public collection into the user's cache."""

import re
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

from frictionbench.harness import process
from frictionbench.harness.cells.collect import collect
from frictionbench.harness.cells.stored import Record, read_records, stored
from frictionbench.harness.plans.plan import MEMORY_LIMIT, Source
from frictionbench.harness.progress import Progress
from frictionbench.harness.workers.pool import scratch_folder
from frictionbench.problems import LCP, InputError
from frictionbench.problems.check import require
from frictionbench.problems.recorded import collection, fclib, native
from frictionbench.problems.spec import parse
from frictionbench.results import store
from frictionbench.results.files import replaced

SUFFIXES = ("", *fclib.SUFFIXES, ".npz")


def export(what: str, out: Path, pick: int = 0) -> Iterator[Path]:
    """Write the problems and yield the files. Errors: InputError naming the argument that is unknown or cannot be written."""
    of_run = (Path(what) / "manifest.json").exists()
    with nullcontext(Path(what)) if of_run else scratch_folder() as folder, process.memory_within(MEMORY_LIMIT):
        if of_run:
            store.read_manifest(folder)
            listed = sorted((folder / "problems").glob("source-*.json"))
            records = [record for path in listed for record in read_records(path)]
        else:
            records = collect(folder, Source(*parse("scene", what), pick=pick))
        yield from _written(folder, records, out)


def _written(folder: Path, records: list[Record], out: Path) -> Iterator[Path]:
    """Write each problem once, even if several sources share it. In a folder, those that FCLIB's format lacks are .npz files.

    Files in a folder are named by their content, so that existing ones, as after an interruption, are kept.
    """
    require(bool(records), "DIR", f"{folder} holds no problems")
    named = {}
    for record in records:
        scene = re.sub(r"[^A-Za-z0-9_.-]", "_", record["scene"])
        named[f"{scene}-{record['step']:05d}-{record['contacts']}-{record['problem']}"] = record
    one = len(named) == 1 or not out.suffix
    require(one, "out", f"{len(named)} problems need a folder, and {out} has the suffix of a file")
    require(out.suffix in SUFFIXES, "out", f"{out} must end in {', '.join(filter(None, SUFFIXES))}, or name a folder")
    for name, record in named.items():
        problem = stored(folder, record["problem"])
        ours = isinstance(problem, LCP) or problem.friction_bias.any()
        path = out if out.suffix else out / f"{name}{'.npz' if ours else '.hdf5'}"
        require(not (out.suffix and path.exists()), "out", f"{path} exists; it was not overwritten")
        if ours and path.suffix != ".npz":
            raise InputError(f"out: FCLIB's format has neither friction biases nor bare LCPs, as {name} is; write it as .npz")
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            with replaced(path) as file:
                if isinstance(problem, LCP) or path.suffix == ".npz":
                    native.save(problem, file)
                else:
                    title = f"frictionbench {record['scene']} {record['parameters']} step {record['step']}"
                    fclib.write(problem, file, record["scene"], title)
        yield path


def fetch(name: str) -> None:
    """Fetch a family with a progress bar. Errors: InputError naming the family or the file."""
    family = collection.family(name)
    files = collection.registry()[family]
    for _ in Progress().counted(f"fclib/{family}", collection.fetch(family), len(files)):
        pass
    print(f"{len(files)} files in {collection.cache_folder() / family}")
    print(f"run them: frictionbench run recorded --data fclib/{family}")
