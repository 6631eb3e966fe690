"""Failing problems reduced in size, in DIR/shrunk: SOLVER-VERDICT-N-contacts-HASH.npz holds each of them, index.json the result
for each row."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from frictionbench.results.files import ResultsError, read_json, subfolder, write_text

FOLDER, INDEX = "shrunk", "index.json"


class Shrunk(NamedTuple):
    """The reduction of a failing row's problem. file: its name below DIR/shrunk, empty if the failure was not reproduced.

    contacts: of the problem in the file. trials: calls of the solver. whole: no contact can be removed without losing the
    failure; otherwise the reduction ran out of time.
    """

    file: str
    contacts: int
    trials: int
    whole: bool


def write_shrunk(folder: Path, found: Mapping[str, Shrunk]) -> None:
    """Write the reductions, given by the keys of their rows."""
    write_text(subfolder(folder, FOLDER) / INDEX, json.dumps({key: one._asdict() for key, one in found.items()}))


def read_shrunk(folder: Path) -> dict[str, Shrunk]:
    """The reductions by key; empty if none were written. Errors: ResultsError if the file cannot be read."""
    path = folder / FOLDER / INDEX
    if not path.exists():
        return {}
    index = read_json(path)
    try:
        return {
            str(key): Shrunk(str(one["file"]), int(one["contacts"]), int(one["trials"]), bool(one["whole"]))
            for key, one in index.items()
        }
    except (ValueError, TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
