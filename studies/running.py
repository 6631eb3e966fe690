"""The tables of studies, each computed in its own process, and the page made from them.

    OUT/NAME/TABLE.parquet   a computed table
    OUT/NAME/runs            the solver runs of a study, a results folder like any other
    OUT/studies.md, studies/ the page of all studies in OUT, and its figures as SVG and PDF

A table is computed again if the code that computes it has changed: that of problems, solvers and motions.py, and that of the
study above its `summary`. An interrupted call is resumed by the same command.
"""

import os
import re
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from hashlib import sha256
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from frictionbench.harness.machine import content
from frictionbench.harness.process import die_with_parent
from frictionbench.harness.progress import Progress
from frictionbench.harness.run import run as run_plan
from frictionbench.reports.drawing.files import save_sheet
from frictionbench.reports.drawing.text import escaped
from frictionbench.results.files import subfolder, write_text
from frictionbench.results.store import read_table
from studies.study import Study, Summary, Tables

NAMES = (  # in the order of the page
    *("convexity", "relaxation", "interior", "inclusion", "cone", "outcomes"),
    *("orders", "events", "substeps", "coordinates", "compliance", "neighbours", "warm", "rankings", "exactness", "precision"),
)
HERE = Path(__file__).parent
FIGURES = "studies"  # the folder of the figures that studies.md shows
PANEL = (3.4, 2.5)  # inches
CODE = b"code"  # the hash of the code that computed a table, in its file's metadata


def study(name: str) -> Study:
    module_study: Study = import_module(f"studies.{name}").STUDY
    return module_study


def code(name: str) -> str:
    """Return a hash of what computes a study's tables: the package, its file and those it imports, above their summary."""
    return sha256((_computing(name) + content(("problems", "solvers"))).encode()).hexdigest()


def _computing(name: str) -> str:
    above = (HERE / f"{name}.py").read_text(encoding="utf-8").partition("\ndef summary(")[0]
    return above + "".join(map(_computing, sorted({*re.findall(r"^from studies\.(\w+) import", above, re.M)} - {"study"})))


def compute(names: Sequence[str], out: Path, jobs: int) -> None:
    """Compute the tables that are missing. Errors: as for harness.run."""
    missing = [(name, rows.__name__) for name in names for rows in study(name).rows if not _kept(out, name, rows.__name__)]
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # one core per table
    with ProcessPoolExecutor(jobs, get_context("spawn"), die_with_parent, (os.getpid(),)) as pool:
        for done in as_completed([pool.submit(write_rows, out, *table) for table in missing]):
            print(done.result(), file=sys.stderr)
    for name in names:
        if (plan := study(name).plan) is not None:
            run_plan(plan(), subfolder(out, name) / "runs", jobs, Progress())


def write_rows(out: Path, name: str, table: str, settings: Mapping[str, Any] | None = None) -> Path:
    """Compute a table and write it. settings: arguments of its generator that differ from the defaults."""
    rows = next(rows for rows in study(name).rows if rows.__name__ == table)
    found = pa.Table.from_pandas(pd.DataFrame(rows(**settings or {})), preserve_index=False)
    path = subfolder(out, name) / f"{table}.parquet"
    partial = path.with_suffix(".partial")
    pq.write_table(found.replace_schema_metadata({**(found.schema.metadata or {}), CODE: code(name)}), partial)
    return partial.replace(path)


def _kept(out: Path, name: str, table: str) -> bool:
    path = out / name / f"{table}.parquet"
    return path.exists() and (pq.read_schema(path).metadata or {}).get(CODE) == code(name).encode()


def read(out: Path, name: str) -> Tables | None:
    """Read the tables of a study; None if one is missing."""
    of_study, runs = study(name), out / name / "runs"
    paths = [out / name / f"{rows.__name__}.parquet" for rows in of_study.rows]
    if not all(path.exists() for path in paths) or (of_study.plan and not (runs / "solves.parquet").exists()):
        return None
    tables = {path.stem: pd.read_parquet(path) for path in paths}
    return tables | ({"solves": read_table(runs, "solves")} if of_study.plan else {})


def write_page(out: Path) -> Path:
    """Write OUT/studies.md and its figures, for all studies that are complete in OUT."""
    texts = []
    for name in NAMES:
        tables = read(out, name)
        if tables is not None:
            summary = study(name).summary(tables)
            texts.append(text(name, summary))
            for figure, panels in summary.figures.items():
                stem = subfolder(out, FIGURES) / f"{name}_{figure}"
                save_sheet(panels, dict(summary.looks), stem, min(2, len(panels)), PANEL, 8, paper="white")
    write_text(out / "studies.md", _environment().get_template("page.md").render(studies=texts))
    return out / "studies.md"


def text(name: str, summary: Summary) -> dict[str, str]:
    """Return a study's question, answer and text in Markdown, with its numbers filled in."""

    def figure(sheet: str, caption: str) -> str:
        return f"![{caption}]({FIGURES}/{name}_{sheet}.svg)\n\n{caption}"

    numbers = {key: escaped(value) if isinstance(value, str) else value for key, value in summary.numbers.items()}
    module: Any = _environment().get_template(f"{name}.md").make_module({"figure": figure, **numbers})
    question, answer = (" ".join(str(part).split()) for part in (module.question, module.answer))
    return {"name": name, "question": question, "answer": answer, "body": str(module).strip()}


def _environment() -> Environment:
    return Environment(loader=FileSystemLoader(HERE / "text"), undefined=StrictUndefined, keep_trailing_newline=True)
