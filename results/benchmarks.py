"""Times of kernels as pytest-benchmark's JSON has them: a file is one process, a folder of files several that ran in turn.

`make timing` writes them. A benchmark stands as a cell with its median; two files are one pair, of which nothing can be said
for sure (results.times).
"""

import json
from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.results.cells import NUMBERS, TEXTS, Cells
from frictionbench.results.files import ResultsError
from frictionbench.results.verdicts import Verdict

LARGEST = 256 * 2**20  # bytes
MACHINE = ("node", "machine", "system", "python_version")


def are(path: Path) -> bool:
    """Whether the path is of such times: a file in JSON, or a folder of them."""
    return bool(_files(path)) and not (path / "manifest.json").exists()


def _files(path: Path) -> list[Path]:
    return sorted(path.glob("*.json")) if path.is_dir() else [path] if path.suffix == ".json" else []


def read(path: Path) -> list[Cells]:
    """The processes in the order of their files' names. Errors: ResultsError naming the file."""
    return [_process(file) for file in _files(path)]


def _process(path: Path) -> Cells:
    try:
        if path.stat().st_size > LARGEST:
            raise ResultsError(f"{path}: larger than {LARGEST / 2**20:g} MiB")
        told: Any = json.loads(path.read_text(encoding="utf-8"))
        medians = {str(one["fullname"]): float(one["stats"]["median"]) for one in told["benchmarks"]}
        machine = {name: told["machine_info"].get(name) for name in MACHINE}
    except ResultsError:
        raise
    except (OSError, ValueError, RecursionError) as error:
        raise ResultsError(f"{path}: cannot be read ({str(error)[:300]})") from None
    except (KeyError, TypeError, AttributeError):
        raise ResultsError(f"{path}: not a result of pytest-benchmark (no benchmarks with their medians)") from None
    table = pd.DataFrame(
        {"variant": list(medians), "seconds": list(medians.values())}, index=pd.Index(list(medians), name="key")
    )
    table = table.assign(**{name: "" for name in TEXTS if name != "variant"}, disturbed=False, tol=0.0)
    table = table.assign(**{name: float("nan") for name in NUMBERS if name not in table})
    table = table.assign(table="benchmark", verdict=Verdict.SOLVED, seconds=table["seconds"].where(table["seconds"] > 0))
    return Cells(path, table, "benchmarks", (), machine, made=str(told.get("datetime", "")))
