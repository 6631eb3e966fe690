"""Steps of an engine are written and read back whole, and refused by name where they cannot be used."""

import json

import numpy as np
import pytest

import frictionbench as fb
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.recorded import native
from frictionbench.problems.recorded.native import EngineStep
from tests.helpers.friction_problems import spatial

PROBLEM = spatial(5, contacts=3)
IMPULSE = np.arange(9.0).reshape(3, 3)
NOTES = {"torsional friction": 0.125, "Gelenk-Anschläge": 1.0}


def text(content: str) -> np.ndarray:
    return np.frombuffer(content.encode(), dtype=np.uint8)


def test_steps_are_read_back(tmp_path) -> None:
    fb.save(PROBLEM, tmp_path / "step.npz", impulse=IMPULSE, notes=NOTES, step=0.002)
    found = fb.load_step(tmp_path / "step.npz")
    assert found.problem.hash == PROBLEM.hash == fb.load(tmp_path / "step.npz").hash
    assert np.array_equal(found.impulse, IMPULSE)
    assert (found.notes, found.step) == (NOTES, 0.002)
    assert not found.impulse.flags.writeable


def test_steps_are_numbered(tmp_path) -> None:
    step = EngineStep(PROBLEM, IMPULSE)
    (tmp_path / "step_000009.npz").touch()
    assert [step.save(tmp_path).name for _ in range(2)] == ["step_000010.npz", "step_000011.npz"]
    assert fb.load_step(tmp_path / "step_000011.npz").step is None


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"impulse": np.zeros((2, 3))}, "impulse: expected length 9, got 6"),
        ({"impulse": IMPULSE, "notes": {"limits": 1.5}}, "notes: limits: must be finite and at least 0 and at most 1"),
        ({"impulse": IMPULSE, "step": 0.0}, "step: must be finite and above 0"),
        ({"impulse": IMPULSE, "step": 10**400}, "step: must be finite and above 0"),
        ({"notes": NOTES}, "impulse: is missing"),
    ],
)
def test_unusable_steps_are_refused(tmp_path, settings, named) -> None:
    with pytest.raises(fb.InputError, match=named):
        fb.save(PROBLEM, tmp_path / "step.npz", **settings)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("notes", text("[" * 60_000), "notes: not a JSON object"),
        ("notes", text(json.dumps({"limits": "x"})), "notes: limits: expected a finite number"),
        ("impulse", IMPULSE.T[:2], "impulse: expected shape"),
        ("impuls", IMPULSE, "impuls: unknown array; known are "),
    ],
)
def test_edited_steps_are_refused(tmp_path, name, value, told) -> None:
    native.save(EngineStep(PROBLEM, IMPULSE, NOTES, 0.01), tmp_path / "step.npz")
    np.savez(tmp_path / "step.npz", **dict(np.load(tmp_path / "step.npz")) | {name: value})
    for read in (fb.load, fb.load_step):
        with pytest.raises(fb.InputError, match=f"step.npz: {told}"):
            read(tmp_path / "step.npz")


def test_other_files_hold_no_step(tmp_path) -> None:
    fb.save(PROBLEM, tmp_path / "problem.npz")
    np.savez(tmp_path / "plain.npz", W=np.eye(2), q=[-1.0, 0.3], mu=0.5, d=2)
    for name, told in (("problem", "not the impulses that an engine used"), ("plain", "not a file of fb.save")):
        with pytest.raises(fb.InputError, match=told):
            fb.load_step(tmp_path / f"{name}.npz")
    for path, problem in (("a.hdf5", PROBLEM), ("a.npz", random_problem(1).lcp())):
        with pytest.raises(fb.InputError, match=r"path: .* alone holds|problem: an LCP"):
            fb.save(problem, tmp_path / path, impulse=IMPULSE)
