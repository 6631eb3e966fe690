"""Failure maps: axes, refinement, thresholds known from theory, and invariance under units."""

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape
from matplotlib.figure import Figure

from frictionbench.harness.cells.simulation import run_closed_loop
from frictionbench.harness.maps import crossings, finer, run_maps
from frictionbench.harness.plans import atlas as of_suite
from frictionbench.harness.plans.atlas import axis
from frictionbench.harness.plans.plan import Plan, SimulationCell
from frictionbench.problems import InputError
from frictionbench.problems.analysis.thresholds import THRESHOLDS
from frictionbench.problems.catalogue import scene
from frictionbench.reports.charts.failure_maps import _axis
from frictionbench.reports.drawing import tiles
from frictionbench.reports.page import write_report
from frictionbench.reports.paper import write_paper
from frictionbench.reports.robustness import failures, map_cells, robustness, smallest
from frictionbench.reports.run import read_run
from frictionbench.reports.templates import environment
from frictionbench.results import store
from frictionbench.results.maps import Axis, Map
from frictionbench.solvers import find
from tests.helpers.browser import faults, in_browser
from tests.helpers.command_line import frictionbench
from tests.helpers.runs import quiet

MAPS = {spec.name: spec for spec in of_suite.atlas()}


def small(name: str, across: int = 5, upwards: int = 5, **changes) -> Map:
    """The map of the suite on fewer grid lines."""
    spec = MAPS[name]
    return replace(spec, x=replace(spec.x, count=across), y=replace(spec.y, count=upwards), **changes)


def plan(*maps: Map, solvers: tuple[str, ...]) -> Plan:
    return Plan("test", (), solvers, (1e-6,), simulation_solvers=solvers, simulation_tol=1e-6, maps=maps, time_limit=60.0)


@pytest.fixture(scope="module")
def atlas(tmp_path_factory) -> Path:
    """Four small maps by two exact solvers and a relaxation, with a page."""
    folder = tmp_path_factory.mktemp("maps") / "run"
    maps = (
        small("painleve_rod", 6, 6, refined=False),
        small("sliding_block", 5, 5, most=8),
        small("jam", 5, 3, refined=False, thresholds=("gaps",)),
        small("steps_painleve_rod", 3, 2, steps=5),
    )
    run_maps(plan(*maps, solvers=("hybrid", "lemke", "relaxation_ip")), folder, 2, quiet())
    write_report(folder)
    return folder


def cells(folder: Path, name: str, entry: str = "lemke") -> pd.DataFrame:
    """The rows of one entry on one map, with the map's parameters as columns."""
    (found,) = [part for part in map_cells(read_run(folder)) if part.spec.name == name]
    rows = found.rows[found.rows["variant"] == entry]
    told = rows["parameters"].map(json.loads)
    axes = (found.spec.x.parameter, found.spec.y.parameter)
    return rows.assign(**{name: told.map(lambda values, name=name: values[name]) for name in axes})


def test_axis_values() -> None:
    values = {
        "friction=0:3:4": [0, 1, 2, 3],
        "mass_ratio=log:1e-2:1e2:5": [0.01, 0.1, 1, 10, 100],
        "jitter=zero:1e-4:1e-2:4": [0, 1e-4, 1e-3, 1e-2],
        "shear=both:1e-1:1e1:7": [-10, -1, -0.1, 0, 0.1, 1, 10],
        "blocks=log:1:10:3": [1, 3, 10],
    }
    for text, expected in values.items():
        found = axis("x", text, "stack")
        assert [found.value(place) for place in range(found.count)] == pytest.approx(expected)
    assert axis("x", "jitter=zero:1e-4:1e-2:4", "stack").value(0.5) == 5e-5
    assert [text for _, text in _axis(axis("y", "mass_ratio=log:1e-8:1e6:5", "stack")).ticks] == ["1e-8", "0.1", "1e6"]
    for text in ("friction", "friction=1:2", "friction=2:1:3", "friction=1:2:1", "mass_ratio=log:0:1:3", "shear=both:1:2:4"):
        with pytest.raises(InputError, match=r"^x: "):
            axis("x", text, "stack")


