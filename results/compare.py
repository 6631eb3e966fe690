"""Two runs compared, as a gate for CI: verdicts first, deterministic work counters next, times last.

Verdicts and work compare across machines. Times are compared only where both manifests tell of the same machine and the
same settings. Exit codes: 0 nothing worse, 1 a regression, 2 unusable input; a gate must not pass having measured nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from results import changes
from results.changes import Change
from results.schema import TABLES, VERDICTS
from results.store import ResultsError, read_manifest, read_table

ALIKE = ("suite", "tolerances")  # settings that make two runs the same experiment
SELECTION = ("sources", "solvers", "drives", "drive_solvers", "plugins")  # settings that only choose which of its cells are run
LISTED = 20


@dataclass(frozen=True)
class Comparison:
    """What is worse or better in `current` than in `baseline`, or why that cannot be said."""

    baseline: Path
    current: Path
    unusable: str = ""
    cells: int = 0
    changes: tuple[Change, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def worse(self) -> list[Change]:
        return [change for change in self.changes if change.worse]

    @property
    def better(self) -> list[Change]:
        return [change for change in self.changes if not change.worse]

    @property
    def exit_code(self) -> int:
        """0 nothing worse, 1 a regression, 2 unusable input."""
        return 2 if self.unusable else 1 if self.worse else 0

    @property
    def markdown(self) -> str:
        """A headline and a table for each kind of change, to be read in CI."""
        runs = f"{_code(str(self.current))} against {_code(str(self.baseline))}"
        if self.unusable:
            return f"## Not comparable\n\n{runs}: {_code(self.unusable)}\n"
        title = f"Worse: {len(self.worse)}" if self.worse else "Nothing worse"
        parts = [f"## {title} · better: {len(self.better)}", f"{runs}, {self.cells} cells measured in both.", *self.notes]
        for heading, found in (("Worse", self.worse), ("Better", self.better)):
            parts += [_table(f"{heading}: {kind}", list(group)) for kind, group in groupby(found, lambda change: change.kind)]
        return "\n\n".join(parts) + "\n"


def compare(baseline: Path, current: Path) -> Comparison:
    """Compare the run in `current` with the one in `baseline`. Input that cannot be used is told of, not raised."""
    try:
        (old_manifest, old), (new_manifest, new) = _read(baseline), _read(current)
    except ResultsError as error:
        return Comparison(baseline, current, unusable=str(error))
    for name in ALIKE:
        if old_manifest["settings"].get(name) != new_manifest["settings"].get(name):
            return Comparison(baseline, current, unusable=f"the runs differ in their {name}")
    common = changes.measured(old).index.intersection(changes.measured(new).index)
    if common.empty:
        return Comparison(baseline, current, unusable="no cell was measured in both runs")
    before, after = old.loc[common], new.loc[common]
    notes = []
    reason = _unlike(old_manifest, new_manifest)
    clocked = changes.by_the_clock(before, after) & bool(reason)
    found = [*changes.verdicts(before[~clocked], after[~clocked]), *changes.missing(old, new), *changes.work(before, after)]
    if reason:
        notes.append(f"Times are not compared: {reason}.")
        if clocked.any():
            notes.append(f"Nor are timeouts with other verdicts: {clocked.sum()} cells.")
    else:
        same = (before["host"] == after["host"]) & (before["time_limit"] == after["time_limit"])
        found += changes.times(before[same], after[same])
    if added := len(new.index.difference(old.index)):
        notes.append(f"Cells only in the current run: {added}.")
    if dropped := len(changes.measured(old).index.difference(common)) - sum(change.kind == "missing" for change in found):
        notes.append(f"Cells no longer measured because their solver was skipped, with a reason: {dropped}.")
    return Comparison(baseline, current, "", len(common), tuple(found), tuple(notes))


def _read(folder: Path) -> tuple[dict[str, Any], pd.DataFrame]:
    """The manifest, and the cells of both tables by key with the raw repeats of form, setup and solve together."""
    manifest = read_manifest(folder)
    tables = []
    for name in TABLES:
        table = read_table(folder, name)
        table["repeats"] = _repeats(table) if name == "solves" else [np.empty(0)] * len(table)
        table["work"] = table["work"].fillna("") if name == "solves" else ""
        tables.append(table[["key", "variant", "verdict", "reason", "host", "time_limit", "work", "repeats"]])
    cells = pd.concat([table for table in tables if len(table)] or tables[:1], ignore_index=True)
    texts = ["key", "variant", "verdict", "reason", "host"]
    cells[texts] = cells[texts].fillna("")
    if unknown := set(cells["verdict"]) - VERDICTS.keys():
        raise ResultsError(f"{folder}: unknown verdict {min(unknown)!r}")
    if cells["key"].duplicated().any():
        raise ResultsError(f"{folder}: the key {cells['key'][cells['key'].duplicated()].iloc[0]!r} stands in two rows")
    return manifest, cells.set_index("key")


def _repeats(solves: pd.DataFrame) -> list[Any]:
    before = solves["form_time"].fillna(0.0) + solves["setup_time"].fillna(0.0)
    rows = zip(solves["solve_times"], before, strict=True)
    sums = (np.asarray([] if solve is None else solve, dtype=float) + preparation for solve, preparation in rows)
    return [total[np.isfinite(total) & (total > 0)] for total in sums]


def _unlike(old: dict[str, Any], new: dict[str, Any]) -> str:
    """Why times of the two runs do not compare, or nothing."""
    if old.get("machine") != new.get("machine"):
        return "the machines differ"
    names = (old["settings"].keys() | new["settings"].keys()) - set(SELECTION)
    differing = sorted(name for name in names if old["settings"].get(name) != new["settings"].get(name))
    return f"the runs differ in {_code(', '.join(differing))}" if differing else ""


def _table(heading: str, found: Sequence[Change]) -> str:
    keyed = any(change.key for change in found)
    lines = [f"### {heading} ({len(found)})", ""]
    lines += ["| solver | change | cell |", "|---|---|---|"] if keyed else ["| solver | change |", "|---|---|"]
    for change in found[:LISTED]:
        cells = [change.variant, change.what, *([change.key] if keyed else [])]
        lines.append(f"| {' | '.join(map(_code, cells))} |")
    if len(found) > LISTED:
        lines += ["", f"and {len(found) - LISTED} more."]
    return "\n".join(lines)


def _code(text: str) -> str:
    """Text as Markdown code that stays in its cell whatever it holds."""
    return "`" + " ".join(text.split()).replace("`", "'").replace("|", "\\|") + "`"
