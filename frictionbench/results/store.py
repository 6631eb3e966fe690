"""The results folder of a run.

    DIR/manifest.json             what was run, on which machine, with which versions and settings
    DIR/convergence.json          convergence histories on a few problems, see results.histories
    DIR/maps/NAME.json            thresholds on the maps, see results.maps
    DIR/problems/HASH.npz         the problems, so that any cell can be rerun
    DIR/shards/TABLE-*.jsonl      rows in order of arrival, one file per writer, appended and flushed row by row
    DIR/TABLE.parquet             the merged shards
    DIR/judgement.json, judged/   judged steps of an engine, see results.judgement, and the problems by which they are judged
    DIR/shrunk/                   failing problems reduced in size, see commands.shrink
    DIR/report.html, report.md, paper/    made from the files above, see reports

A line that is not a row, such as one whose writer was killed, is ignored, and its cell is run again. The first of several rows
with one key counts. Tables are written from the rows found at the start and those that the main process keeps in memory.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from frictionbench.results.files import ResultsError, cleaned, opened, parsed, read_json, replaced, subfolder, write_text
from frictionbench.results.schema import SCHEMA_VERSION, TABLES, arrow_schema

Row = dict[str, Any]
# Limits on input: far above the sizes of the largest suite, and small enough for a machine with 4 GiB of memory.
LARGEST_LINE = 64 * 2**20  # bytes; a longer line is not a row
LARGEST_SHARD = 2**28  # bytes
LARGEST_TABLE = 2**30  # bytes after decompression
MOST_VALUES = 2 * 10**7  # values in all columns of a table together
LARGEST_MANIFEST = 32 * 2**20  # bytes
LONGEST_TIME = 1e9  # s, thirty years
LONGEST_TEXT = 20_000  # characters of a text value; a longer text, such as an exception that prints an array, is cut


@contextmanager
def new_shard(folder: Path, table: str, writer: str) -> Iterator[Callable[[Row], None]]:
    """Open a new shard of one table, which is removed if it stays empty. Provide a function that appends a row, `fitted` to the
    table, and passes it to the operating system before it returns. Errors: OSError naming the shard."""
    schema, path = arrow_schema(table), subfolder(folder, "shards") / f"{table}-{writer}.jsonl"

    def write(row: Row) -> None:
        line = json.dumps(fitted(row, schema)).encode() + b"\n"
        try:
            if file.write(line) != len(line):
                raise OSError(28, "No space left on device")
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(path)) from None

    with open(path, "xb", buffering=0) as file:  # fails if the path exists, even as a link
        try:
            yield write
        finally:
            if not file.tell():
                path.unlink(missing_ok=True)


def fitted(row: Row, schema: pa.Schema) -> Row:
    """Return the row with each value in its column's type. Values of another type are left out, long texts are cut."""
    fit = {field.name: _fitted(row.get(field.name), field.type) for field in schema}
    return {name: value for name, value in fit.items() if value is not None}


def _fitted(value: Any, kind: pa.DataType) -> Any:
    try:
        if pa.types.is_string(kind):
            return cleaned(value[:LONGEST_TEXT]) if isinstance(value, str) else None
        if pa.types.is_list(kind):
            return [float(entry) for entry in value]
        if pa.types.is_boolean(kind):
            return value if isinstance(value, bool) else None
        if pa.types.is_integer(kind):
            return value if type(value) is int and abs(value) < 2**63 else None
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return None


def shards(folder: Path, table: str) -> list[Path]:
    """Return the files of a table's rows, in the order of their names."""
    return sorted((folder / "shards").glob(f"{table}-*.jsonl"))


def _parse(shard: Path) -> Iterator[Row]:
    with opened(shard, LARGEST_SHARD) as lines:
        while line := lines.readline(LARGEST_LINE):
            try:
                row = json.loads(line)
            except (ValueError, RecursionError):
                continue  # incomplete
            if isinstance(row, dict) and isinstance(row.get("key"), str):
                yield row


def rows(folder: Path, table: str) -> dict[str, Row]:
    """Read the rows in the table's shards by their keys, with each value in its column's type.

    Errors: ResultsError naming a shard that cannot be read.
    """
    schema, known = arrow_schema(table), {}
    for shard in shards(folder, table):
        for row in _parse(shard):
            if row["key"] not in known:
                known[row["key"]] = fitted(row, schema)
    return known