def test_refinement() -> None:
    spec = Map("m", "stack", Axis("friction", 0.0, 0.3, 4), Axis("push", 0.0, 0.2, 3), most=3)
    verdict = {place: "solved" if place[0] < 2 else "unsolved" for place in spec.grid}
    found = {place: {"lemke": verdict[place], "nsgs": "solved"} for place in spec.grid}
    added = finer(spec, found)
    assert [i for i, _ in added] == [1.5] * 3
    later = {(1.5, 0.0): {"lemke": "wrong", "nsgs": "wrong"}, (1.5, 1.0): {"lemke": "solved", "nsgs": "solved"}}
    assert finer(spec, found | later) == added  # as when a run is resumed


@pytest.mark.parametrize(
    ("name", "threshold", "curve"),
    [
        ("painleve_rod", "p", lambda angle, mu: 1 + 3 * np.cos(angle) ** 2 - 3 * mu * np.sin(angle) * np.cos(angle)),
        ("sliding_block", "P0", lambda aspect, mu: 1 - mu * aspect),
        ("jam", "gaps", lambda overlap, mu: overlap / 1e-12),
        ("wedge", "pointed", lambda angle, mu: np.tan(angle) - mu),
    ],
)
def test_thresholds_agree_with_theory(name, threshold, curve) -> None:
    spec = small(name, 4, 4) if name != "jam" else small(name)
    places = crossings(spec, THRESHOLDS[threshold])
    assert len(places) >= 5
    assert max(abs(curve(spec.x.value(i), spec.y.value(j))) for i, j in places) < 0.05


def test_overlap_map_has_no_solution(atlas) -> None:
    rows = cells(atlas, "jam", "hybrid")
    assert set(rows["overlap"]) == {-0.1, -1e-12, 0.0, 1e-12, 0.1}
    assert set(rows.loc[rows["overlap"] <= 0, "verdict"]) == {"solved"}
    assert set(rows.loc[rows["overlap"] == 0.1, "verdict"]) == {"unsolved"}
    assert set(rows.loc[rows["overlap"] == 0.1, "existence"]) == {"none"}


def test_robustness_counts_solvable_cells(atlas) -> None:
    table = robustness(map_cells(read_run(atlas))).set_index("label")
    assert table.loc["hybrid*", "known"] == table.loc["hybrid*", "jam"] == 1.0
    assert table.loc["hybrid*", "all"] < 1.0
    assert table.loc["relaxation_ip", "painleve_rod"] < 0.9


@pytest.mark.slow  # drawn for the paper; the quick tests read the tables of the maps
def test_page_shows_every_map(atlas) -> None:
    run = read_run(atlas)
    run.manifest["settings"]["plugins"] = [{"source": "mine.py", "solvers": ["relaxation_ip"]}]
    page = write_report(atlas, run).read_text(encoding="utf-8")
    assert " --solver mine.py</title>" in page
    assert all(escape(MAPS[name].title) in page for name in ("painleve_rod", "sliding_block", "jam", "steps_painleve_rod"))
    assert "<title>overlap 0.1, friction" in page
    assert "Every grid point is solved by hybrid*, lemke." in page
    assert "on painleve_rod[step=0.0001] over angle 0.3 to 1.5 rad and friction 0.4 to 3.1, to 1e-6. " in page
    maps = [file for file in write_paper(atlas, read_run(atlas)).iterdir() if file.match("map_*.svg")]
    assert {"map_jam.svg", "map_times_steps_painleve_rod.svg", "map_times_jam.svg"} <= {file.name for file in maps}
    assert {ElementTree.parse(file).getroot().tag[-3:] for file in maps} == {"svg"}


def test_map_markup_is_compact_and_escaped() -> None:
    row = [*(tiles.Tile(i, 0, 1.0, "red") for i in range(2)), tiles.Tile(1.5, 0, 0.5, "blue", "<i>")]
    grid = tiles.Grid(tiles.Axis("a", (), 5), tiles.Axis("b", (), 2), {tiles.Entry("", "red", k): [(1.0, 0.0)] for k in "ox"})
    panel = environment().get_template("tiles.svg").module.panel
    drawn = panel(tiles.Field("<b>&", row, "green"), grid)
    assert [drawn.count(f'd="M66.0 94.0{shape}') for shape in ("m-1.7 0a", "m-1-1l")] == [2, 2]  # each with its rim
    assert '<path d="M-0.5 -0.5h1v1h-1zM0.5 -0.5h1v1h-1z"/>' in drawn
    assert '<path d="M1.25 -0.25h0.5v0.5h-0.5z"><title>&lt;i&gt;' in drawn
    assert "&lt;b&gt;&amp;" in drawn
    scaled = tiles.Field("", row, scale=["red", "blue"], ticks=["1", "10", "100"])
    shown = re.findall(r'y="(.*?)" text-anchor="start">(10*)<', panel(scaled, grid))
    assert shown == [("120.5", "1"), ("72.5", "10"), ("24.5", "100")]
    axes = Figure().subplots()
    tiles.draw(axes, scaled, grid)
    assert [line.get_marker() for line in axes.lines] == ["o", "x"]
    assert [text.get_text() for text in axes.figure.axes[1].get_yticklabels()] == ["1", "10", "100"]


