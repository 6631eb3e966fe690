"""Recorded motions agree with their scenes, and their pages draw them completely."""

import json
import os
import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.image import imread

from frictionbench.commands.show import energy_balance, page_name, recorded
from frictionbench.harness.cells.motion import record_motion
from frictionbench.problems import InputError
from frictionbench.problems.catalogue import scene, scenes
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import simulate
from frictionbench.reports.animation import write_animation
from frictionbench.results.files import ResultsError
from frictionbench.results.motion import decoded, encoded
from frictionbench.solvers import available, solve
from tests.helpers.browser import browse, faults, in_browser
from tests.helpers.page import Page, digest, with_more_script
from tests.helpers.paths import BAD_SOLVERS
from tests.helpers.plugin import write


@pytest.mark.parametrize(
    ("name", "scheme", "steps"),
    [
        ("two_blocks", "anitescu_potra", 90),
        ("slider_crank", "stewart_trinkle", 40),
        ("bouncing_ball", "paoli_schatzman", 460),
        ("incline", "lotstedt", 10),
        ("painleve_rod", "moreau", 30),
        ("stopping_block", "acceleration", 30),
    ],
)
def test_recording_equals_simulation(name: str, scheme: str, steps: int) -> None:
    stage = scene(name)
    motion = record_motion(stage, "lemke", scheme, steps)
    taken = list(simulate(stage, lambda problem: solve(problem, "lemke", tol=1e-8).impulse, SCHEMES[scheme], steps))
    assert motion.ended == ""
    assert motion.times == pytest.approx([step.time for step in taken], abs=0)
    assert motion.poses == pytest.approx(np.array([step.q.reshape(-1, 3) for step in taken]), abs=0)
    assert motion.energy == pytest.approx([stage.energy(step.q, step.v) for step in taken], abs=0)
    scale = np.abs(motion.energy).max() + np.ptp(motion.kinetic)
    for k, (before, after) in enumerate(pairwise(taken)):  # gravity comes in the last phase of a step
        push = stage.step * stage.force(before.q, before.v, before.time)
        middle = (after.solved[-1].problem.free_velocity[: len(push)] - push / stage.weights + after.v) / 2
        work = sum(np.diff(curve)[k] for curve in (motion.friction, motion.normal, motion.joints))
        assert np.diff(motion.kinetic)[k] == pytest.approx(push @ middle + work, abs=1e-10 * scale)


@pytest.mark.parametrize("name", ["box_tower", "sliding_ball", "box_in_groove"])
def test_recorded_contacts_in_space(name: str) -> None:
    """Points, normals and impulses are those of the scene's contacts, and the balance of energy is that of the motion."""
    stage = scene(name)
    motion, found = record_motion(stage, "interior_point", steps=1), stage.contacts(stage.q0)
    upper = np.where(found.direction[:, 2:] < 0, -found.direction, found.direction)
    wanted, recorded = np.hstack([found.point, upper]), motion.contacts[0]
    distance = np.abs(recorded[:, None, :6] - wanted[None]).max(axis=2)
    assert distance.min(axis=0).max() <= 1e-12
    assert distance.min(axis=1).max() <= 1e-12
    normal = (recorded[:, 3:6] * recorded[:, 6:]).sum(axis=1)
    sliding = np.linalg.norm(recorded[:, 6:] - normal[:, None] * recorded[:, 3:6], axis=1)
    assert (sliding <= stage.friction * normal + 1e-9).all()
    ground = found.bodies[distance.argmin(axis=1), 1] == -1
    held = recorded[ground, 6:].sum(axis=0)  # what holds or slows all bodies
    *_, last = simulate(stage, lambda problem: solve(problem, "interior_point", tol=1e-10).impulse, steps=1)
    momentum = (stage.weights * (last.v - stage.v0)).reshape(-1, 6)[:, :3]
    weight = stage.step * stage.weights[::6].sum() * np.array(stage.gravity)
    assert held == pytest.approx(momentum.sum(axis=0) - weight, abs=1e-6)


def test_failing_scheme_is_reported() -> None:
    motion = recorded("painleve_rod", "lemke", "acceleration", None)
    assert "no bounded force" in motion.ended
    assert len(motion.times) == len(motion.contacts) == 1
    for arguments, complaint in (
        (("two_blocks", "lemke", "lotstedt", None), r"^scheme: it has no law of restitution"),
        (("stack", str(BAD_SOLVERS), "moreau", None), r"^solver: .* name one"),
        (("random_bodies[contacts=3]", "nsgs", "moreau", None), "^scene: 'random_bodies' is no scene but"),
    ):
        with pytest.raises(InputError, match=complaint):
            recorded(*arguments)


def test_plugin_runs_in_separate_process(tmp_path) -> None:
    """It has no answer, which ends the motion, and says what it likes of the scene's name, which names a file."""
    first, body = (
        f"import os; open({str(tmp_path / 'trace')!r}, 'w').write(str(os.getpid()))",
        "return Answer(np.full((1, 2), np.nan), Status.SOLVED)",
    )
    plugin = write(tmp_path / "guest.py", first=first, body=body)
    motion = recorded("stack[blocks=1]", str(plugin), "anitescu_potra", 5)
    assert (tmp_path / "trace").read_text() != str(os.getpid())
    assert motion.ended.startswith("guest returned no usable answer")
    assert "guest" not in available()