def find_row(folder: Path, wanted: str, tables: Sequence[str] = tuple(TABLES)) -> tuple[str, Row]:
    """Return the table and the row with the given key, or with the only key that starts with it.

    The table's name may be left out: `3f9c` finds `solve-3f9c...`. Errors: ResultsError if no row or several rows match.
    """
    known = {key: (table, row) for table in tables for key, row in rows(folder, table).items()}
    if wanted in known:
        return known[wanted]
    matches = [key for key in known if key.startswith(wanted) or key.partition("-")[2].startswith(wanted)]
    if not matches:
        raise ResultsError(f"{folder}: no row has the key {wanted!r}; `frictionbench rerun DIR` lists those that failed")
    if len(matches) > 1:
        raise ResultsError(
            f"{folder}: {len(matches)} rows have a key that begins with {wanted!r}: {', '.join(matches[:3])}, ..."
        )
    return known[matches[0]]


def drop(folder: Path, table: str, unwanted: Callable[[Row], bool]) -> None:
    """Delete rows from the table's shards. Errors: OSError naming the shard."""
    for shard in shards(folder, table):
        write_text(shard, "".join(json.dumps(row) + "\n" for row in _parse(shard) if not unwanted(row)))


def write_table(folder: Path, table: str, rows: Sequence[Row]) -> None:
    """Write the rows as DIR/TABLE.parquet, or no file if there are none."""
    if rows:
        with replaced(folder / f"{table}.parquet") as partial:
            pq.write_table(_table(rows, arrow_schema(table)), partial)


def _table(rows: Sequence[Row], schema: pa.Schema) -> pa.Table:
    fit = [fitted(row, schema) for row in rows]
    return pa.table({name: [row.get(name) for row in fit] for name in schema.names}, schema=schema)


def read_table(folder: Path, table: str) -> pd.DataFrame:
    """Read the merged table, or the rows in the shards if the run has not finished.

    Errors: ResultsError naming the file and the column.
    """
    path, schema = folder / f"{table}.parquet", arrow_schema(table)
    if path.exists():
        frame = _merged(path, schema)
    else:
        frame = _table([row for _, row in sorted(rows(folder, table).items())], schema).to_pandas()
    right = {"key": frame["key"].notna(), "tol": frame["tol"].isna() | frame["tol"].between(0, 1, "right")}
    if "dimension" in frame:
        right["dimension"] = frame["dimension"].isna() | frame["dimension"].isin([2, 3])
    for name, fits in right.items():
        if not fits.all():
            raise ResultsError(f"{path}: column {name} holds {frame[name][~fits].iloc[0]}, which no run writes")
    for field in schema:
        if field.metadata[b"unit"] == b"s":  # null for times that no clock shows
            shown = frame[field.name].map(lambda times: times is not None and np.all((times >= 0) & (times <= LONGEST_TIME)))
            frame[field.name] = frame[field.name].where(shown.astype(bool), None)
    return frame


def _merged(path: Path, schema: pa.Schema) -> pd.DataFrame:
    try:
        with opened(path, LARGEST_TABLE) as file:
            found = set(pq.read_schema(file).names)
            file.seek(0)
            texts = [name for name in _texts(schema) if name in found]
            data = _read_parquet(path, pq.ParquetFile(file, read_dictionary=texts), schema)
    except (OSError, pa.ArrowException, ValueError, TypeError, LookupError, OverflowError, MemoryError) as error:
        if isinstance(error, ResultsError):
            raise
        raise ResultsError(f"{path}: not a readable Parquet file ({' '.join(str(error).split())[:300]})") from None
    frame = data.to_pandas(ignore_metadata=True)
    return frame.assign(**{name: frame[name].map(cleaned).astype(frame[name].dtype) for name in _texts(schema)})


def _texts(schema: pa.Schema) -> list[str]:
    return [field.name for field in schema if pa.types.is_string(field.type)]


