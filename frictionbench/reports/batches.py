"""The report of a run of batches: the rates of many small problems, or why there is none, on one self-contained page."""

from pathlib import Path
from typing import Any

from frictionbench.reports.templates import environment
from frictionbench.results.batches import HEADER, METHOD, rate_tables
from frictionbench.results.files import write_text
from frictionbench.results.store import read_manifest, read_table


def has_batches(folder: Path) -> bool:
    """Whether a folder holds a run of batches, which have no problems besides. Errors: ResultsError where it holds no run."""
    return bool(read_manifest(folder)["settings"].get("batches"))


def write_batches(folder: Path) -> Path:
    """Write DIR/report.html; return its path. Errors: ResultsError where the folder holds no run of batches."""
    manifest: dict[str, Any] = read_manifest(folder)
    tables = rate_tables(read_table(folder, "batches"))
    path = folder / "report.html"
    page = environment().get_template("batches.html")
    facts = {"name": folder.resolve().name, "finished": "finished" in manifest, "machine": manifest.get("machine", {})}
    write_text(path, page.render(tables=tables, header=HEADER, method=METHOD, **facts))
    return path
