"""Failure maps: for each solver a panel over two parameters of a scene, coloured by verdict; the problem has panels of its own.

What the problem is (how many solutions, how much it answers to a small change, how near to a change of mode, how ill-
conditioned) is drawn beside what the solvers make of it, so that an ill-posed problem and an unstable solver look different.
Thresholds are those that the run traced from the mechanics. All panels of a map are drawn on one pair of axes, in units of
panels: places are counted in grid lines, so that every scale is drawn alike.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex

from reports.charts.chart import Chart
from reports.drawing.figures import Panel, hover
from reports.drawing.style import INK
from reports.drawing.text import plain, seconds
from reports.maps import Cells, map_cells
from reports.run import Run
from results.maps import Axis
from results.schema import CRASHED, MISSED, RELAXED, SKIPPED, SOLVED, TIMEOUT, UNJUDGEABLE, UNSOLVED, WRONG

ACROSS = 7  # panels in a row
GAP = (0.12, 0.42)  # between panels, in panels
CELL = (1.55, 1.2)  # inches of a panel and its gap
VERDICT = {
    SOLVED: "#a9d8b8", RELAXED: "#f0d264", MISSED: "#f4a259", UNSOLVED: "#7b6fb0", WRONG: "#d62728", TIMEOUT: "#6b6b6b",
    CRASHED: "#111111", UNJUDGEABLE: "#c8ccd2", SKIPPED: "#eef0f2",
}  # fmt: skip
TYPE = {
    "open": "#d6dbe1", "sticks": "#3b6fb6", "slides": "#f2a541", "open, sticks": "#9ec1e8", "open, slides": "#f7d9a6",
    "sticks, slides": "#7b9a57", "open, sticks, slides": "#b58ac0",
}  # fmt: skip
SOLUTIONS = {
    "none": "#d62728", "one": "#e8efe9", "several": "#7b3294", "a continuum": "#5aa5c8", "one exists": "#c7ddce",
    "not known": "#9a9a9a",
}  # fmt: skip
THRESHOLDS = {
    "p": ("p = 0", "#111111"),
    "P0": ("P0", "#c2185b"),
    "pointed": ("pointed", "#0b5fa5"),
    "gaps": ("gap 0", "#8a5a00"),
}
WORST = "#5b0f14"  # of a scale, where the value is infinite
Colours = tuple["pd.Series[str]", str]


class Field(NamedTuple):
    """One panel of a map: a title, its cells' colours, and what a reader sees who points at one."""

    title: str
    rows: pd.DataFrame
    colours: "pd.Series[Any]"
    ground: str | None = None  # a colour that most cells have, drawn once
    told: "pd.Series[Any] | None" = None


def verdicts(run: Run) -> list[Panel]:
    """A panel per map: what the problem is, and each solver's verdicts."""
    return [_panel(run, cells, [*_problem(cells), *_verdicts(cells)], VERDICT | SOLUTIONS) for cells in map_cells(run)]


def types(run: Run) -> list[Panel]:
    """A panel per map on which a solver finds more than one type of solution, and few enough contacts to tell."""
    told = [cells for cells in map_cells(run) if "mode" in cells.rows and len(set(cells.rows["mode"].map(_type).dropna())) > 1]
    return [_panel(run, cells, _types(cells), TYPE) for cells in told]


def times(run: Run) -> list[Panel]:
    """A panel per map: each solver's time; in closed loop the drift of energy and the penetration."""
    return [_panel(run, cells, _times(cells) if not cells.spec.steps else _loop(cells), {}) for cells in map_cells(run)]


