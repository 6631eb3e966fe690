"""Closed forms of spatial motions: rolling, stopping, tipping, rebounding."""

import numpy as np
import pytest

from frictionbench.problems.catalogue import scene
from frictionbench.problems.scene import GRAVITY, Scene
from frictionbench.problems.schemes import SCHEMES, Step
from frictionbench.problems.simulate import simulate
from frictionbench.solvers import solve

RADIUS, MU, SPEED = 0.1, 0.3, 2.0  # of the scene sliding_ball


def moved(made: Scene, spec: str = "interior_point", scheme: str = "anitescu_potra") -> list[Step]:
    return list(simulate(made, lambda problem: solve(problem, spec, tol=1e-10).impulse, SCHEMES[scheme]))


def worst(made: Scene, scheme: str = "anitescu_potra") -> float:
    """The largest distance from the closed form, m."""
    return max(made.path_error(step.q, step.time) for step in moved(made, scheme=scheme))


@pytest.mark.parametrize("step", [0.02, 0.005])
def test_ball_rolls_at_five_sevenths(step: float) -> None:
    end = 2 * SPEED / (7 * MU * GRAVITY)
    run = moved(scene("sliding_ball", side_spin=0.0, step=step, duration=end + 5 * step))
    slides = [step.time for step in run if abs(step.v[0] - RADIUS * step.v[4]) > 1e-6]  # it turns about y alone
    assert run[-1].v[0] == pytest.approx(5 / 7 * SPEED, rel=1e-8)
    assert RADIUS * run[-1].v[4] == pytest.approx(5 / 7 * SPEED, rel=1e-8)
    assert slides[-1] == pytest.approx(end, abs=step)


def test_side_spin_gives_parabola() -> None:
    coarse, fine = (worst(scene("sliding_ball", step=step, duration=0.22)) for step in (0.02, 0.005))
    assert coarse < 0.01
    assert fine == pytest.approx(coarse / 4, rel=0.2)


@pytest.mark.parametrize("scheme", [name for name, each in SCHEMES.items() if not each.lacks and not each.events])
@pytest.mark.parametrize("heading", [0.0, 0.5, np.pi / 4])
def test_box_stops_where_and_in_the_direction_in_which_it_was_thrown(scheme: str, heading: float) -> None:
    h, mu = 0.02, 0.5
    made = scene("sliding_box", heading=heading, friction=mu, step=h)
    last = moved(made, scheme=scheme)[-1]
    way = SPEED**2 / (2 * mu * GRAVITY)
    assert np.linalg.norm(last.q[:2]) == pytest.approx(way, abs=SPEED * h)
    assert np.arctan2(last.q[1], last.q[0]) == pytest.approx(heading, abs=1e-7)
    assert last.v == pytest.approx(np.zeros(6), abs=1e-7)
    assert last.q[3:] == pytest.approx([1, 0, 0, 0], abs=1e-6)


@pytest.mark.parametrize(("share", "slides"), [(0.999, False), (1.001, True)])
def test_box_slides_from_the_angle_of_friction(share: float, slides: bool) -> None:
    made = scene("sliding_box", slope=np.arctan(share * 0.5), friction=0.5, speed=0.0, duration=0.3)
    last = moved(made)[-1]
    assert (np.linalg.norm(last.v) > 1e-3) == slides
    assert worst(made) < (1e-4 if slides else 1e-9)


@pytest.mark.parametrize(("share", "tips"), [(0.99, False), (1.01, True)])
def test_box_tips_from_the_slope_of_its_diagonal(share: float, tips: bool) -> None:
    made = scene("sliding_box", slope=np.arctan(share / 4), aspect=4.0, friction=1.0, speed=0.0, duration=0.3)
    assert (abs(moved(made)[-1].v[4]) > 1e-3) == tips


@pytest.mark.parametrize(
    ("name", "settings", "most"),
    [
        ("box_tower", {}, 1e-9),
        ("box_tower", {"slope": 0.0}, 1e-9),
        ("box_tower", {"boxes": 2, "mass_ratio": 1000.0}, 1e-9),
        ("box_in_groove", {}, 0.01),
        ("box_in_groove", {"friction": 0.5}, 1e-9),
        ("dropped_ball", {}, 0.005),
        ("dropped_ball", {"restitution": 0.5}, 0.005),
        ("dropped_ball", {"restitution": 1.0}, 0.01),
    ],
)
def test_closed_forms(name: str, settings: dict[str, float], most: float) -> None:
    assert worst(scene(name, **settings)) < most
