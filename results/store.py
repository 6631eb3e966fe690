"""The results folder of a run.

    DIR/manifest.json             what was run, where, with which versions and settings
    DIR/convergence.json              how solvers get to their answers on a few problems, see results.convergence
    DIR/problems/HASH.npz         the problems, so that any cell can be rerun
    DIR/shards/TABLE-*.jsonl      rows as they came, one file a writer, appended and flushed row by row
    DIR/solves.parquet, simulations.parquet    the shards merged

A shard may end in a torn line (a kill in mid-write): it is dropped, and the cell runs again; so is a line that is no row. A
cell that was written twice counts once, the first row standing. What is read is checked against results.schema; nothing is
ever unpickled, and nothing is read that says of itself that it is larger than LARGEST.
"""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, Self

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from frictionbench.results import files
from frictionbench.results.files import replaced, room, write_text
from frictionbench.results.schema import VERSION, arrow_schema

Row = dict[str, Any]
ResultsError = files.ResultsError
LARGEST_LINE = 64 * 2**20  # bytes; a longer line is not a row of ours
LARGEST_TABLE = 2**30  # bytes unpacked; a larger table is refused unread
MOST_VALUES = 2 * 10**7  # of a table's columns together
LARGEST_MANIFEST = 8 * 2**20  # bytes
LONGEST_TEXT = 20_000  # characters in a column; longer ones are cut
BATCH = 500  # rows in memory at a time


class ShardWriter:
    """Appends rows of one table to a shard of its own, each flushed to the disk's cache before the call returns."""

    def __init__(self, folder: Path, table: str, writer: str) -> None:
        self._schema = arrow_schema(table)
        self._path = room(folder, "shards") / f"{table}-{writer}.jsonl"
        self._file: BinaryIO = open(self._path, "ab", buffering=0, opener=_not_through_links)  # noqa: SIM115
        if self._file.tell():
            self._file.write(b"\n")  # ends a line that an earlier writer of this shard may have left torn

    def write(self, row: Row) -> None:
        """What a column cannot hold is left out; texts are cut. Errors: OSError naming the shard."""
        line = json.dumps(fitted(row, self._schema)).encode() + b"\n"
        try:
            if self._file.write(line) != len(line):
                raise OSError(28, "No space left on device")
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self._path)) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _not_through_links(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NOFOLLOW, 0o666)


def fitted(row: Row, schema: pa.Schema) -> Row:
    """The part of a row that its table can hold, each value of its column's type."""
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


class _Place(NamedTuple):
    """Where a row begins."""

    shard: Path
    offset: int


def _places(folder: Path, table: str) -> dict[str, _Place]:
    """Where the row of each key stands, the first of each, in a reproducible order."""
    places: dict[str, _Place] = {}
    for shard in sorted((folder / "shards").glob(f"{table}-*.jsonl")):
        for offset, row in _parse(shard):
            places.setdefault(row["key"], _Place(shard, offset))
    return places


def _parse(shard: Path) -> Iterator[tuple[int, Row]]:
    with open(shard, "rb") as lines:
        offset = 0
        while line := lines.readline(LARGEST_LINE):
            if (row := _row(line)) is not None:
                yield offset, row
            offset += len(line)


def _row(line: bytes) -> Row | None:
    try:
        row = json.loads(line)
    except (ValueError, RecursionError):
        return None  # torn
    return row if isinstance(row, dict) and isinstance(row.get("key"), str) else None


def _rows(places: Sequence[_Place]) -> Iterator[Row]:
    for place in places:
        with open(place.shard, "rb") as lines:
            lines.seek(place.offset)
            row = _row(lines.readline(LARGEST_LINE))
        if row is not None:
            yield row


def rows(folder: Path, table: str) -> Iterator[Row]:
    """All rows of the table's shards, each value of its column's type."""
    schema = arrow_schema(table)
    return (fitted(row, schema) for row in _rows(list(_places(folder, table).values())))


def kept(folder: Path, table: str) -> set[str]:
    """The keys of all rows in the table's shards."""
    return set(_places(folder, table))


def find_row(folder: Path, given: str, tables: Sequence[str] = ("solves", "simulations")) -> tuple[str, Row]:
    """The table and the row of a key, or of what only one key begins with, each value of its column's type.

    The shorter `3f9c` stands for `solve-3f9c...` too. Errors: ResultsError where no row has such a key, or several have.
    """
    places = {(table, key): place for table in tables for key, place in _places(folder, table).items()}
    exact = [(table, key) for table, key in places if key == given]
    found = exact or [one for one in places if one[1].startswith(given) or one[1].partition("-")[2].startswith(given)]
    if not found or not given:
        raise ResultsError(f"{folder}: no row has the key {given!r}")
    if len(found) > 1:
        listed = ", ".join(key for _, key in found[:3])
        raise ResultsError(f"{folder}: {len(found)} rows have a key that begins with {given!r}: {listed}, ...")
    table, key = found[0]
    (row,) = _rows([places[table, key]])
    return table, fitted(row, arrow_schema(table))


