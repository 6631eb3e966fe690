"""Published summaries of runs: one JSON file per run, a text of 50 to 700 kilobytes for a suite.

    format       1
    name         SUITE-VERSION-MACHINE-DATE, the name of the file
    suite, version, release, finished, cells, workers
    machine      processor, cores, memory, system, python; without the name of the host
    settings     tolerances and time limit, s
    libraries    the versions of the libraries that the solvers used
    problems     ranked, trivial and idle: their numbers; hashes: of each problem, by scene and step; one hash for each map
    checks       [name, whether it holds, explanation]
    headline     sentences on the kinds of problems of the first screen; classes: on the others, in runs since 26 November 2026
    rankings     rows: kind, by, target, solver, law, mean, p50, p99, worst (s; null means never), reached, problems;
                 unclear: why no solver of the kind is the winner, or ""
    reliability  rows: solver, model, problems, exact, own, near_miss, wrong, timeout, crashed
    scenes       rows: scene, solver, solved, cells, at the tightest tolerance; "map NAME": on grid points with a known solution

Summaries may come from anybody. Those without these fields and types are refused, and pages escape all text.
"""

import json
import re
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
from pydantic import AfterValidator, Field, ValidationError, conlist, create_model

import frictionbench as fb
from frictionbench.problems import measured
from frictionbench.reports import choice, robustness, tables
from frictionbench.reports.choice import Kind
from frictionbench.reports.robustness import MapCells
from frictionbench.reports.run import Run
from frictionbench.results.conventions import RankBy, scene_title
from frictionbench.results.files import ResultsError, read_json, write_text

FORMAT = 1
LARGEST_SUMMARY = 4 * 2**20  # bytes of a summary
Summary = dict[str, Any]
MACHINE = ("processor", "cores", "memory", "system", "python")
TIME_DIGITS = 6  # significant digits of times: pages show three, which rounding to four before could change
SHORT = 12  # characters of a problem's hash: enough to distinguish thousands of problems


def page_of(name: str) -> str:
    """Return the part of a run's name that consists of suite and version."""
    return name.rsplit("-", 2)[0]


def _named(name: str) -> str:
    """Return the name if it is valid for a file, and for a folder and a page that replace no other page. Errors: ValueError."""
    taken = page_of(name).casefold() == "index" or name.casefold().endswith(".html")
    if taken or not re.fullmatch(r"[\w+-][\w.+-]{0,200}", name):
        raise ValueError("names no page")
    return name


def _fields(**kinds: Any) -> Any:
    """Return the type of an object that has these fields, and possibly others."""
    required: dict[str, Any] = {name: (kind, ...) for name, kind in kinds.items()}
    return create_model("Fields", **required)


Whole = Annotated[int, Field(ge=0, lt=2**63)]
Number = Annotated[float, Field(ge=0, lt=1e300)]
# The type of each field.
FIELDS: dict[str, Any] = {
    "name": Annotated[str, AfterValidator(_named)],
    **dict.fromkeys(("suite", "version", "release", "finished"), str),
    **dict.fromkeys(("cells", "workers"), Whole),
    "libraries": dict[str, str],
    "headline": list[str],
    "checks": list[tuple[str, bool, str]],
    "machine": _fields(**dict.fromkeys(("processor", "system", "python"), str | None), cores=Whole, memory=Number | None),
    "settings": _fields(time_limit=Number | None, tolerances=list[Number]),
    "problems": _fields(**dict.fromkeys(("ranked", "trivial", "idle"), Whole), hashes=dict[str, str]),
    "rankings": conlist(
        _fields(
            **dict.fromkeys(("kind", "by", "solver", "law", "unclear"), str),
            target=Annotated[Number, Field(gt=0)],
            **dict.fromkeys(("mean", "p50", "p99", "worst"), Number | None),
            **dict.fromkeys(("reached", "problems"), Whole),
        )
    ),
    "reliability": conlist(
        _fields(
            **dict.fromkeys(("solver", "model"), str),
            **dict.fromkeys(("problems", "exact", "own", "near_miss", "wrong", "timeout", "crashed"), Whole),
        )
    ),
    "scenes": conlist(_fields(**dict.fromkeys(("scene", "solver"), str), **dict.fromkeys(("solved", "cells"), Whole))),
}