def _panel(run: Run, cells: Cells, fields: Sequence[Field], legend: dict[str, str]) -> Panel:
    spec = cells.spec
    height = CELL[1] * -(-len(fields) // ACROSS) + 0.6
    draw = partial(_draw, cells=cells, fields=fields, traced=run.thresholds.get(spec.name, {}), legend=legend)
    return Panel(f"{spec.title or spec.name}. {spec.note}", draw, size=(ACROSS * CELL[0], height), name=spec.name)


def _draw(
    ax: Axes, cells: Cells, fields: Sequence[Field], traced: dict[str, list[tuple[float, float]]], legend: dict[str, str]
) -> None:
    ax.axis("off")
    spec, used = cells.spec, set()
    rows = -(-len(fields) // ACROSS)
    for k, field in enumerate(fields):
        corner = ((k % ACROSS) * (1 + GAP[0]), -(k // ACROSS) * (1 + GAP[1]))
        _tiles(ax, cells, field, corner)
        used |= set(field.colours) | {field.ground}
        for name, places in traced.items():
            if name in THRESHOLDS and places:
                x, y = _unit(cells, np.array(places).T)
                ax.plot(corner[0] + x, corner[1] + y, ".", ms=1.6, mew=0, color=THRESHOLDS[name][1])
        ax.text(corner[0], corner[1] + 1.04, plain(field.title, 34), fontsize=6.5, va="bottom")
        if k % ACROSS == 0:
            _ends(ax, spec.y, corner, upwards=True)
        if k // ACROSS == rows - 1 or k + ACROSS >= len(fields):
            _ends(ax, spec.x, corner, upwards=False)
    entries = [(name, colour) for name, colour in legend.items() if colour in used]
    entries += [(THRESHOLDS[name][0], THRESHOLDS[name][1]) for name, places in traced.items() if name in THRESHOLDS and places]
    for k, (name, colour) in enumerate(entries):
        x, y = (k % 8) * 0.95, 1.42 + 0.17 * (k // 8)
        ax.plot(x, y, "s" if k < len(entries) - len(traced) else "o", ms=5, mew=0, color=colour, clip_on=False)
        ax.text(x + 0.06, y, name, fontsize=6.5, va="center")
    ax.set_xlim(-0.3, ACROSS * (1 + GAP[0]))
    ax.set_ylim(-(rows - 1) * (1 + GAP[1]) - 0.32, 1.75)


def _unit(cells: Cells, places: Any) -> Any:
    """Places in grid lines, (2, n), in units of a panel."""
    count = np.array([cells.spec.x.count, cells.spec.y.count])[:, None]
    return (places + 0.5) / count


def _tiles(ax: Axes, cells: Cells, field: Field, corner: tuple[float, float]) -> None:
    rows = field.rows.assign(colour=field.colours, told="" if field.told is None else field.told)
    rows = rows.sort_values(["tile", "i", "j"], ascending=[False, True, True], kind="stable")
    if field.ground:
        ax.add_collection(_boxes([(corner[0], corner[1], 1.0, 1.0)], [field.ground]))
        plain_ground = (rows["colour"] == field.ground) & (rows["tile"] == 1.0)
        rows = rows[~plain_ground]
    width, height = 1 / cells.spec.x.count, 1 / cells.spec.y.count
    boxes, colours, told = [], [], []
    for i, j, tile, colour, text in rows[["i", "j", "tile", "colour", "told"]].itertuples(index=False):
        x, y = (i + 0.5 - tile / 2) * width, (j + 0.5 - tile / 2) * height
        boxes.append((corner[0] + x, corner[1] + y, tile * width, tile * height))
        colours.append(colour)
        told.append(text)
    drawn = _boxes(boxes, colours)
    if field.told is not None:
        drawn.set_urls([hover(text) for text in told])
    else:
        drawn.set_rasterized(True)
    ax.add_collection(drawn)
    ax.plot(
        [corner[0], corner[0] + 1, corner[0] + 1, corner[0], corner[0]],
        [corner[1], corner[1], corner[1] + 1, corner[1] + 1, corner[1]],
        color=INK,
        lw=0.4,
    )


def _boxes(boxes: list[tuple[float, float, float, float]], colours: list[str]) -> PolyCollection:
    return PolyCollection([[(x, y), (x + w, y), (x + w, y + h), (x, y + h)] for x, y, w, h in boxes], facecolors=colours, lw=0)


def _ends(ax: Axes, axis: Axis, corner: tuple[float, float], *, upwards: bool) -> None:
    """The axis' parameter and its values at the ends."""
    low, high = (f"{axis.value(place):.3g}" for place in (0, axis.count - 1))
    if upwards:
        x = corner[0] - 0.03
        ax.text(x, corner[1] + 0.02, low, fontsize=5.5, ha="right", va="bottom")
        ax.text(x, corner[1] + 1, high, fontsize=5.5, ha="right", va="top")
        ax.text(x, corner[1] + 0.5, axis.parameter, fontsize=6, ha="right", va="center", rotation=90)
    else:
        y = corner[1] - 0.04
        ax.text(corner[0], y, low, fontsize=5.5, ha="left", va="top")
        ax.text(corner[0] + 1, y, high, fontsize=5.5, ha="right", va="top")
        ax.text(corner[0] + 0.5, y, axis.parameter, fontsize=6, ha="center", va="top")


def _at(cells: Cells, rows: pd.DataFrame) -> "pd.Series[Any]":
    """Where a cell is, in words."""
    x, y = cells.spec.x, cells.spec.y
    return rows.apply(lambda row: f"{x.parameter} {x.value(row['i']):.4g}, {y.parameter} {y.value(row['j']):.4g}", axis=1)


def _verdicts(cells: Cells) -> list[Field]:
    fields = []
    for entry in cells.entries:
        rows = cells.rows[cells.rows["entry"] == entry]
        known = rows[rows["known"]]
        share = f" {_share((known['verdict'] == SOLVED).mean())}" if len(known) else ""
        residual = rows["worst_residual" if cells.spec.steps else "residual"]
        told = _at(cells, rows) + ": " + rows["verdict"] + residual.map(lambda value: f", residual {value:.1e}")
        told += rows["reason"].map(lambda reason: f"; {reason}" if reason else "") + " · " + rows["key"]
        fields.append(Field(entry + share, rows, rows["verdict"].map(VERDICT).fillna(INK), VERDICT[SOLVED], told))
    return fields


def _share(value: float) -> str:
    """A share of less than one never rounds to one."""
    return f"{np.floor(1000 * value) / 10:g} %"


def _problem(cells: Cells) -> list[Field]:
    """What the problem is, as far as it changes over the map."""
    rows = cells.problems
    if cells.spec.steps:
        return []
    fields = [Field("solutions", rows, rows.apply(_solutions, axis=1).map(SOLUTIONS))]
    scales = (("response", "response"), ("next mode", "mode_distance"), ("condition", "condition"))
    return fields + [_scale(title, rows, rows[name]) for title, name in scales if rows[name].max() > 1.01 * rows[name].min()]


def _solutions(row: "pd.Series[Any]") -> str:
    if row["solutions"]:
        if row["solutions"] == "none" or row["outcomes"] == 1:
            return "none" if row["solutions"] == "none" else "one"
        return "a continuum" if pd.isna(row["outcomes"]) else "several"
    return "one exists" if row["known"] else "not known"


def _scale(title: str, rows: pd.DataFrame, values: "pd.Series[Any]", write: Callable[[float], str] = "{:.0e}".format) -> Field:
    """Values on a logarithmic scale of colours, its ends in the title."""
    size = values.astype(float).abs()
    positive = size[np.isfinite(size) & (size > 0)]
    low, high = (positive.min(), positive.max()) if len(positive) else (1.0, 1.0)
    low = max(low, high * 1e-16)
    share = (np.log(size.clip(lower=low)) - np.log(low)) / max(np.log(high / low), 1e-9)
    table = colormaps["viridis"]
    colours = share.map(
        lambda value: WORST if value > 1 + 1e-9 else "#ffffff" if np.isnan(value) else to_hex(table(float(value)))
    )
    return Field(f"{title} {write(low)} .. {write(high)}", rows, colours)


def _type(mode: object) -> str | None:
    if not isinstance(mode, str) or not mode:
        return None
    kinds = [name for name, letters in (("open", "o"), ("sticks", "s"), ("slides", "lr")) if set(letters) & set(mode)]
    return ", ".join(kinds)


def _types(cells: Cells) -> list[Field]:
    fields = []
    for entry in cells.entries:
        rows = cells.rows[(cells.rows["entry"] == entry) & (cells.rows["verdict"] == SOLVED)]
        fields.append(Field(entry, rows, rows["mode"].map(_type).map(TYPE).fillna("#ffffff")))
    return fields


def _times(cells: Cells) -> list[Field]:
    parts = ((entry, cells.rows[cells.rows["entry"] == entry]) for entry in cells.entries)
    return [_scale(entry, rows, rows["time"], seconds) for entry, rows in parts]


def _loop(cells: Cells) -> list[Field]:
    fields = []
    for title, column in (("drift", "energy_drift"), ("overlap, m", "worst_penetration"), ("free steps", "loose_steps")):
        for entry in cells.entries:
            rows = cells.rows[cells.rows["entry"] == entry]
            fields.append(_scale(f"{entry}: {title}", rows, rows[column].astype(float)))
    return fields


VERDICTS = Chart(
    name="map",
    panels=verdicts,
    section="maps",
    wide=True,
    caption="A map a scene, a panel a solver, and before them panels of what the problem itself is: how many solutions it has, "
    "how much a small change of the data changes the solution, how near the solution is to a change of mode, how ill-"
    "conditioned it is. Behind each name the share solved of the places where a solution is known. Small tiles are "
    "refinements, where neighbours' verdicts differ. Dots are thresholds of theory, traced from the mechanics without a "
    "solver. Point at a failure to read its reason and its row's key.",
)
TYPES = Chart(
    name="map_types",
    panels=types,
    section="maps",
    wide=True,
    title="The type of solution found",
    caption="What the answer makes of the contacts, where it is one: with several solutions, which of them.",
)
TIMES = Chart(
    name="map_times",
    panels=times,
    section="maps",
    wide=True,
    folded=True,
    title="Time over the maps",
    caption="Form, setup and solve; darker is faster. In closed loop the drift of energy relative to the scene's own, the "
    "deepest overlap, and the steps in which nothing touched.",
)
