"""Polygons in place of the cone, at reduced size; times are those of made rows."""

import pandas as pd

from frictionbench.harness.studies.cone import SPACE
from tests.helpers.studies import reduced, told


def test_polygons_bend_the_path_and_approach_the_cone() -> None:
    names = [("interior_point", 1.0), *((f"lemke[facets={k}]", k / 6.0) for k in (4, 8, 16))]
    times = {"form_time": 0.0, "setup_time": 0.0, "verdict": "solved", "problem": "p"}
    solves = pd.DataFrame([{"variant": name, "solve_time": time} | times for name, time in names])
    found = reduced(
        "cone",
        {"solves": solves},
        ball={"facets": (0, 4, 8, 16), "step": 0.01},
        problems={"facets": (4, 8, 16), "sources": SPACE[1:2]},
    )
    ball, problems = found["ball"], found["problems"]
    assert ball.loc[ball["facets"] > 0, "from_cone"].is_monotonic_decreasing
    assert problems["error"].is_monotonic_decreasing
    assert problems["solutions_apart"].max() < 1e-8
    assert "from 8 facets on Lemke's method takes longer" in told(found).answer
