"""The results folder of a run.

    DIR/manifest.json             what was run, where, with which versions and settings
    DIR/problems/HASH.npz         the problems, so that any cell can be rerun
    DIR/shards/TABLE-*.jsonl      rows as they came, one file a writer, appended and flushed row by row
    DIR/solves.parquet, drives.parquet    the shards merged

A shard may end in a torn line (a kill in mid-write): it is dropped, and the cell runs again. A cell that was written twice
counts once, the first row standing. What is read is checked against results.schema; nothing is ever unpickled.
"""

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self, TextIO

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from results.schema import TABLES, arrow_schema

Row = dict[str, Any]
LARGEST_LINE = 64 * 2**20  # bytes; a longer line is not a row of ours
LARGEST_TABLE = 4 * 2**30  # bytes unpacked; a larger table is refused unread
LARGEST_MANIFEST = 64 * 2**20  # bytes


class ResultsError(ValueError):
    """A results folder or file that cannot be used; the message names it."""


class ShardWriter:
    """Appends rows of one table to a shard of its own, each flushed to the disk's cache before the call returns."""

    def __init__(self, folder: Path, table: str, writer: str) -> None:
        self._names = frozenset(column.name for column in TABLES[table])
        shards = folder / "shards"
        shards.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = open(shards / f"{table}-{writer}.jsonl", "a", encoding="utf-8")  # noqa: SIM115
        if self._file.tell():
            self._file.write("\n")  # ends a line that an earlier writer of this shard may have left torn

    def write(self, row: Row) -> None:
        if unknown := row.keys() - self._names:
            raise ResultsError(f"row: unknown columns {sorted(unknown)}")
        self._file.write(json.dumps(row) + "\n")
        self._file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def read_rows(folder: Path, table: str) -> dict[str, Row]:
    """All rows of a table's shards by key, the first row of a key standing, in a reproducible order."""
    rows: dict[str, Row] = {}
    for shard in sorted((folder / "shards").glob(f"{table}-*.jsonl")):
        for row in _parse(shard):
            rows.setdefault(row["key"], row)
    return rows


def _parse(shard: Path) -> Iterator[Row]:
    with open(shard, encoding="utf-8", errors="replace") as lines:
        while line := lines.readline(LARGEST_LINE):
            try:
                row = json.loads(line)
            except ValueError:
                continue  # torn
            if isinstance(row, dict) and isinstance(row.get("key"), str):
                yield row


def merge(folder: Path, table: str, order: list[str]) -> Path | None:
    """Write DIR/TABLE.parquet from the shards, rows in the order of the plan's keys; None where there are no rows."""
    data = _from_shards(folder, table, order)
    if not data.num_rows:
        return None
    path = folder / f"{table}.parquet"
    partial = path.with_suffix(".partial")
    pq.write_table(data, partial)
    os.replace(partial, path)
    return path


def read_table(folder: Path, table: str) -> pd.DataFrame:
    """A merged table, or the shards of a run that was broken off. Errors: ResultsError naming the file and the column."""
    path = folder / f"{table}.parquet"
    if not path.exists():
        return _from_shards(folder, table, []).to_pandas()
    try:
        _refuse_giants(path)
        data = pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        raise ResultsError(f"{path}: not a readable Parquet file ({error})") from None
    schema = arrow_schema(table)
    for field in schema:
        if field.name not in data.column_names:
            raise ResultsError(f"{path}: column {field.name} is missing")
        if data.schema.field(field.name).type != field.type:
            raise ResultsError(f"{path}: column {field.name} is {data.schema.field(field.name).type}, not {field.type}")
    return data.select(schema.names).to_pandas()


def _refuse_giants(path: Path) -> None:
    """A small file can unpack to more than memory holds: look at what it says of itself first."""
    facts = pq.read_metadata(path)
    unpacked = sum(facts.row_group(i).total_byte_size for i in range(facts.num_row_groups))
    if unpacked > LARGEST_TABLE:
        raise ResultsError(f"{path}: unpacks to {unpacked / 2**30:.1f} GiB, more than {LARGEST_TABLE / 2**30:g}")


def _from_shards(folder: Path, table: str, order: list[str]) -> pa.Table:
    schema = arrow_schema(table)
    position = {key: i for i, key in enumerate(order)}
    rows = read_rows(folder, table).values()
    ordered = sorted(rows, key=lambda row: (position.get(row["key"], len(position)), row["key"]))
    try:
        return pa.table({name: [row.get(name) for row in ordered] for name in schema.names}, schema=schema)
    except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
        raise ResultsError(f"{folder}: a row of {table} does not match the schema: {error}") from None


def write_manifest(folder: Path, manifest: Row) -> None:
    """Write DIR/manifest.json whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    partial = folder / "manifest.partial"
    partial.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    os.replace(partial, folder / "manifest.json")


def read_manifest(folder: Path) -> Row:
    """DIR/manifest.json. Errors: ResultsError where DIR is no results folder or its manifest cannot be read."""
    path = folder / "manifest.json"
    if not folder.is_dir():
        raise ResultsError(f"{folder}: no such results folder")
    try:
        if path.stat().st_size > LARGEST_MANIFEST:
            raise ResultsError(f"{path}: larger than {LARGEST_MANIFEST / 2**20:g} MiB")
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ResultsError(f"{folder}: not a results folder (it has no manifest.json)") from None
    except ResultsError:
        raise
    except (OSError, ValueError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
    if not isinstance(manifest, dict) or not isinstance(manifest.get("settings"), dict):
        raise ResultsError(f"{path}: not a manifest of ours (no settings)")
    return manifest
