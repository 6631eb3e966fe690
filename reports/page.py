"""The report: one self-contained HTML file made from a results folder, without running anything again. It links to the
animations of the scenes, which lie beside it.

Names and reasons in a results folder may come from strangers: the template escapes all text, the page runs no script and
loads nothing, and figures are drawn without interpreting names.
"""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from reports import energy, growth, profiles, speed_accuracy, tables
from reports.accuracy import ALL, TARGETS, summary, times_to
from reports.animation import write_animations
from reports.cells import annotate, annotate_drives, contested, entrants
from reports.figures import Panel, inline_svg, save_sheet, swatch
from reports.style import looks, power, seconds
from reports.template import environment
from results.schema import VERDICTS
from results.store import read_manifest, read_table

OWN = ["overhead", "wall_time"]
GROWTH = TARGETS[1]  # of the chart of time against size
MOST_CURVES = 24  # panels of energy curves on the page
MOST_CLAIMS = 200  # wrong claims listed on the page


def write_report(folder: Path) -> Path:
    """Write DIR/report.html, the figures in DIR/figures/ and the animations in DIR/motion/; return the report's path.

    Errors: results.store.ResultsError where DIR is not a results folder or a table cannot be read.
    """
    manifest = read_manifest(folder)
    rows = annotate(read_table(folder, "solves"))
    drives = annotate_drives(read_table(folder, "drives"))
    page = environment().get_template("page.html").render(_contents(folder, manifest, rows, drives))
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8", errors="replace")
    return path


def _contents(folder: Path, manifest: dict[str, Any], rows: pd.DataFrame, drives: pd.DataFrame) -> dict[str, Any]:
    real = contested(rows)
    times = {target: times_to(real, target) for target in TARGETS}
    summaries = {target: summary(table) for target, table in times.items()}
    look = looks(entrants(rows) + entrants(drives))
    charts = {
        "speed_accuracy": speed_accuracy.panels(rows, look),
        "profiles": profiles.panels(times, look) if len(real) else [],
        "growth": growth.panels(rows, look, GROWTH),
        "energy": energy.panels(drives, look)[:MOST_CURVES],
    }
    claims = tables.wrong_claims(rows)
    animations = write_animations(folder)
    scene_of = dict(zip(rows["problem_class"], rows["scene"], strict=True))
    return {
        "folder": folder.resolve().name,
        "manifest": manifest,
        "setup": _setup(manifest),
        "finished": "finished" in manifest,
        "rows": rows,
        "real": real,
        "problems": rows["problem_id"].nunique(),
        "contested": real["problem_id"].nunique(),
        "gaps": tables.gaps(real),
        "headline": headline(summaries),
        "growth_target": GROWTH,
        "looks": look,
        "swatches": {entry: Markup(swatch(one)) for entry, one in look.items()},
        "matrices": {target: _matrix(table) for target, table in summaries.items()},
        "races": {name: _race(summaries, name) for name in [ALL, *rows["problem_class"].unique()]},
        "solvability": tables.solvability(rows),
        "overhead": tables.overhead(pd.concat([rows[OWN], drives[OWN]])),
        "outcomes": tables.OUTCOMES,
        "verdicts": VERDICTS,
        "reasons": tables.reasons(rows),
        "figures": {name: _drawn(panels) for name, panels in charts.items() if _saved(folder, name, panels, look)},
        "by_class": tables.by_class(real),
        "classes": tables.problem_classes(rows),
        "drives": drives,
        "animations": animations,
        "animations_of": lambda name: [page for page in animations if page["scene"] == scene_of[name]],
        "claims": claims.head(MOST_CLAIMS),
        "claims_count": len(claims),
        "rerun": lambda key: f"frictionbench rerun {shlex.quote(str(folder))} {shlex.quote(key)}",
        "scene_title": energy.scene_title,
    }


def headline(summaries: dict[float, pd.DataFrame]) -> list[str]:
    """Two sentences: who reaches the finest target most often, and who reaches the coarsest fastest."""
    found = {target: tables.leaders(table) for target, table in summaries.items()}
    finest, coarsest = min(found), max(found)
    if not (best := found[finest]):
        sentences = [f"No solver reaches a verified residual of {power(finest)} on any non-trivial problem."]
    else:
        first, equals = best.most_often, best.equals
        among = f", the fastest of {equals} solvers that reach as many" if equals > 1 else ""
        sentences = [
            f"{first['entry']} reaches a verified residual of {power(finest)} most often: on {first['reached']} of "
            f"{first['problems']} non-trivial problems, in {seconds(first['mean'])} on average{among}."
        ]
    if best := found[coarsest]:
        sentences.append(
            f"For {power(coarsest)} {best.fastest['entry']} is the fastest of those that reach it about as often as any: on "
            f"{best.fastest['reached']} of {best.fastest['problems']}, in {seconds(best.fastest['mean'])} on average."
        )
    return sentences


def _setup(manifest: dict[str, Any]) -> str:
    """Suite, machine and versions that matter most, as far as the manifest tells."""
    told = [f"suite {manifest['settings'].get('suite', 'unnamed')}"]
    for part, names in (
        ("machine", ("host", "processor", "cores", "system")),
        ("versions", ("frictionbench", "numpy", "numba")),
    ):
        values = manifest.get(part)
        if isinstance(values, dict):
            told += [f"{name} {values[name]}"[:80] for name in names if name in values]
    return " · ".join(told)


def _matrix(table: pd.DataFrame) -> list[tuple[str, dict[str, Any]]]:
    """Entries from the most problems reached to the least, the faster first among equals, each with its row per class."""
    overall = table[table["problem_class"] == ALL].sort_values(["reached", "mean"], ascending=[False, True])
    cells = {key: group.set_index("problem_class").to_dict("index") for key, group in table.groupby("entry")}
    return [(entry, cells[entry]) for entry in overall["entry"]]


def _race(summaries: dict[float, pd.DataFrame], problem_class: str) -> list[dict[str, Any]]:
    """Entries of a class with their row at each target, best at the finest target first."""
    own = {target: table[table["problem_class"] == problem_class].set_index("entry") for target, table in summaries.items()}
    order = own[min(own)].sort_values(["reached", "mean"], ascending=[False, True]).index
    return [{"entry": entry, "cells": [table.loc[entry].to_dict() for table in own.values()]} for entry in order]


def _saved(folder: Path, name: str, panels: Sequence[Panel], look: dict[str, Any]) -> bool:
    if panels:
        (folder / "figures").mkdir(exist_ok=True)
        save_sheet(panels, look, folder / "figures" / name)
    return bool(panels)


def _drawn(panels: Sequence[Panel]) -> list[tuple[str, Markup]]:
    return [(panel.title, Markup(inline_svg(panel))) for panel in panels]
