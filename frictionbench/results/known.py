"""Acknowledged changes for the worse, each with a reason: a comparison reports them and does not fail because of them.

[[known]]
solver = "nsgs"
change = "sweeps"           # verdict, gone, skipped, new (and failing), time, or the name of a work counter
scene = "stack[blocks=5]"   # of a cell; all scenes if left out
after = "unsolved"          # the new verdict; any if left out
ratio = 1.2                 # of a counter or a time: acknowledged up to this ratio; inf also where the counter is gone
reason = "a safer step"
"""

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field
from pydantic.dataclasses import dataclass

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.changes import GONE, NEW, Change, Flip, Growth, Time
from frictionbench.results.compare import Comparison
from frictionbench.results.files import ResultsError, parsed, read_text

F = TypeVar("F", Flip, Growth, Time)
Text = Annotated[str, Field(min_length=1)]
OF_CELLS = ("verdict", GONE, Verdict.SKIPPED, NEW)
LARGEST = 2**20  # bytes


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class Known:
    """One acknowledged change."""

    solver: Text
    change: Text
    reason: Text
    scene: str = ""
    after: str = ""
    ratio: Annotated[float, Field(ge=1)] = 0.0

    def __post_init__(self) -> None:
        if self.change not in OF_CELLS and not self.ratio:
            raise ValueError(f"ratio is missing; give the largest acknowledged ratio of {self.change!r}")

    def is_of(self, found: Change) -> bool:
        if not found.worse or found.variant != self.solver:
            return False
        if isinstance(found, Flip):
            return self.change == found.kind and self.scene in ("", found.scene) and self.after in ("", found.after)
        return self.change == found.name and found.ratio <= self.ratio


def read(path: Path) -> list[Known]:
    """The acknowledged changes of a TOML file. Errors: ResultsError naming the file, the entry and the field."""
    try:
        content = tomllib.loads(read_text(path, LARGEST))
    except FileNotFoundError:
        raise ResultsError(f"{path}: no such file") from None
    except ResultsError:
        raise
    except (ValueError, RecursionError) as error:
        raise ResultsError(f"{path}: cannot be read ({error})") from None
    return parsed(content, _File, path).known


class _File(BaseModel, extra="forbid"):
    known: list[Known]


def acknowledge(comparison: Comparison, known: Sequence[Known]) -> Comparison:
    """The comparison with the reasons of acknowledged changes, and a note for each entry that no longer applies."""
    applied: set[Known] = set()

    def marked(found: F) -> F:
        entry = next((entry for entry in known if entry.is_of(found)), None)
        if entry is None:
            return found
        applied.add(entry)
        return replace(found, known=entry.reason)

    kinds = ("flips", "gone", "added", "work", "times")
    reasons: dict[str, Any] = {kind: tuple(map(marked, getattr(comparison, kind))) for kind in kinds}
    unused = [entry for entry in known if entry not in applied]
    notes = [f"Acknowledged change not found; delete its entry: {one.solver}, {one.change}." for one in unused]
    return replace(comparison, **reasons, notes=(*comparison.notes, *notes))
