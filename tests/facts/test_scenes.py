"""What mechanics says about the scenes: closed forms, and energy that never rises."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import solvers
from problems import FrictionProblem, scene
from problems.check import Array
from problems.simulate import ledger_defect, simulate

G = 9.81


def lemke(problem: FrictionProblem) -> Array:
    answer = solvers.solve(problem, "lemke", tol=1e-10)
    assert answer.status is solvers.Status.SOLVED
    return answer.impulse


@cache
def two_blocks(friction: float, step: float) -> dict[str, float]:
    """Errors of the speeds after the impact and of the two stopping distances, against the closed form."""
    e, g = 0.2, friction * G
    V = np.sqrt(9 - 2 * g * 2)
    slow, fast = V * (1 - e) / 2, V * (1 + e) / 2
    made = scene("two_blocks", friction=friction, step=step, duration=1.1 * (1 + fast / g))
    parted = np.zeros(2)
    for now in simulate(made, lemke):
        if now.solved and now.solved[0].phase == "compression" and not parted.any():
            parted = now.solved[1].problem.velocity(now.solved[1].impulse)[[0, 3]]
    travel = now.q[[0, 3]] - [-1, 0]
    assert now.v == pytest.approx(np.zeros(6), abs=1e-8)
    found = [*parted, *travel]
    right = [slow, fast, slow**2 / (2 * g), fast**2 / (2 * g)]
    return dict(zip(("slow", "fast", "short", "far"), np.abs(np.subtract(found, right)), strict=True))


def test_two_blocks_as_the_closed_form_says() -> None:
    """Examples 3 and 4: errors of the size h times what moves, so within 2 mu g h of speed and 2 V h of travel."""
    for friction in (0.02, 0.1):
        error = two_blocks(friction, 0.01)
        assert max(error["slow"], error["fast"]) <= 2 * friction * G * 0.01
        assert max(error["short"], error["far"]) <= 2 * 3.0 * 0.01


def test_two_blocks_errors_shrink_like_the_step() -> None:
    steps = [0.02, 0.01, 0.005, 0.0025]
    travel = [two_blocks(0.1, h)["short"] + two_blocks(0.1, h)["far"] for h in steps]
    slope = np.polyfit(np.log(steps), np.log(travel), 1)[0]
    assert 0.7 <= slope <= 1.4


@pytest.mark.parametrize("step", [0.02, 0.01, 0.005])
def test_stopping_block(step: float) -> None:
    speed = 1.0
    mu = speed / (G * step * round(0.5 / step))  # stops after half a second exactly
    made = scene("stopping_block", friction=mu, speed=speed, step=step)
    states = list(simulate(made, lemke))
    for before, after in pairwise(states):
        assert after.v[0] == pytest.approx(max(0.0, before.v[0] - mu * G * step), abs=1e-10)
        assert after.v[1:] == pytest.approx([0, 0], abs=1e-10)
    assert states[-1].q[0] - speed**2 / (2 * mu * G) == pytest.approx(-speed * step / 2, abs=1e-10)


def test_painleve_rod_sticks_where_no_force_can_hold_it() -> None:
    problem = scene("painleve_rod").problem()
    assert problem.q == pytest.approx([-0.0981, -1], abs=1e-12)
    cos, sin, mu = 1 / np.sqrt(5), 2 / np.sqrt(5), 1.5
    assert problem.W.toarray()[0, 0] - mu * abs(problem.W.toarray()[0, 1]) == pytest.approx(1 + 3 * cos**2 - 3 * mu * sin * cos)
    r = lemke(problem)
    assert r == pytest.approx(np.array([[0.383385, 0.42943]]), abs=1e-6)
    assert problem.contact_velocity(r) == pytest.approx(np.zeros((1, 2)), abs=1e-12)


def test_painleve_impulse_in_the_limit() -> None:
    normal = [lemke(scene("painleve_rod", friction=1.6, tip_velocity=-3.0, step=h).problem())[0, 0] for h in (1e-2, 1e-3, 1e-4)]
    assert normal == pytest.approx([0.983, 0.908, 0.9008], abs=5e-4)
    made = scene("painleve_rod", friction=1.6, tip_velocity=-3.0, step=1e-9)
    c, t = lemke(made.problem())[0]
    cos, sin = 1 / np.sqrt(5), 2 / np.sqrt(5)
    assert c == pytest.approx(0.75 * sin * cos * 3)
    assert t == pytest.approx(0.25 * (1 + 3 * cos**2) * 3)
    after = made.problem().velocity(np.array([[c, t]]))
    loss = made.energy(made.q0, made.v0) - made.energy(made.q0, after)
    assert loss == pytest.approx((1 + 3 * cos**2) * 9 / 8, rel=1e-6)


@pytest.mark.parametrize(("friction", "slides"), [(0.05, True), (0.2, False)])
def test_long_bar(friction: float, slides: bool) -> None:
    """Examples 1 and 2: still sliding after 3 s, or at rest."""
    *_, final = simulate(scene("long_bar", friction=friction), lemke)
    assert abs(final.q[2]) < 0.01
    assert bool(final.v[0] > 0.3) is slides
    if not slides:
        assert final.v == pytest.approx(np.zeros(3), abs=1e-6)


def test_three_blocks_lower_one_is_carried_off() -> None:
    *_, final = simulate(scene("example_6"), lemke)
    first, lower, upper = final.q.reshape(3, 3)
    assert lower[0] > 3
    assert lower[1] == pytest.approx(0.5, abs=0.01)
    assert first[0] < upper[0] < lower[0] - 1
    assert upper[1] < 0.75


RUNS = {
    "long_bar": ({"restitution": 1.0, "friction": 0.3}, 150),
    "two_blocks": ({"restitution": 0.9, "friction": 0.1}, 120),
    "three_blocks": ({}, 150),
    "stack": ({"blocks": 5, "push": 3.0, "friction": 0.2}, 60),
    "wall": ({"rows": 3, "columns": 3, "push": 3.0}, 40),
    "pyramid": ({"rows": 3, "push": 2.0}, 60),
    "painleve_rod": ({}, 100),
    "stopping_block": ({}, 60),
}


@pytest.mark.parametrize("name", RUNS)
def test_energy_never_rises_and_every_answer_obeys_the_ledger(name: str) -> None:
    """Contacts give no energy: each step's is at most that before, to round-off; with restitution an impact loses at least
    (1 - e^2)/2 |p|^2 in the metric of M^-1, p the compression impulse."""
    parameters, steps = RUNS[name]
    made = scene(name, **parameters)
    energy = made.energy(made.q0, made.v0)
    largest = abs(energy) + made.v0 @ (made.mass @ made.v0)
    impacts = 0
    v = made.v0
    for now in simulate(made, lemke, steps=steps):
        before, energy = energy, made.energy(now.q, now.v)
        assert energy <= before + 1e-9 * largest
        for solved in now.solved:
            scale = largest + solved.problem.free_velocity @ (made.mass @ solved.problem.free_velocity)
            assert abs(ledger_defect(solved.problem, solved.impulse)) <= 1e-9 * scale
        if len(now.solved) == 3:
            impacts += 1
            compression, decompression, _ = now.solved
            p = compression.problem.jacobian.T @ compression.impulse.ravel()
            thrown = decompression.problem.velocity(decompression.impulse)
            loss = v @ (made.mass @ v) / 2 - thrown @ (made.mass @ thrown) / 2
            assert loss >= (1 - made.restitution**2) / 2 * (p @ (p / made.weights)) - 1e-9 * largest
        v = now.v
    assert impacts > 0 or made.restitution == 0