def _read_parquet(path: Path, file: pq.ParquetFile, schema: pa.Schema) -> pa.Table:
    """Read the table's columns. A small file can decompress to more than the memory holds, so that sizes are checked twice:
    in the metadata before the file is read, and for text columns, read as dictionaries, before they are expanded."""
    facts, columns = file.metadata, file.metadata.schema.to_arrow_schema()
    for field in schema:
        if field.name not in columns.names:
            raise ResultsError(f"{path}: column {field.name} is missing")
        if (kind := columns.field(field.name).type) != field.type:
            raise ResultsError(f"{path}: column {field.name} is {kind}, not {field.type}")
    unpacked = values = 0
    for group in map(facts.row_group, range(facts.num_row_groups)):
        chunks = [group.column(i) for i in range(group.num_columns)]
        unpacked += max(group.total_byte_size, sum(abs(chunk.total_uncompressed_size) for chunk in chunks))
        values += group.num_rows + sum(abs(chunk.num_values) for chunk in chunks)
    if unpacked > LARGEST_TABLE:
        raise ResultsError(f"{path}: decompresses to {unpacked / 2**30:.1f} GiB; the limit is {LARGEST_TABLE / 2**30:g} GiB")
    if max(values, facts.num_rows, 0) > MOST_VALUES:
        raise ResultsError(f"{path}: holds {max(values, facts.num_rows):,} values; the limit is {MOST_VALUES:,}")
    data = file.read(columns=schema.names, use_threads=False)
    expanded = sum(_expanded(chunk) for name in _texts(schema) for chunk in data.column(name).chunks)
    if expanded > LARGEST_TABLE:
        raise ResultsError(f"{path}: its texts take {expanded / 2**30:.1f} GiB; the limit is {LARGEST_TABLE / 2**30:g} GiB")
    return data.select(schema.names).cast(schema)


def _expanded(chunk: pa.Array) -> int:
    """Return the bytes of a column's texts after expansion."""
    if pa.types.is_dictionary(chunk.type):
        chunk = pc.binary_length(chunk.dictionary.cast(pa.large_string())).take(chunk.indices)
        return pc.sum(chunk).as_py() or 0
    return chunk.nbytes


@dataclass
class _Plugin:
    source: str
    solvers: dict[str, Any]


@dataclass
class _Source:
    scene: str
    parameters: dict[str, Any]
    file: str


# The types of the entries that are read from a manifest, and from its settings.
_FACTS: dict[str, Any] = {"machine": dict[str, Any], "options": dict[str, Any], "loaded": dict[str, dict[str, str]]}
_FACTS |= dict.fromkeys(("versions", "solvers", "content"), dict[str, str])
_SETTINGS: dict[str, Any] = {"tolerances": list[float], "plugins": list[_Plugin], "sources": list[_Source]}


def write_manifest(folder: Path, manifest: Row, share: float = 1.0) -> None:
    """Write DIR/manifest.json atomically. Errors: ResultsError if it takes more than this share of the size that is read."""
    text = json.dumps({"schema": SCHEMA_VERSION} | cleaned(manifest), indent=2) + "\n"
    if len(text) > share * LARGEST_MANIFEST:
        raise ResultsError(f"{folder}: its manifest would exceed {LARGEST_MANIFEST >> 20} MiB; run fewer data files at once")
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "manifest.json", text)


def read_manifest(folder: Path) -> Row:
    """Read the manifest of a results folder. Errors: ResultsError if it is not a results folder or the manifest is unusable."""
    path = folder / "manifest.json"
    if not folder.is_dir():
        file = " and no such baseline; compare --accept writes one" if folder.suffix == ".tsv" else ""
        there = sorted(path.parent.name for path in folder.parent.glob("*/manifest.json"))
        alike = [name for name in there if name.startswith(folder.name)] or get_close_matches(folder.name, there)
        mean = f" (did you mean {' or '.join(str(folder.parent / name) for name in alike[:3])}?)" if alike else ""
        raise ResultsError(f"{folder}: no such results folder{file}{mean}")
    try:
        manifest = read_json(path, LARGEST_MANIFEST)
    except FileNotFoundError:
        raise ResultsError(f"{folder}: not a results folder (it has no manifest.json)") from None
    if not isinstance(manifest, dict) or not isinstance(manifest.get("settings"), dict):
        raise ResultsError(f"{path}: not a manifest of frictionbench (it has no settings)")
    if manifest.get("schema") != SCHEMA_VERSION:
        version = manifest.get("schema", 1)
        raise ResultsError(
            f"{folder}: has schema version {version!r}, but this program reads version {SCHEMA_VERSION}; run it again"
        )
    for part, types in ((manifest, _FACTS), (manifest["settings"], _SETTINGS)):
        for name in types.keys() & part.keys():
            parsed(part[name], types[name], f"{path}: {name}")
    return manifest
