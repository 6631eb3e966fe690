"""Failing cells made small: DIR/shrunk/HASH.npz the problems, DIR/shrunk/index.json what became of each row that was tried."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from frictionbench.results.files import ResultsError, room, write_text

ROOM, INDEX = "shrunk", "index.json"


class Shrunk(NamedTuple):
    """A failing row's problem made small. file: its name below DIR/shrunk, empty where the failure did not come back.

    contacts: of the problem in the file. whole: no contact of it can go; otherwise the time for it was up.
    """

    file: str
    contacts: int
    trials: int
    whole: bool


def write_shrunk(folder: Path, found: Mapping[str, Shrunk]) -> None:
    """found: by the rows' keys."""
    write_text(room(folder, ROOM) / INDEX, json.dumps({key: one._asdict() for key, one in found.items()}))


def read_shrunk(folder: Path) -> dict[str, Shrunk]:
    """As written; none where nothing was. Errors: ResultsError where the file cannot be read."""
    path = folder / ROOM / INDEX
    if not path.exists():
        return {}
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        return {
            str(key): Shrunk(str(one["file"]), int(one["contacts"]), int(one["trials"]), bool(one["whole"]))
            for key, one in told.items()
        }
    except (OSError, ValueError, TypeError, LookupError, AttributeError, RecursionError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
