"""The data by which runs are compared: a row per cell, read from a results folder or from a baseline.

Columns, indexed by key: table, variant, scene (in the notation of the command line), step, phase, start, tol, verdict, reason,
residual, work (the counters as `name count, ...`), seconds, disturbed, limit.

seconds: the sum of form, setup and solve, or of setup and solve, as the minimum over the repeats in a process. Other load on
the machine can only increase a time, and some of many short repeats are not affected by it. A cell counts as disturbed if it
waited for its core and had few repeats.
"""

import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from frictionbench.problems.verdicts import RANK, Verdict, measured
from frictionbench.results import baseline
from frictionbench.results.commands import sources
from frictionbench.results.conventions import RankBy, json_object, scene_title
from frictionbench.results.files import ResultsError
from frictionbench.results.store import read_manifest, read_table

TEXTS = ("table", "variant", "scene", "step", "phase", "start", "verdict", "reason", "work")
NUMBERS = ("tol", "residual", "seconds", "limit")
FAILURES = ("steps_not_done", "unsolved_problems")  # counters of failures within a simulation or a batch
LARGEST_COUNT = 10**18  # largest number accepted as a count
COUNTS = r"(?:(?:[^,]* )?\d{1,18}(?:, (?:[^,]* )?\d{1,18})*)?"  # texts made by format_counts; RE2, in pandas, has no lookahead
RESIDUAL_ROUNDING = 1.1  # allowance for a baseline's residuals, which have two digits
UNKNOWN = "-"  # in place of a hash: the content could not be read
SHORT_HASH = 12  # characters of a hash in a baseline
FILE_SEPARATOR = "@"  # separates a key and the hash of the problem's file
ENOUGH_REPEATS = 5  # repeats among which there is usually an undisturbed one


@dataclass(frozen=True)
class Cells:
    """The cells of one run, and facts about it.

    sources: the file or installed name of each plug-in, by variant. loaded: the hash or version of what plug-ins loaded, by
    variant and name; places: the paths of these, which a baseline does not contain. finished: whether all cells were run.
    """

    path: Path
    table: pd.DataFrame
    suite: str
    tolerances: tuple[float, ...]
    machine: dict[str, Any] = field(default_factory=dict)
    code: str = ""
    made: str = ""
    sources: dict[str, str] = field(default_factory=dict)
    loaded: dict[str, dict[str, str]] = field(default_factory=dict)
    finished: bool = True
    places: dict[str, dict[str, str]] = field(default_factory=dict)

    @property
    def measured(self) -> pd.DataFrame:
        """The cells that were run."""
        return self.table[measured(self.table)]


def read(path: Path, rank_by: RankBy = RankBy.BODIES) -> Cells:
    """Read the cells of a results folder or a baseline. rank_by: the parts of a time that are compared.

    Errors: ResultsError naming the file and what is wrong with it."""
    cells = _of_baseline(path) if path.is_file() else _of_folder(path, rank_by)
    limits, works = cells.table["limit"].between(0, np.inf, "neither"), cells.table["work"].str.fullmatch(COUNTS)
    for column, known in ("verdict", cells.table["verdict"].isin(RANK)), ("limit", limits), ("work", works):
        for value in cells.table.loc[~known, column].head(1):
            raise ResultsError(f"{path}: unknown {column} {str(value)!r}")
    if cells.table.index.has_duplicates:
        twice = cells.table.index[cells.table.index.duplicated()][0]
        raise ResultsError(f"{path}: duplicate key {twice!r}")
    solved = cells.table[(cells.table["verdict"] == Verdict.SOLVED) & cells.table["table"].isin(["solve", "batch"])]
    for key, row in solved[~(solved["residual"] <= RESIDUAL_ROUNDING * solved["tol"])].head(1).iterrows():
        raise ResultsError(f"{path}: {key}: solved, with a residual of {row['residual']:g} at a tolerance of {row['tol']:g}")
    return cells


def _of_baseline(path: Path) -> Cells:
    facts, rows = baseline.read(path)
    table = _typed(pd.DataFrame(rows, columns=["key", *baseline.COLUMNS]))
    loaded = {
        name.removeprefix(baseline.LOADED): dict(part.rsplit(" ", 1) for part in line.split("; ") if " " in part)
        for name, line in facts.items()
        if name.startswith(baseline.LOADED)
    }
    tolerances = _numbers(facts["tolerances"].split())
    return Cells(path, table, facts["suite"], tolerances, code=facts["code"], made=facts["made"], loaded=loaded)


def _of_folder(folder: Path, rank_by: RankBy) -> Cells:
    manifest = read_manifest(folder)
    settings, content, places = manifest["settings"], manifest.get("content", {}), _places(manifest)
    hashes = {place: digest[:SHORT_HASH] for place, digest in content.items() if digest}
    return Cells(
        folder,
        _typed(_stacked(folder, manifest, rank_by)),
        str(settings.get("suite")),
        _numbers(settings.get("tolerances", ())),
        machine=manifest.get("machine", {}),
        code=manifest.get("versions", {}).get("frictionbench", ""),
        made=str(manifest.get("finished") or manifest.get("started") or ""),
        sources=sources(settings),
        loaded={name: {part: hashes.get(place, UNKNOWN) for part, place in paths.items()} for name, paths in places.items()},
        finished=bool(manifest.get("finished")),
        places=places,
    )


