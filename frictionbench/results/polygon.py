"""The error that a polygonal friction cone causes in a motion with a known solution, stored in DIR/polygon.json."""

import json
from pathlib import Path
from typing import NamedTuple

from frictionbench.results.files import ResultsError, read_json, write_text

NAME = "polygon.json"


class Deviation(NamedTuple):
    """The largest distances, m, of a sliding ball's path from the exact parabola and from the path computed with the cone.

    facets: of the polygon, 0 for the circular cone. step: time step, s.
    """

    facets: int
    step: float
    from_parabola: float
    from_cone: float


def write_deviations(folder: Path, found: list[Deviation]) -> None:
    write_text(folder / NAME, json.dumps([row._asdict() for row in found]))


def read_deviations(folder: Path) -> list[Deviation]:
    """The deviations; empty if none were written. Errors: ResultsError if the file cannot be read."""
    path = folder / NAME
    if not path.exists():
        return []
    rows = read_json(path)
    try:
        return [
            Deviation(int(row["facets"]), *(float(row[name]) for name in ("step", "from_parabola", "from_cone")))
            for row in rows
        ]
    except (ValueError, TypeError, LookupError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