def write(summary: Summary, folder: Path) -> Path:
    """Write FOLDER/NAME.json with one row of a table per line, so that a change is one line of a diff; return its path."""
    parts = []
    for key, value in ({"format": FORMAT} | summary).items():
        text = json.dumps(value, ensure_ascii=False, allow_nan=False)
        if value and isinstance(value, list):
            text = "[\n" + ",\n".join("  " + json.dumps(row, ensure_ascii=False, allow_nan=False) for row in value) + "\n]"
        parts.append(f'"{key}": {text}')
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{summary['name']}.json"
    write_text(path, "{\n" + ",\n".join(parts) + "\n}\n")
    return path


def read(path: Path) -> Summary:
    """Read the summary in a file. Errors: ResultsError naming the file and the field that is missing or cannot be used."""
    content = read_json(path, LARGEST_SUMMARY)
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ResultsError(f"{path}: not a published summary of format {FORMAT}")
    return _checked(content, path)


def _checked(summary: Summary, origin: Path) -> Summary:
    """Return the summary if all its fields can be used. Errors: ResultsError naming its origin and the first that cannot."""
    kinds = FIELDS | ({"classes": list[str]} if "classes" in summary else {})  # older runs lack it
    try:
        _fields(**kinds).model_validate_json(json.dumps(summary), strict=True)
    except ValidationError as error:
        field = ".".join(part for part in error.errors()[0]["loc"] if isinstance(part, str))
        raise ResultsError(f"{origin}: {field} is missing or cannot be used") from None
    return summary


def summarise(run: Run) -> Summary:
    """Return the summary of a run. Errors: ResultsError if it has not finished, nothing was measured, or an entry of its
    manifest cannot be used in a summary; InputError or ResultsError naming a stored problem that is damaged or has another hash
    than its name."""
    manifest, settings = run.manifest, run.manifest["settings"]
    if not manifest.get("finished"):
        raise ResultsError(f"{run.folder}: the run has not finished; the same command continues it")
    if not measured(run.rows).any():
        raise ResultsError(f"{run.folder}: nothing was measured")
    machine = {name: manifest.get("machine", {}).get(name) for name in MACHINE}
    version, finished = str(manifest.get("versions", {}).get("frictionbench", "")), str(manifest["finished"])
    of_machine = sha256(repr(sorted(machine.items())).encode()).hexdigest()[:6]
    name = "-".join((str(settings.get("suite")), version, of_machine, re.sub(r"\D", "", finished)[:14]))
    runs = (run, run.ranked_by(run.rank_by.other)) if run.times else ()
    ranked = {one.rank_by: choice.choices(one) for one in runs}
    others = {by: [kind._replace(first=not kind.first) for kind in kinds] for by, kinds in ranked.items()}
    facts, maps = run.rows[run.rows["problem"] != ""].drop_duplicates("problem_id"), robustness.map_cells(run)
    libraries = run.rows.dropna(subset=["version"]).drop_duplicates("solver").set_index("solver")["version"].astype(str)
    summary = {
        "name": re.sub(r"[^\w.+-]", "_", name),
        "suite": str(settings.get("suite")),
        "version": version,
        "release": str(manifest.get("release", "")),
        "finished": finished,
        "cells": len(run.rows),
        "workers": manifest.get("workers") or 0,
        "machine": machine,
        "settings": {key: settings.get(key) for key in ("tolerances", "time_limit")},
        "libraries": libraries[libraries != version].to_dict(),
        "problems": {
            "ranked": int(run.ranked["problem_id"].nunique()),
            "trivial": int(facts["trivial"].sum()),
            "idle": int((facts["idle"] & ~facts["trivial"]).sum()),
            "hashes": _hashes(facts, maps),
        },
        "checks": _checks(run, facts, version),
        "headline": choice.headline(ranked, run.outer_targets[-1]) if ranked else [],
        "classes": choice.headline(others, run.outer_targets[-1]) if ranked else [],
        "rankings": [row for by, kinds in ranked.items() for kind in kinds for row in _places(run, by, kind)],
        "reliability": [_plain(one) for one in tables.reliabilities(run).to_dict("records")] if ranked else [],
        "scenes": _scenes(run, maps),
    }
    return _checked(summary, run.folder)


