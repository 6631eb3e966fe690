"""Failure maps: for each solver a panel over two parameters of a scene, coloured by verdict, and panels for the problem itself.

The panels for the problem distinguish ill-posed problems from unstable solvers. The axes count grid lines on any scale.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import repeat
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.colors import to_hex

from frictionbench.problems.verdicts import Verdict
from frictionbench.reports.charts.chart import Chart
from frictionbench.reports.drawing import tiles
from frictionbench.reports.drawing.style import INK
from frictionbench.reports.drawing.text import percent, power, seconds
from frictionbench.reports.drawing.tiles import Drawing, Entry, Field, Grid, Tile
from frictionbench.reports.robustness import MapCells, map_cells
from frictionbench.reports.run import Run
from frictionbench.results.commands import rerun
from frictionbench.results.conventions import ANOTHER_LAW, POLYGON, endings, number, scene_title
from frictionbench.results.maps import Axis, Map

VERDICT = {
    Verdict.SOLVED: "#a9d8b8", ANOTHER_LAW: "#f0d264", POLYGON: "#cdb27a",
    Verdict.NEAR_MISS: "#f4a259", Verdict.UNSOLVED: "#7b6fb0",
    Verdict.WRONG: "#d62728", Verdict.TIMEOUT: "#6b6b6b", Verdict.CRASHED: "#111111", Verdict.UNJUDGEABLE: "#c8ccd2",
    Verdict.SKIPPED: "#eef0f2",
}  # fmt: skip
TYPE = {
    "open": "#d6dbe1", "sticks": "#3b6fb6", "slides": "#f2a541", "open, sticks": "#9ec1e8", "open, slides": "#f7d9a6",
    "sticks, slides": "#7b9a57", "open, sticks, slides": "#b58ac0",
}  # fmt: skip
SOLUTIONS = {
    "none": "#b0413e", "one": "#e8efe9", "several": "#7b3294", "a continuum": "#5aa5c8", "one exists": "#c7ddce",
    "not known": "#9a9a9a",
}  # fmt: skip
THRESHOLDS = {
    "p": ("p = 0", "#111111", "o"),
    "P0": ("P0 matrix up to here", "#c2185b", "x"),
    "pointed": ("cone pointed up to here", "#0b5fa5", "s"),
    "gaps": ("gap 0", "#8a5a00", "+"),
}
WORST = "#5b0f14"  # the colour of an infinite value on a scale
COLOURS = VERDICT | SOLUTIONS | {"infinite": WORST}
TICKS = 4  # largest number of ticks of an axis
SHADES = 16  # colours of a scale: more could not be distinguished, and each takes an element of the page
MOST_NAMES = 6  # solvers that a note names; of more it states the number
SHORT = partial(number, digits=2)
NO_COLOURS: Mapping[str, str] = {}


def verdicts(run: Run) -> list[Drawing]:
    """Return a drawing per map: the problem's properties, and the verdicts of each solver that fails at some grid point."""
    drawings = []
    for cells in map_cells(run):
        fields = _verdicts(cells, run)
        shown = {label: field for label, field in fields.items() if any(tile.colour != field.ground for tile in field.tiles)}
        perfect = ", ".join(label for label in fields if label not in shown)
        problem, note = _problem(cells)
        note += f"Every grid point is solved by {perfect}." if perfect else ""
        drawings.append(_drawing(run, cells, "Verdicts", [*problem, *shown.values()], note, COLOURS))
    return drawings


def types(run: Run) -> list[Drawing]:
    """Return a drawing for each map on which solvers find more than one type of solution, according to the column `mode`."""
    return _drawings(run, "Contact states", _types, TYPE)


def times(run: Run) -> list[Drawing]:
    """Return a drawing per map: the time of each solver; in closed loop its drift of energy and its penetration."""
    loop = "Drift of energy relative to the scene's energy scale, largest penetration and number of contact-free steps"
    return _drawings(run, "Time of form, setup and solve together", _times) + _drawings(run, loop, _loop)


def _drawings(
    run: Run, what: str, fields: Callable[[MapCells], list[tuple[str, Field]]], legend: Mapping[str, str] = NO_COLOURS
) -> list[Drawing]:
    """Return a drawing of each map that has such fields, with equal ones merged."""
    made = [(cells, fields(cells)) for cells in map_cells(run)]
    return [_drawing(run, cells, what, *_alike(drawn_fields), legend) for cells, drawn_fields in made if drawn_fields]


