"""Summaries of runs as they are published: one JSON file a run, text of some ten kilobytes.

    format       1
    name         SUITE-VERSION-MACHINE-DATE, the name of the file
    suite, version, release, finished, cells, workers
    machine      processor, cores, memory, system, python; without the name of the host
    settings     tolerances and time limit, s
    libraries    the versions of the libraries that the solvers used
    problems     ranked, trivial and idle: their numbers; hashes: of each problem, by scene and step, of a map's together
    checks       [what, whether it holds, in words]
    headline     sentences
    rankings     rows: kind, by, target, solver, law, mean, p50, p99, worst (s; null is never), reached, problems;
                 unclear: why none of the kind is the winner, or ""
    reliability  rows: solver, model, problems, exact, own, near_miss, wrong, timeout, crashed
    scenes       rows: scene, solver, solved, cells, at the tightest tolerance; "map NAME": of grid points with a known solution

Summaries may come from anybody: what does not have these fields and types is refused, and pages escape all text.
"""

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from frictionbench.results.files import ResultsError, read_json, write_text

FORMAT = 1
LARGEST = 4 * 2**20  # bytes of a summary
Summary = dict[str, Any]
TEXTS = ("name", "suite", "version", "release", "finished")
TYPES: dict[str, type | tuple[type, ...]] = {
    **dict.fromkeys(TEXTS, str),
    **dict.fromkeys(("cells", "workers"), int),
    **dict.fromkeys(("machine", "settings", "libraries", "problems"), dict),
    **dict.fromkeys(("checks", "headline", "rankings", "reliability", "scenes"), list),
}
NUMBER = (int, float, type(None))
ROWS: dict[str, dict[str, Any]] = {
    "rankings": {
        **dict.fromkeys(("kind", "by", "solver", "law", "unclear"), str),
        **dict.fromkeys(("target", "mean", "p50", "p99", "worst"), NUMBER),
        **dict.fromkeys(("reached", "problems"), int),
    },
    "reliability": {
        **dict.fromkeys(("solver", "model"), str),
        **dict.fromkeys(("problems", "exact", "own", "near_miss", "wrong", "timeout", "crashed"), int),
    },
    "scenes": {**dict.fromkeys(("scene", "solver"), str), **dict.fromkeys(("solved", "cells"), int)},
}


def write(summary: Summary, folder: Path) -> Path:
    """Write FOLDER/NAME.json, a row of a table on a line, so that a change is one line of a diff; return its path."""
    parts = []
    for key, value in ({"format": FORMAT} | summary).items():
        if isinstance(value, list):
            rows = ",\n".join("  " + json.dumps(row, ensure_ascii=False, allow_nan=False) for row in value)
            parts.append(f'"{key}": [\n{rows}\n]' if value else f'"{key}": []')
        else:
            parts.append(f'"{key}": {json.dumps(value, ensure_ascii=False, allow_nan=False)}')
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{summary['name']}.json"
    write_text(path, "{\n" + ",\n".join(parts) + "\n}\n")
    return path


def read(path: Path) -> Summary:
    """The summary in a file. Errors: ResultsError naming the file and the field that is missing or of another type."""
    found = read_json(path, LARGEST)
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise ResultsError(f"{path}: not a published summary of format {FORMAT}")
    for field, kind in TYPES.items():
        if not isinstance(found.get(field), kind):
            raise ResultsError(f"{path}: {field} is missing or of another type")
    if not re.fullmatch(r"[\w.+-]+", found["name"]) or found["name"].startswith("."):
        raise ResultsError(f"{path}: name is no name of a file")
    for table, columns in ROWS.items():
        _require_rows(path, table, found[table], columns)
    if not all(isinstance(line, str) for line in found["headline"]):
        raise ResultsError(f"{path}: headline holds what is no text")
    if not all(isinstance(one, list) and list(map(type, one)) == [str, bool, str] for one in found["checks"]):
        raise ResultsError(f"{path}: checks are not [what, whether it holds, in words]")
    if not isinstance(found["problems"].get("hashes"), dict):
        raise ResultsError(f"{path}: problems.hashes is missing or of another type")
    return found


def _require_rows(path: Path, table: str, rows: Iterable[Any], columns: dict[str, Any]) -> None:
    for row in rows:
        if not isinstance(row, dict):
            raise ResultsError(f"{path}: {table} holds what is no row")
        for column, kind in columns.items():
            if not isinstance(row.get(column), kind):
                raise ResultsError(f"{path}: {table}.{column} is missing or of another type")
