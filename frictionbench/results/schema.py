"""The three tables of a run: type, unit and meaning of every column.

    solves        a row per cell: one problem, solver, start and tolerance
    simulations   a row per scene, scheme, solver and way to continue after a failed step, run in closed loop
    batches       a row per batch of small problems, solver, way to solve them all, start and tolerance

Rows are in the order of the run's plan; while the run has not finished they are ordered by key. Lists hold single repeats or
curves. The text columns `parameters` and `work` hold JSON objects. A number that was not measured is null.

columns.txt has a line for each column: its name, its type, its unit and, from the same place in further lines, its meaning;
first those that all tables have, then those of each. docs/columns.md is made from it by tools/columns.py.
"""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.conventions import WAYS

SCHEMA_VERSION = 3  # of files and columns; folders and baselines of another version are refused
TYPES = {"text": pa.string(), "real": pa.float64(), "whole": pa.int64(), "flag": pa.bool_(), "reals": pa.list_(pa.float64())}


class Column(NamedTuple):
    """One column of a table. unit: SI, "1" for a ratio, empty for what has no unit."""

    name: str
    type: pa.DataType
    unit: str
    meaning: str


def cut(text: str, *places: int) -> Iterator[list[str]]:
    """The lines of a table of text as their entries, which begin at the places; an indented line continues one."""
    for line in re.sub(r"\n +", " ", text.strip()).splitlines():
        yield [line[start:end].strip() for start, end in pairwise((0, *places, None))]


def _tables() -> dict[str, tuple[Column, ...]]:
    text = Path(__file__).with_name("columns.txt").read_text(encoding="utf-8")
    text = text.replace("@VERDICTS", "; ".join(f"{each}: {each.meaning}" for each in Verdict))
    text = text.replace("@WAYS", "; ".join(f"{way}: {means}" for way, means in WAYS.items()))
    common, *own = (
        tuple(Column(name, TYPES[kind], unit, meaning) for name, kind, unit, meaning in cut(part, 19, 25, 29))
        for part in text.split("---\n")
    )
    return {table: common + each for table, each in zip(("solves", "simulations", "batches"), own, strict=True)}


TABLES = _tables()
SOLVES = TABLES["solves"]


def arrow_schema(table: str) -> pa.Schema:
    """The Arrow schema of a table, units and meanings as field metadata."""
    columns = TABLES[table]
    return pa.schema([pa.field(c.name, c.type, metadata={"unit": c.unit, "meaning": c.meaning}) for c in columns])