def _drawing(
    run: Run, cells: MapCells, what: str, fields: Sequence[Field], note: str, legend: Mapping[str, str] = NO_COLOURS
) -> Drawing:
    """Return a drawing whose note begins with what is drawn, over which parameters and for which solvers."""
    spec, names = cells.spec, list(cells.by_label)
    solvers = ", ".join(names) if len(names) <= MOST_NAMES else f"{len(names)} solvers"
    shown = scene_title(spec.scene, json.dumps(spec.parameters))
    on = f" on {shown}" * (shown != spec.title) + f" over {spec.x.extent} and {spec.y.extent}"
    note = f"{what} of {solvers}{on}, to {power(cells.rows['tol'].min())}. {note}".rstrip()
    traced = run.thresholds.get(spec.name, {})
    points = {Entry(*THRESHOLDS[name]): places for name, places in traced.items() if name in THRESHOLDS and places}
    used = {colour for field in fields for colour in (field.ground, *(tile.colour for tile in field.tiles))}
    entries = [Entry(name, colour) for name, colour in legend.items() if colour in used]
    grid = Grid(_axis(spec.x), _axis(spec.y), points)
    title = f"{spec.title or spec.name}. {spec.note}".removesuffix(". ")
    return Drawing(title, spec.name, (*entries, *points), grid, tuple(fields), note, _facts(spec))


def _axis(axis: Axis) -> tiles.Axis:
    """Return an axis with a tick at up to TICKS of its grid lines, including both ends, at equal distances if possible."""
    parts = next((n for n in range(TICKS - 1, 1, -1) if (axis.count - 1) % n == 0), TICKS - 1)
    lines = sorted({round(k * (axis.count - 1) / parts) for k in range(parts + 1)})
    ticks = tuple((float(line), number(axis.value(line))) for line in lines)
    return tiles.Axis(axis.name, ticks, axis.count)


def _facts(spec: Map) -> dict[str, object]:
    """Return what the page needs to name the scene of a tile: its name, its fixed parameters, and the values of both axes at
    every half grid line, down to which maps are refined."""
    axes = {
        way: {"parameter": axis.parameter, "values": [axis.value(k / 2) for k in range(2 * axis.count - 1)]}
        for way, axis in (("x", spec.x), ("y", spec.y))
    }
    return {"scene": spec.scene, "parameters": dict(spec.parameters), "scheme": spec.scheme, "steps": spec.steps, **axes}


def _field(
    title: str, rows: pd.DataFrame, colours: Iterable[str], ground: str = "", tooltips: Iterable[str] = repeat("")
) -> Field:
    """Return a panel with a tile for each row, without those of an empty colour or, if whole, of the ground's colour."""
    every = map(Tile, rows["i"], rows["j"], rows["tile"], colours, tooltips)
    return Field(title, [tile for tile in every if tile.colour and (tile.width < 1 or tile.colour != ground)], ground)


def _verdicts(cells: MapCells, run: Run) -> dict[str, Field]:
    """Return a panel by label. The tooltips of failures end with the command that runs the cell again, which page.js shows."""
    fields, axes = {}, (("i", cells.spec.x), ("j", cells.spec.y))
    for label, rows in cells.by_label.items():
        known = rows[rows["known"]]
        share = f" {percent((known['verdict'] == Verdict.SOLVED).mean(), 1)}" if len(known) else ""
        residual = rows["worst_residual" if cells.spec.steps else "residual"]
        at = rows.apply(lambda row: ", ".join(f"{one.parameter} {number(one.value(row[i]))}" for i, one in axes), axis=1)
        tooltips = at + ": " + rows["verdict"] + residual.map(lambda value: f", residual {number(value, 2)}")
        tooltips += rows["reason"].map(lambda reason: f"; {reason}" if reason else "")
        tooltips += " · " + rows.apply(lambda row: rerun(run.folder, row["key"], row["variant"], run.plugins), axis=1)
        tooltips = tooltips.where(rows["verdict"] != Verdict.RELAXED, "")  # not a failure: the solver's model is solved
        ended = pd.Series(endings(rows), index=rows.index)
        fields[label] = _field(label + share, rows, ended.map(VERDICT).fillna(INK), VERDICT[Verdict.SOLVED], tooltips)
    return fields


def _problem(cells: MapCells) -> tuple[list[Field], str]:
    """Return panels for the properties of the problem that vary over the map, and a note if its solutions do not vary."""
    rows = cells.problems
    if cells.spec.steps:
        return [], ""
    solutions = rows.apply(_solutions, axis=1)
    scales = (("sensitivity", "sensitivity"), ("mode distance", "mode_distance"), ("condition", "condition"))
    fields = [_scale(title, rows, rows[name]) for title, name in scales if rows[name].max() > 1.01 * rows[name].min()]
    if len(different := set(solutions)) == 1:
        return fields, f"Solutions at every grid point: {different.pop()}. "
    return [_field("solutions", rows, solutions.map(SOLUTIONS)), *fields], ""


