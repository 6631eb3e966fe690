"""Scenes in generalised coordinates: Siconos' woodpecker, the slider-crank with and without hinges, and derivatives."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.generalised import GeneralisedScene
from frictionbench.problems.schemes import SCHEMES, Step
from frictionbench.problems.simulate import simulate
from studies.slider_crank import SliderCrankAngles
from tests.helpers.friction_problems import lemke
from tests.helpers.paths import siconos_motion

NAMES = ("woodpecker", "slider_crank_angles")


def test_woodpecker_is_that_of_siconos() -> None:
    """250 steps of Moreau's scheme over three impacts, of beak and sleeve; all 15 000 agree to the file's 12 digits."""
    known, made = siconos_motion("woodpecker"), scene("woodpecker", step=2e-5)
    q, v = (
        np.column_stack([known[name] for name in names]) for names in (("y", "phi_M", "phi_S"), ("v", "omega_M", "omega_S"))
    )
    now = Step(0.0, q[0], v[0], made.contacts(q[0]))
    impacts = 0
    for k in range(1, len(q)):
        for _ in range(10):
            before, now = now, SCHEMES["moreau"](made, now, lemke)
            impacts += bool(np.abs(now.v - before.v).max() > 1)
        assert now.q == pytest.approx(q[k], abs=1e-10)
        assert now.v == pytest.approx(v[k], abs=1e-8)
    assert impacts == 3


def test_woodpecker_by_events_sticks_slips_lifts_and_pecks() -> None:
    made = scene("woodpecker", step=0.0422)
    run = list(simulate(made, lemke, SCHEMES["event_driven"], 2))
    events = [event for step in run for event in step.events]
    assert [event.kind for event in events] == ["turn", "slip", "lift", "impact", "impact", "impact", "lift"]
    assert [event.time for event in events[3:6]] == pytest.approx([0.07792, 0.08104, 0.08162], abs=6e-5)  # Siconos, h = 2e-5


@pytest.mark.parametrize("name", NAMES)
def test_gap_functions_have_their_rows(name: str) -> None:
    made = scene(name)
    q, eps = made.q0 + 0.02, 1e-6
    rows = made.contacts(q, np.inf).normal.toarray()
    for k, e in enumerate(np.eye(len(q))):
        ahead, behind = (made.contacts(q + sign * eps * e, np.inf).gap for sign in (1, -1))
        assert rows[:, k] == pytest.approx((ahead - behind) / (2 * eps), abs=1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_forces_follow_from_the_energy(name: str) -> None:
    """Without contacts the energy's rate v'(M v' - k) + v'M. v/2 + V. vanishes at any state."""
    made = scene(name)
    assert isinstance(made, GeneralisedScene)
    q, v, eps = made.q0 + 0.3, np.arange(1.0, 4.0), 1e-6
    a = made.accelerate(q, made.force(q, v, 0.0))
    rate = (made.energy(q + eps * v, v + eps * a) - made.energy(q - eps * v, v - eps * a)) / (2 * eps)
    assert rate == pytest.approx(0, abs=1e-7 * made.kinetic(q, v) + 1e-9)


def test_reduced_slider_crank_moves_as_on_hinges() -> None:
    """By events to the integrator's accuracy, over three impacts; by steps it does not drift off its hinges."""
    reduced = scene("slider_crank_angles", step=0.008)
    assert isinstance(reduced, SliderCrankAngles)
    ends = [
        list(simulate(made, lemke, SCHEMES["event_driven"], 1))[-1] for made in (reduced, scene("slider_crank", step=0.008))
    ]
    assert [len(end.events) for end in ends] == [3, 3]
    assert reduced.place(ends[0].q) == pytest.approx(ends[1].q, abs=1e-8)
    assert reduced.slopes(ends[0].q) @ ends[0].v == pytest.approx(ends[1].v, abs=1e-4)


def test_the_same_problem_reaches_the_solvers() -> None:
    """In contact velocities a step on hinges and one in angles are the same problem."""
    full, reduced = scene("slider_crank", clearance=0.0), scene("slider_crank_angles", clearance=0.0)
    on_hinges, in_angles = full.problem(), reduced.problem()
    assert on_hinges.contacts == in_angles.contacts > 0
    assert in_angles.W.toarray() == pytest.approx(on_hinges.W.toarray(), abs=1e-10 * abs(on_hinges.W).max())
