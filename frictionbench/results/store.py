"""The results folder of a run.

    DIR/manifest.json             what was run, on which machine, with which versions and settings
    DIR/convergence.json          convergence histories on a few problems, see results.extras
    DIR/maps/NAME.json            thresholds on the maps, see results.maps
    DIR/motion/NAME.json          recorded motions, see results.motion; NAME.html animates one
    DIR/problems/HASH.npz         the problems, so that any cell can be rerun
    DIR/shards/TABLE-*.jsonl      rows in order of arrival, one file per writer, appended and flushed row by row
    DIR/solves.parquet, simulations.parquet    the merged shards
    DIR/shrunk/                   failing problems reduced in size, see results.extras
    DIR/report.html, failures.txt, report.md, paper/    made from the files above, see reports

A shard may end in an incomplete line, if its writer was killed. Such a line, and any other that is not a row, is ignored, and
its cell runs again. Of several rows with the same key the first counts. The tables are merged from what the shards held when
the run began and from what its main process wrote since: shards and lines that another process adds meanwhile do not count,
and a shard that was changed is refused. All input is checked against results.schema; nothing is unpickled, and files that
declare more than the limits below are refused before they are read.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Self

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from frictionbench.results.files import ResultsError, opened, read_json, replaced, subfolder, write_text
from frictionbench.results.schema import SCHEMA_VERSION, arrow_schema

Row = dict[str, Any]
# Limits on input: far above what the largest suite writes, and small enough for a machine with 4 GiB of memory.
LARGEST_LINE = 64 * 2**20  # bytes; a longer line is not a row of a run
LARGEST_SHARD = 2**31  # bytes
LARGEST_TABLE = 2**30  # bytes after decompression
MOST_VALUES = 2 * 10**7  # values in all columns of a table together
LARGEST_MANIFEST = 8 * 2**20  # bytes
LONGEST_TEXT = 20_000  # characters of a text value; a longer text, such as an exception that prints an array, is cut
BATCH = 500  # rows in memory at a time while shards are merged


class Extent(NamedTuple):
    """The beginning of a shard that counts: its size in bytes and its SHA-256."""

    size: int
    digest: str


class ShardWriter:
    """Appends rows of one table to a new shard. Each row is handed to the operating system before `write` returns."""

    def __init__(self, folder: Path, table: str, writer: str) -> None:
        self._schema = arrow_schema(table)
        self.path = subfolder(folder, "shards") / f"{table}-{writer}.jsonl"
        self._file: BinaryIO = open(self.path, "ab", buffering=0, opener=_new)  # noqa: SIM115
        self._size, self._digest = 0, hashlib.sha256()

    @property
    def extent(self) -> Extent:
        """What it has written."""
        return Extent(self._size, self._digest.hexdigest())

    def write(self, row: Row) -> None:
        """Write the part of a row that the table can hold, see `fitted`. Errors: OSError naming the shard."""
        line = json.dumps(fitted(row, self._schema)).encode() + b"\n"
        try:
            if self._file.write(line) != len(line):
                raise OSError(28, "No space left on device")
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from None
        self._size += len(line)
        self._digest.update(line)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        if not self._size:
            self.path.unlink(missing_ok=True)


def _new(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_EXCL | os.O_NOFOLLOW, 0o666)


def extents(folder: Path, table: str) -> dict[Path, Extent]:
    """The table's shards as they are now. Errors: OSError naming the shard."""
    return {path: _extent(path, path.stat().st_size) for path in (folder / "shards").glob(f"{table}-*.jsonl")}


def _extent(path: Path, size: int) -> Extent:
    """The beginning of a shard, of so many bytes or as many as it has."""
    digest, left = hashlib.sha256(), size
    with open(path, "rb") as shard:
        while left and (part := shard.read(min(left, 2**20))):
            digest.update(part)
            left -= len(part)
    return Extent(size - left, digest.hexdigest())


