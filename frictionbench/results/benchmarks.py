"""Times of kernels from the JSON of pytest-benchmark: a file is one process, a folder of files several alternating ones.

`make timing` writes them. A benchmark is read as a cell with its median. Two files are a single pair, which is not enough for a
confidence interval (results.times).
"""

from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.cells import NUMBERS, TEXTS, Cells
from frictionbench.results.files import ResultsError, read_json

LARGEST = 64 * 2**20  # bytes; pytest-benchmark stores every round
MACHINE = ("node", "machine", "system", "python_version")


def is_benchmark(path: Path) -> bool:
    """Whether the path is a JSON file or a folder of JSON files other than a results folder."""
    return bool(_files(path)) and not (path / "manifest.json").exists()


def _files(path: Path) -> list[Path]:
    return sorted(path.glob("*.json")) if path.is_dir() else [path] if path.suffix == ".json" else []


def read(path: Path) -> list[Cells]:
    """The processes in the order of their file names. Errors: ResultsError naming the file."""
    return [_process(file) for file in _files(path)]


def _process(path: Path) -> Cells:
    try:
        content: Any = read_json(path, LARGEST)
        medians = {str(one["fullname"]): float(one["stats"]["median"]) for one in content["benchmarks"]}
        machine = {name: content["machine_info"].get(name) for name in MACHINE}
    except ResultsError:
        raise
    except (KeyError, TypeError, AttributeError, ValueError, OverflowError):
        raise ResultsError(f"{path}: not a result of pytest-benchmark (it has no benchmarks with medians)") from None
    table = pd.DataFrame(
        {"variant": list(medians), "seconds": list(medians.values())}, index=pd.Index(list(medians), name="key")
    )
    table = table.assign(**{name: "" for name in TEXTS if name != "variant"}, disturbed=False, tol=0.0)
    table = table.assign(**{name: float("nan") for name in NUMBERS if name not in table})
    table = table.assign(table="benchmark", verdict=Verdict.SOLVED, seconds=table["seconds"].where(table["seconds"] > 0))
    return Cells(path, table, "benchmarks", (), machine, made=str(content.get("datetime", "")))