def drop(folder: Path, table: str, unwanted: Callable[[Row], bool]) -> int:
    """Take rows out of the table's shards, and what is no row with them; how many rows. Errors: OSError naming the shard."""
    dropped = 0
    for shard in (folder / "shards").glob(f"{table}-*.jsonl"):
        found = [row for _, row in _parse(shard)]
        kept = [row for row in found if not unwanted(row)]
        if len(kept) < len(found):
            write_text(shard, "".join(json.dumps(row) + "\n" for row in kept))
        dropped += len(found) - len(kept)
    return dropped


def merge(folder: Path, table: str, order: Sequence[str], lost: Callable[[str], Row]) -> int:
    """Write DIR/TABLE.parquet from the shards, the row of every key of the plan in its order; how many of these have none.

    lost: the row that stands for one that is not there. A row that is not planned (of a source that yielded nothing, until it
    was tried again) stays out. No table is written where there are no rows.
    """
    schema, places = arrow_schema(table), _places(folder, table)
    missing = 0
    if order:
        with replaced(folder / f"{table}.parquet") as partial, pq.ParquetWriter(partial, schema) as writer:
            for start in range(0, len(order), BATCH):
                batch = []
                for key in order[start : start + BATCH]:
                    found = next(_rows([places[key]]), None) if key in places else None
                    missing += found is None
                    batch.append(lost(key) if found is None else found)
                writer.write_table(_table(batch, schema))
    return missing


def _table(found: Sequence[Row], schema: pa.Schema) -> pa.Table:
    fit = [fitted(row, schema) for row in found]
    return pa.table({name: [row.get(name) for row in fit] for name in schema.names}, schema=schema)


def read_table(folder: Path, table: str) -> pd.DataFrame:
    """A merged table, or the shards of a run that was broken off. Errors: ResultsError naming the file and the column."""
    path = folder / f"{table}.parquet"
    schema = arrow_schema(table)
    if not path.exists():
        places = _places(folder, table)
        return _table(list(_rows([places[key] for key in sorted(places)])), schema).to_pandas()
    try:
        data = _read_parquet(path, schema)
    except (OSError, pa.ArrowException, ValueError, TypeError, LookupError, OverflowError, MemoryError) as error:
        if isinstance(error, ResultsError):
            raise
        raise ResultsError(f"{path}: not a readable Parquet file ({' '.join(str(error).split())[:300]})") from None
    return data.to_pandas(ignore_metadata=True)


def _read_parquet(path: Path, schema: pa.Schema) -> pa.Table:
    """The table's columns. A small file can say that it holds more than memory does: its metadata are looked at first, and
    texts are read as a dictionary, which holds each once, and measured before they are spread out."""
    facts, columns = pq.read_metadata(path), pq.read_schema(path)
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
        raise ResultsError(f"{path}: unpacks to {unpacked / 2**30:.1f} GiB, more than {LARGEST_TABLE / 2**30:g}")
    if max(values, facts.num_rows, 0) > MOST_VALUES:
        raise ResultsError(f"{path}: holds {max(values, facts.num_rows):,} values, more than {MOST_VALUES:,}")
    texts = [field.name for field in schema if pa.types.is_string(field.type)]
    data = pq.ParquetFile(path, read_dictionary=texts).read(columns=schema.names, use_threads=False)
    spread = sum(_spread(chunk) for name in texts for chunk in data.column(name).chunks)
    if spread > LARGEST_TABLE:
        raise ResultsError(f"{path}: its texts take {spread / 2**30:.1f} GiB, more than {LARGEST_TABLE / 2**30:g}")
    return data.select(schema.names).cast(schema)


def _spread(chunk: pa.Array) -> int:
    """The bytes of a column's texts, each as often as it occurs."""
    if pa.types.is_dictionary(chunk.type):
        chunk = pc.binary_length(chunk.dictionary.cast(pa.large_string())).take(chunk.indices)
        return pc.sum(chunk).as_py() or 0
    return chunk.nbytes


def write_manifest(folder: Path, manifest: Row) -> None:
    """Write DIR/manifest.json whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "manifest.json", json.dumps({"schema": VERSION} | manifest, indent=2) + "\n")


def read_manifest(folder: Path) -> Row:
    """DIR/manifest.json. Errors: ResultsError where DIR is no results folder or its manifest cannot be read."""
    path = folder / "manifest.json"
    if not folder.is_dir():
        raise ResultsError(f"{folder}: no such results folder")
    try:
        if path.stat().st_size > LARGEST_MANIFEST:
            raise ResultsError(f"{path}: larger than {LARGEST_MANIFEST / 2**20:g} MiB")
        text = path.read_text(encoding="utf-8")
        manifest = json.loads(text)
        json.dumps(manifest, ensure_ascii=False).encode()  # half a surrogate is no text
    except FileNotFoundError:
        raise ResultsError(f"{folder}: not a results folder (it has no manifest.json)") from None
    except ResultsError:
        raise
    except RecursionError:
        raise ResultsError(f"{path}: cannot be read (nested too deeply)") from None
    except (OSError, ValueError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
    if not isinstance(manifest, dict) or not isinstance(manifest.get("settings"), dict):
        raise ResultsError(f"{path}: not a manifest of ours (no settings)")
    if manifest.get("schema") != VERSION:
        raise ResultsError(f"{folder}: of schema {manifest.get('schema', 1)!r}, this version reads {VERSION}; run it again")
    return manifest