def fitted(row: Row, schema: pa.Schema) -> Row:
    """The row with each value in its column's type. Values that a column cannot hold are left out, long texts are cut."""
    fit = {field.name: _fitted(row.get(field.name), field.type) for field in schema}
    return {name: value for name, value in fit.items() if value is not None}


def _fitted(value: Any, kind: pa.DataType) -> Any:
    try:
        if value is None:
            return None
        if pa.types.is_string(kind):
            return value[:LONGEST_TEXT].encode("utf-8", "replace").decode() if isinstance(value, str) else None
        if pa.types.is_list(kind):
            return [float(entry) for entry in value]
        if pa.types.is_boolean(kind):
            return value if isinstance(value, bool) else None
        if pa.types.is_integer(kind):
            return value if type(value) is int and abs(value) < 2**63 else None
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return None


class _Position(NamedTuple):
    """The position of a row: its shard, and the offset of its line in bytes."""

    shard: Path
    offset: int


def _positions(folder: Path, table: str, counted: Mapping[Path, Extent] | None = None) -> dict[str, _Position]:
    """The position of the first row with each key, in a reproducible order; of what is counted alone, if it is given.

    Errors: ResultsError naming a shard whose counted beginning was changed.
    """
    positions: dict[str, _Position] = {}
    for shard in sorted((folder / "shards").glob(f"{table}-*.jsonl") if counted is None else counted):
        if counted is not None and (not shard.exists() or _extent(shard, counted[shard].size) != counted[shard]):
            raise ResultsError(
                f"{shard}: was changed during the run by another process; delete it, and run the same command again"
            )
        for offset, row in _parse(shard):
            if counted is None or offset < counted[shard].size:
                positions.setdefault(row["key"], _Position(shard, offset))
    return positions


def _parse(shard: Path) -> Iterator[tuple[int, Row]]:
    with opened(shard, LARGEST_SHARD) as lines:
        offset = 0
        while line := lines.readline(LARGEST_LINE):
            if (row := _row(line)) is not None:
                yield offset, row
            offset += len(line)


def _row(line: bytes) -> Row | None:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        return None  # incomplete
    return row if isinstance(row, dict) and isinstance(row.get("key"), str) else None


def _rows(positions: Sequence[_Position]) -> Iterator[Row]:
    for position in positions:
        with opened(position.shard, LARGEST_SHARD) as lines:
            lines.seek(position.offset)
            row = _row(lines.readline(LARGEST_LINE))
        if row is not None:
            yield row


def rows(folder: Path, table: str) -> Iterator[Row]:
    """All rows of the table's shards, each value in its column's type."""
    schema = arrow_schema(table)
    return (fitted(row, schema) for row in _rows(list(_positions(folder, table).values())))


def stored_keys(folder: Path, table: str, counted: Mapping[Path, Extent] | None = None) -> set[str]:
    """The keys of all rows in the table's shards, or in what is counted of them. Errors: ResultsError as of merge."""
    return set(_positions(folder, table, counted))


def find_row(folder: Path, given: str, tables: Sequence[str] = ("solves", "simulations")) -> tuple[str, Row]:
    """The table and the row with the given key, or with the only key that starts with it.

    The table's name may be left out: `3f9c` finds `solve-3f9c...`. Errors: ResultsError if no row or several rows match.
    """
    positions = {(table, key): position for table in tables for key, position in _positions(folder, table).items()}
    exact = [(table, key) for table, key in positions if key == given]
    found = exact or [one for one in positions if one[1].startswith(given) or one[1].partition("-")[2].startswith(given)]
    if not found or not given:
        raise ResultsError(f"{folder}: no row has the key {given!r}; the report lists the keys, and so does the column `key`")
    if len(found) > 1:
        listed = ", ".join(key for _, key in found[:3])
        raise ResultsError(f"{folder}: {len(found)} rows have a key that begins with {given!r}: {listed}, ...")
    table, key = found[0]
    (row,) = _rows([positions[table, key]])
    return table, fitted(row, arrow_schema(table))


