"""The first steps of a map's scene, recorded at grid points and drawn for the page."""

import json
from pathlib import Path

import numpy as np
import pytest

from frictionbench.harness.maps import EVERY, STEPS, store_first_steps
from frictionbench.problems.scenes import scene
from frictionbench.problems.simulate import simulate
from frictionbench.reports.drawing.first_steps import picture
from frictionbench.results.files import ResultsError
from frictionbench.results.maps import Axis, FirstSteps, Map, first_steps_file, read_first_steps
from frictionbench.results.motion import Outline
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


def test_picture_of_a_rod_a_disc_and_the_ground() -> None:
    shapes = (
        Outline(0, np.array([[-1.0, 0.0], [1.0, 0.0]]), 0.0, False),
        Outline(1, np.zeros((1, 2)), 0.5, False),
        Outline(-1, np.array([[1.0, 0.0], [0.0, 0.0]]), 0.0, True),
    )
    poses = np.array([[[0.0, 1.0, 0.0], [3.0, 0.5, 0.0]], [[0.0, 1.0, np.pi / 2], [3.0, 0.5, 0.0]]])
    drawn = picture(FirstSteps((1.0, 2.0), shapes, poses))
    left, top, width, height = map(float, drawn["view"].split())
    assert (left, left + width) == pytest.approx((-1.675, 4.175))  # bodies from -1 to 3.5, and a margin
    assert (top, top + height) == pytest.approx((-2.675, 0.675))  # y points down
    first, last = drawn["frames"]
    assert first.startswith("M-1 -1L1 -1Z")
    turned = [float(number) for number in last[1:].partition("Z")[0].replace("L", " ").split()]
    assert turned == pytest.approx([0, 0, 0, -2], abs=1e-12)
    assert first.partition("Z")[2] == last.partition("Z")[2]
    ends = [float(pair.split()[0]) for pair in drawn["ground"][1:].split("L")]
    assert min(ends) < left
    assert max(ends) > left + width


@pytest.mark.parametrize(
    "change", [{"poses": []}, {"poses": [[["x", 0, 0]]]}, {"point": [0, float("nan")]}, {"outlines": [{}]}]
)
def test_edited_file_is_refused(change, folder, tmp_path) -> None:
    path = first_steps_file(tmp_path, SPEC)
    path.parent.mkdir()
    path.write_text(json.dumps([json.loads(first_steps_file(folder, SPEC).read_text())[0] | change]))
    with pytest.raises(ResultsError, match=r"rods-steps\.json"):
        read_first_steps(tmp_path, SPEC)