def test_encoded_motion_round_trip() -> None:
    motion = record_motion(scene("slider_crank"), "lemke", steps=40)
    again = decoded(json.loads(json.dumps(encoded(motion))), "worker")
    assert again.parameters == motion.parameters
    for name in ("times", "poses", "energy", "kinetic", "friction", "normal", "joints", "residual", "hinges"):
        assert getattr(again, name) == pytest.approx(getattr(motion, name), rel=1e-11)
    assert [c.shape for c in again.contacts] == [c.shape for c in motion.contacts]
    assert [o.body for o in again.outlines] == [2, -1, -1, 0, 1]
    assert page_name("stack[blocks=5]", None, "moreau") == "stack-blocks=5-moreau.html"
    told = energy_balance(recorded("bouncing_ball[restitution=1]", None, "moreau", 200))
    assert 0 <= float(re.findall(r"s by (\S+) J in all, ", told)[0]) < 1e-9


def test_invalid_motions_are_refused() -> None:
    good = encoded(record_motion(scene("jam"), "lemke", steps=2))
    bad = [{"times": [0.0]}, {"poses": [[1.0]]}, {"energy": [0, 0, float("nan")]}, {"outlines": [{}]}]
    bad += [{"contacts": [[1], [], []]}, {"parameters": 3}, {"hinges": [[7, 0, 0]]}]
    for found in ([], {}, *(good | change for change in bad)):
        with pytest.raises(ResultsError, match="worker: cannot be read"):
            decoded(found, "worker")


def test_every_scene_has_a_self_contained_page(tmp_path) -> None:
    for name in scenes():
        page = Page(write_animation(record_motion(scene(name), "interior_point", steps=3), tmp_path / f"{name}.html"))
        assert page.references == []
        assert page.count["script"] == 2
        data = json.loads(page.scripts["application/json"][0])
        assert len(data["times"]) == len(data["poses"]) == len(data["contacts"]) == 4
        assert f"script-src {digest(page.scripts[''][0])}" in (tmp_path / f"{name}.html").read_text()


EVIL = "</script><script>document.documentElement.dataset.error='got in'</script><!--\u2028'\"&{{ 7 * 7 }}<b onload=x>"


def evil_motion():
    motion = record_motion(scene("stack", blocks=2), "lemke", steps=25)
    for name in ("scene", "solver", "scheme", "ended"):
        object.__setattr__(motion, name, EVIL)
    object.__setattr__(motion, "parameters", {EVIL: EVIL})
    return motion


def test_untrusted_text_is_escaped(tmp_path) -> None:
    page = Page(write_animation(evil_motion(), tmp_path / "page.html"))
    assert page.count["script"] == 2
    assert "b" not in page.count
    assert "{{ 7 * 7 }}" in page.text
    assert "<" not in "".join(page.scripts["application/json"])


@in_browser
@pytest.mark.parametrize("kind", ["three_blocks", "evil", "cut short"])
def test_page_runs_in_browser(tmp_path, kind: str) -> None:
    motions = {
        "three_blocks": lambda: record_motion(scene("three_blocks"), "lemke", steps=100),
        "evil": evil_motion,
        "cut short": lambda: record_motion(scene("painleve_rod"), "lemke", "acceleration"),
    }
    motion = motions[kind]()
    page = write_animation(motion, tmp_path / "page.html")
    wanted = min(20, len(motion.times) - 1)
    (opening,) = re.findall(r"<html[^>]*>", browse(page, "--dump-dom", anchor="frame=20"))
    assert 'data-status="ready"' in opening
    assert f'data-frame="{wanted}"' in opening
    assert "data-error" not in opening
    if kind == "three_blocks":
        pictures = [page.with_name(f"{frame}.png") for frame in (0, 20)]
        for frame, picture in zip((0, 20), pictures, strict=True):
            browse(page, f"--screenshot={picture}", anchor=f"frame={frame}")
        first, second = map(imread, pictures)
        assert 0.001 < np.mean(np.any(first != second, axis=-1)) < 0.5


HANDS = """
requestAnimationFrame = (step) => setTimeout(() => step(performance.now()), 16);  // without a screen there are no frames
const seen = [];
const press = (key, shiftKey = false) => { dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey })); seen.push(frame); };
press("ArrowRight"); press("ArrowRight", true); press("ArrowLeft"); press("End"); press("ArrowRight"); press("Home");
press(" ");
setTimeout(() => {
  seen.push(playing && frame > 10);
  element("frame").value = 55;
  element("frame").dispatchEvent(new Event("input"));
  seen.push(playing, frame);
  element("play").click();
  setTimeout(() => { seen.push(playing, frame); page.dataset.seen = seen.join(" "); }, 8000);
}, 500);
"""


@in_browser
def test_page_controls(tmp_path) -> None:
    page = write_animation(record_motion(scene("three_blocks"), "lemke", steps=100), tmp_path / "page.html")
    assert faults(page) == []
    with_more_script(page, HANDS)
    (opening,) = re.findall(r"<html[^>]*>", browse(page, "--dump-dom", "--virtual-time-budget=10000", anchor="frame=0"))
    assert "data-error" not in opening
    assert 'data-seen="1 11 10 100 100 0 0 true false 55 false 100"' in opening