def drop(folder: Path, table: str, unwanted: Callable[[Row], bool]) -> int:
    """Delete rows from the table's shards; return their number. Errors: OSError naming the shard."""
    dropped = 0
    for shard in (folder / "shards").glob(f"{table}-*.jsonl"):
        found = [row for _, row in _parse(shard)]
        remaining = [row for row in found if not unwanted(row)]
        if len(remaining) < len(found):
            write_text(shard, "".join(json.dumps(row) + "\n" for row in remaining))
        dropped += len(found) - len(remaining)
    return dropped


def merge(
    folder: Path,
    table: str,
    order: Sequence[str],
    placeholder: Callable[[str], Row],
    counted: Mapping[Path, Extent] | None = None,
) -> int:
    """Write DIR/TABLE.parquet with the rows of all keys in `order`; return how many keys have no row in the shards.

    placeholder: makes the row of a key that has none. Rows with other keys are left out, such as the row that reports a failed
    source once a later attempt succeeded. No file is written where `order` is empty. counted: what counts of the shards, by
    default all that they hold. Errors: ResultsError naming a shard whose counted beginning was changed.
    """
    schema, positions = arrow_schema(table), _positions(folder, table, counted)
    missing = 0
    if order:
        with replaced(folder / f"{table}.parquet") as partial, pq.ParquetWriter(partial, schema) as writer:
            for start in range(0, len(order), BATCH):
                batch = []
                for key in order[start : start + BATCH]:
                    found = next(_rows([positions[key]]), None) if key in positions else None
                    missing += found is None
                    batch.append(placeholder(key) if found is None else found)
                writer.write_table(_table(batch, schema))
    return missing


def _table(found: Sequence[Row], schema: pa.Schema) -> pa.Table:
    fit = [fitted(row, schema) for row in found]
    return pa.table({name: [row.get(name) for row in fit] for name in schema.names}, schema=schema)


def read_table(folder: Path, table: str) -> pd.DataFrame:
    """The merged table, or the rows in the shards if the run has not finished.

    Errors: ResultsError naming the file and the column.
    """
    path = folder / f"{table}.parquet"
    schema = arrow_schema(table)
    if not path.exists():
        positions = _positions(folder, table)
        return _table(list(_rows([positions[key] for key in sorted(positions)])), schema).to_pandas()
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
    return data.to_pandas(ignore_metadata=True)


def _texts(schema: pa.Schema) -> list[str]:
    return [field.name for field in schema if pa.types.is_string(field.type)]


def _read_parquet(path: Path, file: pq.ParquetFile, schema: pa.Schema) -> pa.Table:
    """The table's columns. A small file can decompress to more than the memory holds, so sizes are checked twice: in the
    metadata before the file is read, and of text columns, read as dictionaries, before they are expanded."""
    facts, columns = file.metadata, file.metadata.schema.to_arrow_schema()
    for field in schema:
        if field.name not in columns.names:
            raise ResultsError(f"{path}: column {field.name} is missing")
        if (found := columns.field(field.name).type) != field.type:
            raise ResultsError(f"{path}: column {field.name} is {found}, not {field.type}")
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
    """The bytes of a column's texts, each counted as often as it occurs."""
    if pa.types.is_dictionary(chunk.type):
        chunk = pc.binary_length(chunk.dictionary.cast(pa.large_string())).take(chunk.indices)
        return pc.sum(chunk).as_py() or 0
    return chunk.nbytes


def write_manifest(folder: Path, manifest: Row) -> None:
    """Write DIR/manifest.json atomically."""
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "manifest.json", json.dumps({"schema": SCHEMA_VERSION} | manifest, indent=2) + "\n")


def read_manifest(folder: Path) -> Row:
    """The manifest of a results folder. Errors: ResultsError if DIR is not a results folder or the manifest is unusable."""
    path = folder / "manifest.json"
    if not folder.is_dir():
        raise ResultsError(f"{folder}: no such results folder")
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
    for name in ("machine", "versions", "solvers"):
        if not isinstance(manifest.get(name, {}), dict):
            raise ResultsError(f"{path}: {name} is no object")
    return manifest