def _stacked(folder: Path, manifest: dict[str, Any], rank_by: RankBy) -> pd.DataFrame:
    """Return the rows of the three tables under the names of this module's columns."""
    solves, simulations, batches = (read_table(folder, table) for table in ("solves", "simulations", "batches"))
    totals = list(map(repeats, *(solves[f"{column}s"] for column in rank_by.columns)))
    few = np.array([len(times) < ENOUGH_REPEATS for times in totals], dtype=bool)
    failed = ((1 - batches["verified"]) * batches["problems"]).round()
    parts = [
        solves.assign(
            table="solve",
            seconds=[times.min(initial=np.inf) for times in totals],
            disturbed=solves["disturbed"].isin([True]) & few,
        ),
        simulations.rename(columns={"worst_residual": "residual", "scheme": "phase"}).assign(
            table="simulation",
            step=None,
            work=[
                _counted(row.work, steps_not_done=row.steps - row.steps_done, unsolved_problems=row.unsolved)
                for row in simulations.itertuples()
            ],
            seconds=simulations["solver_time"],
        ),
        batches.rename(columns={"way": "phase"}).assign(
            table="batch",
            step=None,
            work=[_counted(work, unsolved_problems=n) for work, n in zip(batches["work"], failed, strict=True)],
            seconds=[repeats(times).min(initial=np.inf) for times in batches["times"]],
        ),
    ]
    rows = pd.concat([part for part in parts if len(part)] or parts[:1], ignore_index=True)
    return rows.assign(
        scene=[scene_title(*pair) for pair in zip(rows["scene"], rows["parameters"], strict=True)],
        step=["" if pd.isna(step) else str(int(step)) for step in rows["step"]],
        work=[format_counts(counts(text)) for text in rows["work"]],
        key=_with_files(rows, manifest),
        limit=rows["time_limit"],
    )


def _with_files(rows: pd.DataFrame, manifest: dict[str, Any]) -> list[str]:
    """Return the keys. A problem's file adds its hash, because another file with the same name makes another cell."""
    content, listed = manifest.get("content", {}), manifest["settings"].get("sources", [])
    hashes = {
        (source["scene"], json.dumps(source["parameters"], sort_keys=True)): FILE_SEPARATOR
        + content[source["file"]][:SHORT_HASH]
        for source in listed
        if source["file"] in content
    }
    origins = zip(rows["key"], rows["scene"], rows["parameters"], strict=True)
    return [key + hashes.get((scene, parameters), "") for key, scene, parameters in origins]


def _places(manifest: dict[str, Any]) -> dict[str, dict[str, str]]:
    """Return the paths of what plug-ins loaded, by variant and name. Names that are paths are cut to their shortest unique end,
    which is the same on other machines."""
    places = {}
    for variant, source in sources(manifest["settings"]).items():
        loaded, ends = manifest.get("loaded", {}).get(source, {}), dict[str, list[str]]()
        for name in loaded:
            parts = Path(name).parts
            ends[name] = ["/".join(parts[k:]) for k in reversed(range(len(parts)))] if name.startswith("/") else [name]
        counts = Counter(end for each in ends.values() for end in each)
        unique = {name: next((end for end in ends[name] if counts[end] == 1), name) for name in loaded}
        places[variant] = {unique[name]: place for name, place in loaded.items()}
    return places


def _counted(work: Any, **counters: float) -> str:
    """Add counters, unless they are null, to those in a JSON text."""
    return json.dumps(json_object(work) | {name: int(count) for name, count in counters.items() if pd.notna(count)})


def repeats(*steps: Any) -> np.ndarray:
    """Return the sum over the steps for each repeat, if it is a time, or an empty array if their numbers of repeats differ."""
    times = [np.asarray([] if step is None else step, dtype=float) for step in steps]
    total = sum(times[1:], times[0]) if len({len(one) for one in times}) == 1 else np.empty(0)
    return total[np.isfinite(total) & (total > 0)]


def _typed(rows: pd.DataFrame) -> pd.DataFrame:
    texts = {name: rows[name].fillna("").astype(str) if name in rows else "" for name in TEXTS}
    numbers = {name: pd.to_numeric(rows[name], errors="coerce").astype(float) for name in NUMBERS}
    disturbed = rows["disturbed"].isin([True]) if "disturbed" in rows else False
    table = pd.DataFrame({"key": rows["key"].fillna("").astype(str), **texts, **numbers, "disturbed": disturbed})
    return table.assign(seconds=table["seconds"].where(table["seconds"].between(0, np.inf, "neither"))).set_index("key")


def _numbers(values: Any) -> tuple[float, ...]:
    try:
        return tuple(sorted(float(value) for value in values))
    except (TypeError, ValueError):
        return ()


def counts(text: Any) -> dict[str, int]:
    """Return the counters in a row's JSON. Values other than counts below LARGEST_COUNT are left out, and count as lost."""
    return {name: count for name, count in json_object(text).items() if type(count) is int and 0 <= count < LARGEST_COUNT}


def format_counts(work: dict[str, int]) -> str:
    """Return counters as text, `name count, ...`. The separators of the text are removed from names."""
    return ", ".join(f"{'_'.join(name.replace(',', ' ').split())} {count}" for name, count in sorted(work.items()))


def parse_counts(line: str) -> dict[str, int]:
    """Return the counters in a text made by format_counts."""
    parts = (part.rpartition(" ") for part in line.split(", ") if part)
    return {name: int(count) for name, _, count in parts}


def rounded(value: float, digits: int) -> str:
    """Return a number as text with this many significant digits, empty if it is not finite."""
    return f"{value:.{digits - 1}e}" if np.isfinite(value) else ""