def _hashes(facts: pd.DataFrame, maps: list[MapCells]) -> dict[str, str]:
    """Return the hash of each problem by its origin. A map, which has hundreds of problems, has one hash of all these."""
    hashes, left = {}, facts
    for cells in maps:
        ids = set(cells.rows["problem"]) - {""} if "problem" in cells.rows else set()
        left = left[~left["problem"].isin(ids)]
        if ids:
            hashes[f"map {cells.spec.name}, {len(ids)} problems"] = sha256("".join(sorted(ids)).encode()).hexdigest()[:SHORT]
    for row in left.to_dict("records"):
        step = "" if pd.isna(row["step"]) else f" step {int(row['step'])}"
        hashes[f"{scene_title(row['scene'], row['parameters'])}{step} {row['phase']}".strip()] = row["problem"][:SHORT]
    return hashes


def held(folder: Path, names: set[str]) -> tuple[bool, str]:
    """Return whether the folder stores each problem under its hash, and an explanation. Errors: as for summarise."""
    there = {name: path for name in names if (path := folder / "problems" / f"{name}.npz").exists()}
    for name, path in there.items():
        if fb.load(path).hash != name:
            raise ResultsError(f"{path}: holds another problem than its name says")
    missing = len(names) - len(there)
    if not missing:
        return True, f"The {len(names)} problems in the folder are those that the rows name, by their hashes."
    return False, f"{missing} of {len(names)} problems are not in the folder, so that their hashes were not checked."


def _checks(run: Run, facts: pd.DataFrame, version: str) -> list[list[Any]]:
    idle = float((facts["trivial"] | facts["idle"]).mean()) if len(facts) else 0.0
    crowded = tables.workers_on_all_cores(run.manifest)
    options = tables.replaced(run.manifest)
    checks = [
        ("tables", True, "All columns are those of the schema."),
        ("problems", *held(run.folder, set(run.rows["problem"]) - {""})),
        ("version", "dirty" not in version, f"The code is {version}{', a changed checkout' * ('dirty' in version)}."),
        ("whole suite", not options, f"Options that replace parts of the suite: {options or 'none'}."),
        ("friction at work", idle <= 0.5, f"{100 * idle:.0f} % of the problems are trivial or idle and not ranked."),
        ("timing noise", True, choice.disturbed(run) or "No cell waited for its core."),
        ("cores", not crowded, "Workers had all cores." if crowded else "A core was left free, or there was one worker."),
    ]
    return [[what, bool(holds), text] for what, holds, text in checks]


def _places(run: Run, by: RankBy, kind: Kind) -> list[dict[str, Any]]:
    """Return a row for each solver compared on a kind: at each target for the kinds of OVERALL, otherwise at the tightest."""
    shown = {target: one for target, one in kind.choices.items() if kind.name in run.overall or target == run.outer_targets[-1]}
    return [
        _plain(
            place._asdict()
            | {"kind": kind.name, "by": by.value, "target": target, "problems": one.problems, "unclear": one.unclear}
        )
        for target, one in shown.items()
        for place in one.places
    ]


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row for JSON: the solver first, numbers rounded, null if not finite."""
    kept = {"solver": row["label"]} | {name: value for name, value in row.items() if name not in ("label", "written", "within")}
    return {name: value if isinstance(value, bool | str | int) else _short(float(value)) for name, value in kept.items()}


def _short(value: float) -> float | None:
    if not np.isfinite(value):
        return None
    return int(value) if value == int(value) else float(f"{value:.{TIME_DIGITS}g}")


def _scenes(run: Run, maps: list[MapCells]) -> list[dict[str, Any]]:
    """Return by scene and solver how many of the cells that ran at the tightest tolerance were solved, and by map and solver
    those at grid points with a known solution."""
    keys = {key for cells in maps for key in cells.rows["key"]}
    rest = run.tightest[~run.tightest["key"].isin(keys)]
    mapped, scenes = {f"map {cells.spec.name}": cells.rows[cells.rows["known"]] for cells in maps}, []
    for name, rows in [*rest.groupby("scene"), *mapped.items()]:
        ran = rows[measured(rows)]
        solved = (ran["verdict"] == fb.Verdict.SOLVED).groupby(ran["label"]).agg(["sum", "size"])
        scenes += [
            {"scene": str(name), "solver": str(label), "solved": int(row["sum"]), "cells": int(row["size"])}
            for label, row in solved.iterrows()
        ]
    return scenes
