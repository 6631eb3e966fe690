"""The event-driven scheme on closed forms and on Siconos' motions: times of impacts, forces, accumulation, and its ends."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from frictionbench.harness.cells.motion import record_motion
from frictionbench.problems.catalogue import scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, Step, start
from frictionbench.problems.schemes.event_driven import follow
from frictionbench.problems.schemes.impact import impact
from frictionbench.problems.schemes.stepping import Event
from frictionbench.problems.simulate import simulate
from studies.slider_crank import slider_crank_angles
from tests.helpers.friction_problems import lemke
from tests.helpers.paths import siconos_motion

G = 9.81


def followed(name: str, scheme: str = "event_driven", steps: int = 1, **parameters: float) -> tuple[list[Event], Step]:
    made = scene(name, **parameters)
    run = list(simulate(made, lemke, SCHEMES[scheme], steps))
    return [event for step in run for event in step.events], run[-1]


@pytest.mark.parametrize("scheme", ["event_driven", "event_driven_newton"])
def test_ball_has_the_impacts_of_siconos(scheme: str) -> None:
    """44 impacts by events located with LSODAR, themselves within 5e-12 s of the closed form."""
    known = siconos_motion("ball_impacts")
    events, _ = followed("bouncing_ball", scheme, restitution=0.9, step=8.5)
    assert [event.kind for event in events] == ["impact"] * 44
    assert [event.time for event in events] == pytest.approx(known["t"], abs=2e-11)
    assert [event.before[1] for event in events] == pytest.approx(known["v_before"], abs=1e-11)
    assert [event.after[1] for event in events] == pytest.approx(known["v_after"], abs=1e-11)


def test_ball_by_moreau_is_that_of_siconos() -> None:
    known = siconos_motion("ball_moreau")[:41]
    made = scene("bouncing_ball", restitution=0.9, step=0.005, duration=4.0)
    run = list(simulate(made, lemke, SCHEMES["moreau"]))[::20]
    assert [step.q[1] - 0.5 for step in run] == pytest.approx(known["q"], abs=1e-13)
    assert [step.v[1] for step in run] == pytest.approx(known["v"], abs=1e-12)


def test_accumulation_and_rest() -> None:
    """The bounces end at sqrt(2 height/g) (1 + e)/(1 - e); the ball then rests, also across the scheme's steps."""
    events, end = followed("bouncing_ball", steps=3, restitution=0.5, step=0.6, duration=1.8)
    assert events[-1].kind == "accumulation"
    assert events[-1].time == pytest.approx(3 * np.sqrt(2 / G), abs=1e-11)
    assert end.q == pytest.approx([0, 0.5, 0], abs=1e-12)
    assert end.v == pytest.approx(np.zeros(3), abs=1e-12)


def test_rocking_block_is_that_of_its_corners() -> None:
    """By scipy's integration of the rotation about one corner after the other, with Housner's loss of spin in between."""
    (first, second), end = followed("rocking_block", step=1.2)
    state, begun, kept = np.array([0.1, 0.0]), 0.0, 1 - 1.5 * np.sin(np.arctan(0.25)) ** 2
    for corner, until, angle in ((1, first.time, 0.0), (-1, second.time, 0.0), (1, 1.2, end.q[2])):
        lever = lambda _, y, side: [y[1], -0.75 * G * (side * 0.25 * np.cos(y[0]) - np.sin(y[0])) / (1 + 0.25**2)]  # noqa: E731
        leg = solve_ivp(lever, (begun, until), state, "DOP853", args=(corner,), rtol=1e-13, atol=1e-15).y[:, -1]
        assert leg[0] == pytest.approx(angle, abs=1e-9)
        state, begun = leg * [1, kept], until


def test_rod_sticks_slips_and_falls() -> None:
    """Energy changes by the work of friction, which is integrated, and in the last impact alone."""
    motion = record_motion(scene("painleve_rod", friction=0.5, step=0.1), "lemke", "event_driven", 9)
    events, _ = followed("painleve_rod", steps=9, friction=0.5, step=0.1)
    assert [event.kind for event in events] == ["turn", "slip"]
    assert motion.friction[-1] < -0.1
    assert np.abs(motion.defect).max() < 1e-8 * np.ptp(motion.energy)


def test_hinges_hold() -> None:
    """A pendulum keeps its energy and its length."""
    motion = record_motion(scene("pendulum", step=0.5), "lemke", "event_driven", 4)
    assert np.ptp(motion.energy) < 1e-9 * np.ptp(motion.kinetic)
    assert max(np.abs(scene("pendulum").joints(pose.ravel())[0]).max() for pose in motion.poses) < 1e-12


def test_rest_needs_no_event() -> None:
    """Six contacts whose forces are not determined."""
    events, end = followed("stack", step=0.05, blocks=3, push=0.0)
    assert events == []
    assert end.q == pytest.approx(scene("stack", blocks=3).q0, abs=1e-12)


def test_a_contact_is_kept_from_step_to_step() -> None:
    """A bead that slides in a bowl arrives in five steps where it does in one."""
    events, end = followed("bowl", steps=5, friction=0.3, step=0.1)
    assert events == []
    assert end.q == pytest.approx(followed("bowl", friction=0.3, step=0.5)[1].q, abs=1e-9)


def test_inconsistent_rod_ends_the_motion() -> None:
    with pytest.raises(NoSolution, match=r"^no bounded force prevents .* sliding at \(0, 0\), at t = 0 s$"):
        followed("painleve_rod")


def test_impacts_of_several_contacts_may_accumulate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("frictionbench.problems.schemes.event_driven.MOST_EVENTS", 3)
    with pytest.raises(NoSolution, match=r"^3 events by t = .* accumulate"):
        followed("bouncing_ball", step=5.0)


@pytest.mark.parametrize(("accuracy", "steps"), [(1e-10, 1), (1e-3, 4)])
def test_contacts_that_have_just_rebounded_touch_no_second_time(accuracy: float, steps: int) -> None:
    """Two corners of the slider rebound from gaps of rounding's size: each smooth part after that advances."""
    made, run = scene(slider_crank_angles.__name__, step=0.01), []
    now = start(made)
    for _ in range(steps):
        now = follow(made, now, lemke, impact, accuracy)
        run += now.smooth
    assert len(run) < 50


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("stopping_block", {"speed": -1.0}),
        ("incline", {}),
        ("incline", {"friction": 0.7}),
        ("incline", {"speed": 0.5, "friction": 0.7}),
    ],
)
def test_planar_scenes_keep_to_their_closed_forms(name: str, parameters: dict[str, float]) -> None:
    made = scene(name, step=0.1, **parameters)
    errors = [made.path_error(step.q, step.time) for step in simulate(made, lemke, SCHEMES["event_driven"], 6)]
    assert errors == pytest.approx([0.0] * 7, abs=1e-9)