def _solutions(row: "pd.Series[Any]") -> str:
    if not row["solutions"]:
        return "one exists" if row["known"] else "not known"
    if row["solutions"] == "none":
        return "none"
    return "one" if row["outcomes"] == 1 else "a continuum" if pd.isna(row["outcomes"]) else "several"


def _scale(title: str, rows: pd.DataFrame, values: "pd.Series[Any]", write: Callable[[float], str] = SHORT) -> Field:
    """Return a panel of values on a logarithmic scale of colours, with ticks at its ends and in its middle."""
    size = values.astype(float).abs()
    positive = size[np.isfinite(size) & (size > 0)]
    low, high = (positive.min(), positive.max()) if len(positive) else (1.0, 1.0)
    low = max(low, high * 1e-16)
    share = (np.log(size.clip(lower=low)) - np.log(low)) / max(np.log(high / low), 1e-9)
    shades = [to_hex(colormaps["viridis"](k / SHADES)) for k in range(SHADES + 1)]
    colours = share.map(lambda x: WORST if x > 1 + 1e-9 else "" if np.isnan(x) else shades[round(x * SHADES)])
    ticks = [write(value) for value in (low, np.sqrt(low * high), high)]
    return _field(title, rows, colours)._replace(scale=shades, ticks=ticks)


def _type(mode: str) -> str:
    kinds = (("open", "o"), ("sticks", "s"), ("slides", "lr"))
    return ", ".join(name for name, letters in kinds if set(letters) & set(mode))


def _types(cells: MapCells) -> list[tuple[str, Field]]:
    if "mode" not in cells.rows or len({*cells.rows["mode"].dropna().map(_type)} - {""}) < 2:
        return []
    solved = {label: rows[rows["verdict"] == Verdict.SOLVED] for label, rows in cells.by_label.items()}
    return [
        (label, _field("", rows, rows["mode"].map(_type, na_action="ignore").map(TYPE).fillna("")))
        for label, rows in solved.items()
    ]


def _times(cells: MapCells) -> list[tuple[str, Field]]:
    solvers = {} if cells.spec.steps else cells.by_label
    return [(label, _scale("", rows, rows["time"], seconds)) for label, rows in solvers.items()]


def _alike(fields: Sequence[tuple[str, Field]]) -> tuple[list[Field], str]:
    """Merge equal fields of several labels into one, with a title that says so; return also a note that lists these labels."""
    same: dict[tuple[Any, ...], list[tuple[str, Field]]] = {}
    for label, field in fields:
        same.setdefault((field.title, *field.ticks, *sorted(field.tiles)), []).append((label, field))
    merged, notes = [], []
    for alike in same.values():
        (label, field), others = alike[0], len(alike) - 1
        what = f": {field.title}" if field.title else ""
        merged.append(field._replace(title=f"{label}{f' and {others} more' if others else ''}{what}"))
        if others:
            notes.append(f"{', '.join(name for name, _ in alike)} are equal{f' in {field.title}' if field.title else ''}")
    return merged, "; ".join(notes) + "." * bool(notes)


def _loop(cells: MapCells) -> list[tuple[str, Field]]:
    """Return panels of drift, penetration and contact-free steps for each label, if they vary over the map."""
    columns = {"energy_drift": "drift", "worst_penetration": "overlap, m", "contact_free_steps": "contact-free"}
    return [
        (label, _scale(title, rows, rows[column]))
        for column, title in columns.items()
        for label, rows in cells.by_label.items()
        if cells.spec.steps and rows[column].max() > rows[column].min()
    ]


VERDICTS = Chart(
    name="map",
    panels=verdicts,
    section="maps",
    caption="One map per scene. The first panels show the problem itself, as far as it changes: the number of its solutions, "
    "its sensitivity to a small change of the data, the distance of the solution to a change of mode, and its condition. Then "
    "follows a panel for each solver that fails somewhere, with the share solved of the grid points where a solution is known. "
    "Small tiles, if any, refine between neighbours with different verdicts. Marks are analytical thresholds, traced from the "
    "mechanics without a solver. Scales of colour are logarithmic, from dark to light. Hover over a failure to read "
    "its reason; click a tile for its problem and the commands that solve and show it.",
)
TYPES = Chart(
    name="map_types",
    panels=types,
    section="maps",
    title="The type of solution found",
    caption="The state of the contacts in each verified answer: where there are several solutions, which one was found.",
)
TIMES = Chart(
    name="map_times",
    panels=times,
    section="maps",
    folded=True,
    title="Time over the maps",
    caption="Each panel has its own scale of colours, from dark for the least value to light for the largest.",
)
