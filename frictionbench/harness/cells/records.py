"""The list of a source's problems as it is stored. A folder may come from someone else, so that each record is checked."""

import json
import re
from pathlib import Path
from typing import Any

from frictionbench.harness.cells.rows import PROBLEM_FACTS
from frictionbench.results.conventions import COLD, SHUFFLED, WARM
from frictionbench.results.files import ResultsError, read_json

Record = dict[str, Any]  # the facts of a stored problem: PROBLEM_FACTS, its starts and its own terms


def read_records(path: Path) -> list[Record]:
    """The records in a file that collect wrote. Errors: ResultsError naming the file, where it is none or is damaged."""
    records = read_json(path)
    if not isinstance(records, list) or not records or not all(map(_is_record, records)):
        raise ResultsError(f"{path}: not a list of problems")
    return records


def _is_record(given: Any) -> bool:
    if not isinstance(given, dict) or not given.keys() >= {*PROBLEM_FACTS, "starts"}:
        return False
    texts = all(isinstance(given[name], str) for name in ("problem", "scene", "parameters", "phase"))
    starts = given["starts"]
    return (
        texts
        and re.fullmatch("[0-9a-f]{8,64}", given["problem"]) is not None
        and _is_object(given["parameters"])
        and type(given["step"]) is int
        and 0 <= given["step"] < 10**9
        and (given["contacts"] is None or type(given["contacts"]) is int)
        and isinstance(starts, dict)
        and list(starts)[:1] == [COLD]
        and starts.keys() <= {COLD, WARM, SHUFFLED}
        and all(isinstance(digest, str) for digest in starts.values())
    )


def _is_object(text: str) -> bool:
    try:
        return isinstance(json.loads(text), dict)
    except (ValueError, RecursionError):
        return False
