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
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from frictionbench.problems.verdicts import Verdict
from frictionbench.results.changes import GONE, NEW, Change, Flip, Growth, Time
from frictionbench.results.compare import Comparison
from frictionbench.results.files import ResultsError, read_text

F = TypeVar("F", Flip, Growth, Time)
OF_CELLS = ("verdict", GONE, Verdict.SKIPPED, NEW)
LARGEST = 2**20  # bytes


@dataclass(frozen=True)
class Known:
    """One acknowledged change."""

    solver: str
    change: str
    reason: str
    scene: str = ""
    after: str = ""
    ratio: int | float = 0.0

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
    entries = content.get("known")
    if content.keys() - {"known"} or not isinstance(entries, list):
        raise ResultsError(f"{path}: must contain only [[known]] tables")
    return [_entry(path, i, entry) for i, entry in enumerate(entries, 1)]


def _entry(path: Path, number: int, entry: Any) -> Known:
    where = f"{path}: known {number}"
    if not isinstance(entry, dict):
        raise ResultsError(f"{where}: not a table")
    fields = get_type_hints(Known)
    for name, value in entry.items():
        if name not in fields:
            raise ResultsError(f"{where}: unknown field {name!r}; the fields are {', '.join(fields)}")
        if not isinstance(value, fields[name]) or isinstance(value, bool):
            raise ResultsError(f"{where}: {name} cannot be {value!r}")
    for name in ("solver", "change", "reason"):
        if not entry.get(name):
            raise ResultsError(f"{where}: {name} is missing")
    if entry["change"] not in OF_CELLS and not entry.get("ratio"):
        raise ResultsError(f"{where}: ratio is missing; give the largest acknowledged ratio of {entry['change']!r}")
    if "ratio" in entry and not entry["ratio"] >= 1:
        raise ResultsError(f"{where}: ratio cannot be {entry['ratio']!r}; it is the largest acknowledged one, at least 1")
    return Known(**entry)


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
