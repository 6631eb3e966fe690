"""What polygons in place of the friction cone do to a motion that is known by hand, kept as DIR/polygon.json."""

import json
from pathlib import Path
from typing import NamedTuple

from frictionbench.results.files import ResultsError, write_text

NAME = "polygon.json"


class Deviation(NamedTuple):
    """The largest distances of a ball's path, m, from its parabola and from the path with the cone. facets: 0 for the cone."""

    facets: int
    step: float  # s
    from_parabola: float
    from_cone: float


def write_deviations(folder: Path, found: list[Deviation]) -> None:
    write_text(folder / NAME, json.dumps([row._asdict() for row in found]))


def read_deviations(folder: Path) -> list[Deviation]:
    """As written; none where nothing was. Errors: ResultsError where the file cannot be read."""
    path = folder / NAME
    if not path.exists():
        return []
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        return [
            Deviation(int(row["facets"]), *(float(row[name]) for name in ("step", "from_parabola", "from_cone")))
            for row in told
        ]
    except (OSError, ValueError, TypeError, LookupError, RecursionError, OverflowError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