def test_map_resumes(atlas) -> None:
    before = store.rows(atlas, "solves").keys()
    assert {0.5, 1.0} == set(map_cells(read_run(atlas))[1].rows["tile"])
    shard = next(iter((atlas / "shards").glob("solves-*.jsonl")))
    lines = shard.read_text(encoding="utf-8").splitlines(keepends=True)
    shard.write_text("".join(lines[:-5]), encoding="utf-8")
    maps = tuple(part.spec for part in map_cells(read_run(atlas)))
    run_maps(plan(*maps, solvers=("hybrid", "lemke", "relaxation_ip")), atlas, 1, quiet())
    assert store.rows(atlas, "solves").keys() == before


def test_a_map_that_is_refined_is_not_finished(tmp_path, monkeypatch) -> None:
    seen = []
    for step in ("frictionbench.harness.run.record_histories", "frictionbench.harness.maps.trace"):
        monkeypatch.setattr(step, lambda _, folder, *__: seen.append("finished" in store.read_manifest(folder)))
    run_maps(plan(small("sliding_block", 3, 3), solvers=("lemke", "relaxation_ip")), tmp_path / "run", 1, quiet())
    assert seen == [False] * max(3, len(seen))
    seen.clear()
    run_maps(plan(small("sliding_block", 3, 3), solvers=("lemke",)), tmp_path / "same", 1, quiet())
    assert seen == [False] * 2  # all points are solved: there is no second round
    assert "finished" in store.read_manifest(tmp_path / "run")


def test_failures_are_listed_smallest_first(tmp_path) -> None:
    spec = Map("m", "stack", Axis("blocks", 2, 3, 2, whole=True), Axis("mass_ratio", 1.0, 1e6, 2, "log"), {"push": 1.0})
    run_maps(plan(replace(spec, refined=False), solvers=("hybrid", "nsgs")), tmp_path / "run", 2, quiet())
    (row,) = smallest(failures(map_cells(read_run(tmp_path / "run")))).to_dict("records")
    assert (row["label"], json.loads(row["parameters"])["blocks"], row["contacts"]) == ("nsgs", 2, 4)
    assert row["key"] in write_report(tmp_path / "run").read_text(encoding="utf-8")


@pytest.mark.slow  # the command line; the quick tests make maps in Python
def test_custom_map(tmp_path) -> None:
    command = ["map", "wedge[speed=2]", "--x", "angle=.2:1:2", "--y", "friction=log:.1:1:2", "--out", str(tmp_path / "run")]
    done = frictionbench(*command, "--solver", "lemke", "--solver", "apgd", cwd=tmp_path)
    assert "cells (grid point and solver): " in done.stdout, done.stderr
    rows = map_cells(read_run(tmp_path / "run"))[0].rows
    assert len(rows) >= 8
    assert set(rows["parameters"].map(lambda told: json.loads(told)["speed"])) == {2}
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "Verdicts of lemke, apgd over angle 0.2 to 1 rad and friction" in page  # the heading names the scene
    for end, upwards, complaint in ((1, "colour", "colour"), (3, "friction", "angle: must be")):
        done = frictionbench("map", "wedge", "--x", f"angle=.2:{end}:3", "--y", f"{upwards}=.1:1:3", cwd=tmp_path)
        assert (done.returncode, complaint in done.stderr) == (2, True)


def test_first_steps_are_not_divergence() -> None:
    cell = SimulationCell("bowl", {"step": 1e-4}, "lemke", 1e-8, "stewart_trinkle", steps=3)
    row = run_closed_loop(cell, scene("bowl", step=1e-4), *find("lemke"))
    assert (row["verdict"], row["reason"], row["steps_done"]) == ("solved", "", 3)


@in_browser
def test_page_looks(atlas) -> None:
    assert faults(atlas / "report.html") == []
