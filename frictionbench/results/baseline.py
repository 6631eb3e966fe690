"""A baseline: the results of a run as one sorted text table that a person can review in a diff.

Lines `# name: value` state the suite, the code, what plug-ins loaded (harness.dependencies), the number of cells, and the
SHA-256 of all other lines, by which a truncated or edited table is detected. A header and a line per cell follow, with entries
separated by tabs. Residuals have two digits. Times have one: they only tell whether a slower machine explains a timeout.
"""

from collections.abc import Iterable, Mapping
from hashlib import sha256
from itertools import takewhile
from pathlib import Path

from frictionbench.results.files import ResultsError, cleaned, printable, read_text, write_text
from frictionbench.results.schema import SCHEMA_VERSION

COLUMNS = (
    *("variant", "table", "scene", "step", "phase", "start", "tol"),
    *("verdict", "residual", "work", "seconds", "limit"),
)
FACTS = ("schema", "suite", "tolerances", "code", "made", "cells")
LOADED = "loaded by "  # followed by a plug-in's variant, whose value lists what it loaded as `NAME HASH`
HASH = "sha256"
AGAIN = "delete it and create it again with `frictionbench compare --accept`"
LARGEST_BASELINE = 64 * 2**20  # bytes, a hundred times the baseline of the largest suite


def write(path: Path, facts: Mapping[str, str], rows: Iterable[tuple[str, ...]]) -> None:
    """Write a baseline atomically. facts: FACTS and entries of LOADED. rows: the values of COLUMNS and the key, as text."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = sorted("\t".join(map(printable, row)) for row in rows)
    facts = {"schema": str(SCHEMA_VERSION), **facts, "cells": str(len(lines))}
    names = (*FACTS, *sorted(name for name in facts if name.startswith(LOADED)))
    head = [f"# {name}: {printable(facts[name])}" for name in names]
    body = ["\t".join([*COLUMNS, "key"]), *lines]
    write_text(path, "\n".join([*head, f"# {HASH}: {_hash([*head, *body])}", *body]) + "\n")


def read(path: Path) -> tuple[dict[str, str], list[list[str]]]:
    """Read the facts, and for each cell the key and the values of COLUMNS. Errors: ResultsError naming the file and line."""
    lines = cleaned(read_text(path, LARGEST_BASELINE)).removesuffix("\n").split("\n")
    head = list(takewhile(lambda line: line.startswith("#"), lines))
    facts = {name.strip(): value.strip() for name, _, value in (line[1:].partition(": ") for line in head)}
    table = [(i, line.split("\t")) for i, line in enumerate(lines[len(head) :], len(head) + 1) if line]
    version = facts.get("schema", "1")
    if "suite" in facts and version != str(SCHEMA_VERSION):
        raise ResultsError(f"{path}: has schema version {version}, but this version reads {SCHEMA_VERSION}; {AGAIN}")
    if not table or table[0][1] != [*COLUMNS, "key"] or not facts.keys() >= {*FACTS, HASH}:
        raise ResultsError(f"{path}: neither a baseline, as written by `frictionbench compare --accept`, nor a results folder")
    for i, cells in table[1:]:
        if len(cells) != len(COLUMNS) + 1:
            raise ResultsError(f"{path}:{i}: {len(cells)} columns, expected {len(COLUMNS) + 1}")
    if facts["cells"] != str(len(table) - 1):
        raise ResultsError(f"{path}: has {len(table) - 1} cells, but its head states {facts['cells']}; restore it, or {AGAIN}")
    if facts[HASH] != _hash([line for line in lines if not line.startswith(f"# {HASH}:")]):
        raise ResultsError(f"{path}: was changed after `frictionbench compare --accept` wrote it; restore it, or {AGAIN}")
    return facts, [[cells[-1], *cells[:-1]] for _, cells in table[1:]]


def _hash(lines: list[str]) -> str:
    return sha256("\n".join(lines).encode()).hexdigest()
