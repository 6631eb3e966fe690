"""The summary of a run that is published: see results.summaries for its fields."""

import re
from hashlib import sha256
from typing import Any

import numpy as np
import pandas as pd

from frictionbench.reports import choice, noise
from frictionbench.reports.headline import headline
from frictionbench.reports.reliability import reliabilities
from frictionbench.reports.robustness import MapCells, map_cells
from frictionbench.reports.run import Run
from frictionbench.reports.settings import workers_on_all_cores
from frictionbench.results.cells import scene_title
from frictionbench.results.files import ResultsError
from frictionbench.results.rank_by import RankBy
from frictionbench.results.summaries import Summary
from frictionbench.results.verdicts import Verdict, measured

MACHINE = ("processor", "cores", "memory", "system", "python")
DIGITS = 4  # of times
SHORT = 12  # characters of a problem's hash, enough to tell some thousands apart


def summarise(run: Run, problems_held: tuple[bool, str]) -> Summary:
    """The summary. problems_held: whether the stored problems were found to be those that the rows name, and in words.

    Errors: ResultsError where the run has not finished or nothing was measured."""
    manifest = run.manifest
    if not manifest.get("finished"):
        raise ResultsError(f"{run.folder}: the run has not finished; the same command continues it")
    if not measured(run.rows).any():
        raise ResultsError(f"{run.folder}: nothing was measured")
    machine = {name: manifest.get("machine", {}).get(name) for name in MACHINE}
    versions = manifest.get("versions", {})
    version, suite = str(versions.get("frictionbench", "")), str(manifest["settings"].get("suite"))
    finished = str(manifest["finished"])
    of_machine = sha256(repr(sorted(machine.items())).encode()).hexdigest()[:6]
    name = "-".join((suite, version, of_machine, re.sub(r"\D", "", finished)[:14]))
    ranked = {one.rank_by: choice.choices(one) for one in (run, run.ranked_by(run.rank_by.other))} if run.times else {}
    facts, maps = run.rows[run.rows["problem"] != ""].drop_duplicates("problem_id"), map_cells(run)
    return {
        "name": re.sub(r"[^\w.+-]", "_", name),
        "suite": suite,
        "version": version,
        "release": str(manifest.get("release", "")),
        "finished": finished,
        "cells": len(run.rows),
        "workers": int(manifest.get("workers") or 0),
        "machine": machine,
        "settings": {key: manifest["settings"].get(key) for key in ("tolerances", "time_limit")},
        "libraries": _libraries(run, versions),
        "problems": {
            "ranked": int(run.ranked["problem_id"].nunique()),
            "trivial": int(facts["trivial"].sum()),
            "idle": int((facts["idle"] & ~facts["trivial"]).sum()),
            "hashes": _hashes(facts, maps),
        },
        "checks": _checks(run, ranked, facts, version, problems_held),
        "headline": headline(ranked, run.overall, run.outer_targets[-1]) if ranked else [],
        "rankings": [row for by, kinds in ranked.items() for kind in kinds for row in _places(run, by, kind)],
        "reliability": [_plain(one._asdict(), "label") for one in reliabilities(run)] if run.times else [],
        "scenes": _scenes(run, maps),
    }


def _hashes(facts: pd.DataFrame, maps: list[MapCells]) -> dict[str, str]:
    """The hash of each problem, by its place; of a map, with its hundreds of problems, that of all their hashes."""
    found, left = {}, facts
    for cells in maps:
        own = set(cells.rows["problem"]) - {""} if "problem" in cells.rows else set()
        left = left[~left["problem"].isin(own)]
        if own:
            found[f"map {cells.spec.name}, {len(own)} problems"] = sha256("".join(sorted(own)).encode()).hexdigest()[:SHORT]
    return found | {_place(row): row["problem"][:SHORT] for row in left.to_dict("records")}


def _place(row: dict[Any, Any]) -> str:
    """Where a problem comes from: its scene, step and phase."""
    step = "" if pd.isna(row["step"]) else f" step {int(row['step'])}"
    return f"{scene_title(row['scene'], row['parameters'])}{step} {row['phase']}".strip()


def _libraries(run: Run, versions: dict[str, Any]) -> dict[str, str]:
    """The versions that the rows of solvers state, other than ours, by solver."""
    own = versions.get("frictionbench")
    found = run.rows.dropna(subset=["version"]).drop_duplicates("solver")
    return {str(row["solver"]): str(row["version"]) for row in found.to_dict("records") if row["version"] != own}


def _checks(
    run: Run, ranked: dict[RankBy, list[choice.Kind]], facts: pd.DataFrame, version: str, problems_held: tuple[bool, str]
) -> list[list[Any]]:
    idle = float((facts["trivial"] | facts["idle"]).mean()) if len(facts) else 0.0
    found = noise.noise(run, ranked) if ranked else None
    told = noise.sentence(found, len(run.rows)) if found else "No cell waited for its core."
    crowded = workers_on_all_cores(run.manifest)
    checks = [
        ("tables", True, "All columns are those of the schema."),
        ("problems", *problems_held),
        ("version", "dirty" not in version, f"The code is {version}" + ", a changed checkout." * ("dirty" in version)),
        ("friction at work", idle <= 0.5, f"{100 * idle:.0f} % of the problems are trivial or idle and not ranked."),
        ("timing noise", not (found and found.changed), " ".join([told, *(found.changed if found else [])])),
        ("cores", not crowded, "Workers had all cores." if crowded else "A core was left free, or there was one worker."),
    ]
    return [[what, bool(holds), text] for what, holds, text in checks]


def _places(run: Run, by: RankBy, kind: choice.Kind) -> list[dict[str, Any]]:
    """A row for each solver compared on a kind of problem: at each target in the plane and in space, else the finest."""
    return [
        _plain(place._asdict() | facts, "label")
        for target, one in kind.choices.items()
        if kind.name in run.overall or target == run.outer_targets[-1]
        for facts in [
            {"kind": kind.name, "by": by.value, "target": target, "problems": one.problems, "unclear": one.unclear},
        ]
        for place in one.places
    ]


def _plain(row: dict[str, Any], label: str) -> dict[str, Any]:
    """A row as JSON has it: the solver first, numbers short, what is not finite null."""
    dropped = (label, "form", "within")
    kept = {"solver": row[label]} | {name: value for name, value in row.items() if name not in dropped}
    return {name: _short(value) for name, value in kept.items()}


def _short(value: Any) -> Any:
    if isinstance(value, bool | str | int):
        return value
    number = float(value)
    if not np.isfinite(number):
        return None
    return int(number) if number == int(number) else float(f"{number:.{DIGITS}g}")


def _scenes(run: Run, maps: list[MapCells]) -> list[dict[str, Any]]:
    """By scene and solver, how many cells at the tightest tolerance were solved, of those that ran; by map and solver, of those
    at grid points where a solution is known."""
    keys = {key for cells in maps for key in cells.rows["key"]}
    rest = run.tightest[~run.tightest["key"].isin(keys)]
    mapped, found = {f"map {cells.spec.name}": cells.rows[cells.rows["known"]] for cells in maps}, []
    for name, rows in [*rest.groupby("scene"), *mapped.items()]:
        ran = rows[measured(rows)]
        solved = (ran["verdict"] == Verdict.SOLVED).groupby(ran["label"]).agg(["sum", "size"])
        found += [
            {"scene": str(name), "solver": str(label), "solved": int(row["sum"]), "cells": int(row["size"])}
            for label, row in solved.iterrows()
        ]
    return found
