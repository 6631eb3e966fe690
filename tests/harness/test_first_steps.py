"""The first steps of a map's scene, recorded at grid points and drawn for the page."""

import json
from pathlib import Path

import numpy as np
import pytest

from frictionbench.harness.maps import EVERY, STEPS, store_first_steps
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import simulate
from frictionbench.results.files import ResultsError
from frictionbench.results.maps import Axis, Map, first_steps_file, read_first_steps
from frictionbench.solvers import solve

SPEC = Map("rods", "painleve_rod", Axis("friction", 0.1, 1.0, 3), Axis("angle", 0.5, 1.0, 2))


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    made = tmp_path_factory.mktemp("maps")
    store_first_steps(SPEC, made)
    return made


def test_frames_are_those_of_the_simulation(folder) -> None:
    found = read_first_steps(folder, SPEC)
    assert [one.point for one in found] == SPEC.grid
    stage = scene(SPEC.scene, **SPEC.at((2.0, 1.0)))
    steps = list(simulate(stage, lambda problem: solve(problem, "hybrid", tol=1e-8).impulse, steps=STEPS))
    expected = np.array([step.q.reshape(-1, 3) for step in steps])[::EVERY]
    assert found[-1].poses == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_scenes_in_space_are_left_out(tmp_path) -> None:
    spec = Map("boxes", "sliding_box", Axis("friction", 0.1, 1.0, 2), Axis("speed", 0.5, 1.0, 2))
    store_first_steps(spec, tmp_path)
    assert read_first_steps(tmp_path, spec) == []


@pytest.mark.parametrize(
    "change", [{"poses": []}, {"poses": [[["x", 0, 0]]]}, {"point": [0, float("nan")]}, {"outlines": [{}]}]
)
def test_edited_file_is_refused(change, folder, tmp_path) -> None:
    path = first_steps_file(tmp_path, SPEC)
    path.parent.mkdir()
    path.write_text(json.dumps([json.loads(first_steps_file(folder, SPEC).read_text())[0] | change]))
    with pytest.raises(ResultsError, match=r"rods-steps\.json"):
        read_first_steps(tmp_path, SPEC)
