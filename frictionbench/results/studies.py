"""What a study leaves: its question, its method and its tables, in the folder DIR/NAME.

study.json      what is asked and how, the columns of each table, and the code that computes them
TABLE.json      the rows of a computed table
runs/           the solver runs of the study, a results folder like any other (results.store)
recorded/       the same on recorded problems, where they were given
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from frictionbench.results.files import ResultsError, read_json, subfolder, write_text
from frictionbench.results.store import Row, read_manifest, read_table

DESCRIPTION, RUNS, RECORDED, MANIFEST = "study.json", "runs", "recorded", "manifest.json"


@dataclass(frozen=True)
class Description:
    """What a study asks and how it answers.

    columns: by computed table the meaning of each column, with its unit. runs: whether it has solver runs besides. code: what
    computes the tables, for people; content: a hash of it.
    """

    name: str
    question: str
    method: str
    columns: dict[str, dict[str, str]]
    runs: bool
    code: str
    content: str


@dataclass(frozen=True)
class StudyTables:
    """A study's tables by name; of solver runs `solves` and `simulations`, with the columns of results.schema.

    `recorded` has the rows of `solves` of recorded problems, where they were given.
    """

    about: Description
    tables: Mapping[str, pd.DataFrame] = field(repr=False)

    def __getitem__(self, table: str) -> pd.DataFrame:
        return self.tables[table]

    def require(self, holds: object, claim: str) -> None:
        """Errors: ResultsError with the claim, where the tables do not hold what the study's text would say."""
        if not holds:
            raise ResultsError(f"{self.about.name}: the tables do not show what the text says: {claim}")


def open_study(folder: Path, about: Description) -> None:
    """Begin a study in folder/NAME, or check that this code began it. Errors: ResultsError where it was another."""
    path = subfolder(folder, about.name) / DESCRIPTION
    if path.exists() and (began := _described(path)) != about:
        raise ResultsError(f"{path.parent}: computed by {began.code}, now {about.code}; delete it or choose another --out")
    write_text(path, json.dumps(asdict(about), indent=1))


def written(folder: Path, about: Description) -> set[str]:
    """The computed tables that are complete."""
    return {table for table in about.columns if (folder / about.name / f"{table}.json").exists()}


def finished(folder: Path, name: str) -> bool:
    """Whether folder holds all tables of a study. Errors: ResultsError where its description cannot be read."""
    path = folder / name / DESCRIPTION
    if not path.exists():
        return False
    about, runs = _described(path), path.parent / RUNS
    return (not about.runs or _run(runs)) and written(folder, about) == set(about.columns)


def write_rows(folder: Path, about: Description, table: str, rows: Any) -> None:
    """Write a computed table. Errors: ResultsError where its rows do not have the columns described."""
    columns = list(about.columns[table])
    if not isinstance(rows, list) or not all(isinstance(row, dict) and list(row) == columns for row in rows):
        raise ResultsError(f"{about.name}: the rows of the table {table} do not have the columns {', '.join(columns)}")
    write_text(folder / about.name / f"{table}.json", json.dumps(rows))


def read_study(folder: Path, name: str) -> StudyTables:
    """The tables of a finished study. Errors: ResultsError naming the file that is missing or cannot be read."""
    about = _described(folder / name / DESCRIPTION)
    tables = {table: _read_rows(folder / name / f"{table}.json", columns) for table, columns in about.columns.items()}
    if about.runs:
        tables |= {table: read_table(folder / name / RUNS, table) for table in ("solves", "simulations")}
    if _run(folder / name / RECORDED):
        tables[RECORDED] = read_table(folder / name / RECORDED, "solves")
    return StudyTables(about, tables)


def _run(runs: Path) -> bool:
    """Whether a folder holds finished solver runs."""
    return (runs / MANIFEST).exists() and "finished" in read_manifest(runs)


def _described(path: Path) -> Description:
    try:
        return Description(**read_json(path))
    except FileNotFoundError:
        raise ResultsError(f"{path}: missing; the study was not begun in this folder") from None
    except TypeError as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None


def _read_rows(path: Path, columns: dict[str, str]) -> pd.DataFrame:
    try:
        rows: list[Row] = read_json(path)
        return pd.DataFrame([{name: row[name] for name in columns} for row in rows], columns=list(columns))
    except FileNotFoundError:
        raise ResultsError(f"{path}: missing; run the study again to complete it") from None
    except (TypeError, LookupError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
