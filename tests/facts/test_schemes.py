"""Known properties of the time-stepping schemes: stopping distances, drift, restitution, and problems without solution."""

from collections.abc import Iterator

import numpy as np
import pytest

from frictionbench import solvers
from frictionbench.problems import FrictionProblem
from frictionbench.problems.catalogue import scene
from frictionbench.problems.check import Array
from frictionbench.problems.residual import relaxation_residual
from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES, NoSolution, Step
from frictionbench.problems.simulate import simulate
from tests.helpers.friction_problems import lemke

G = 9.81
BOUNCING = [name for name, scheme in SCHEMES.items() if "restitution" not in scheme.lacks and not scheme.events]


def relaxation(problem: FrictionProblem) -> Array:
    answer = solvers.solve(problem, "clarabel", tol=1e-10)
    assert relaxation_residual(problem, answer.impulse) <= 1e-8
    return answer.impulse


def states(made: Scene, name: str, steps: int | None = None) -> Iterator[Step]:
    return simulate(made, lemke, SCHEMES[name], steps)


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("acceleration", -0.5),
        ("anitescu_potra", -0.5),
        ("lotstedt", 0.5),  # the first step is without friction
        ("moreau", 0.0),
        ("moreau_euler", -0.5),
        ("stewart_trinkle", -0.5),
    ],
)
def test_stopping_distance(name: str, error: float) -> None:
    """Short of or beyond v0^2/(2 mu g) by this share of v0 h, exactly."""
    h, speed = 0.02, 1.0
    mu = speed / (G * h * 25)
    *_, end = states(scene("stopping_block", friction=mu, speed=speed, step=h), name)
    assert end.v == pytest.approx(np.zeros(3), abs=1e-9)
    assert (end.q[0] - speed**2 / (2 * mu * G)) / (speed * h) == pytest.approx(error, abs=1e-8)


def drifts(name: str, **parameters: float) -> list[float]:
    """How far the bead ever leaves its path, with steps of .02, .01 and .005 s."""
    runs = (states(scene("bowl", step=h, **parameters), name) for h in (0.02, 0.01, 0.005))
    return [max(abs(1 - np.hypot(*now.q[:2])) for now in run) for run in runs]


@pytest.mark.parametrize(
    ("name", "known"), [("anitescu_potra", [4.8e-2, 2.5e-2, 1.2e-2]), ("stewart_trinkle", [1.3e-3, 3.3e-4, 8.4e-5])]
)
def test_drift_in_the_bowl(name: str, known: list[float]) -> None:
    assert drifts(name) == pytest.approx(known, rel=0.05)


@pytest.mark.parametrize(
    ("name", "order", "parameters"),
    [("lotstedt", 1, {}), ("moreau", 1, {}), ("moreau_euler", 2, {}), ("paoli_schatzman", 2, {"friction": 0.0})],
)
def test_orders_of_drift(name: str, order: int, parameters: dict[str, float]) -> None:
    found = drifts(name, **parameters)
    assert np.log2(found[0] / found[2]) / 2 == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize(("name", "order"), [("anitescu_potra", 1), ("stewart_trinkle", 2), ("paoli_schatzman", 2)])
def test_orders_of_hinge_drift(name: str, order: int) -> None:
    found = []
    for h in (0.02, 0.01):
        made = scene("pendulum", step=h)
        found.append(max(np.abs(made.joints(now.q)[0]).max() for now in states(made, name)))
    assert np.log2(found[0] / found[1]) == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("name", BOUNCING)
@pytest.mark.parametrize("e", [0.7, 1.0])
def test_ball_restitution(name: str, e: float) -> None:
    """Apexes H e^(2k), to O(h): an impact that came after the gap had slowed the ball down would lose e altogether."""
    h = 0.004
    fall = np.sqrt(2 / G)
    made = scene("bouncing_ball", restitution=e, step=h, duration=fall * (1 + 2 * e + 2 * e**2))
    height = np.array([now.q[1] - 0.5 for now in states(made, name)])
    turns = np.flatnonzero((height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:])) + 1
    apexes = [y for y in height[turns] if y > 0.03]
    assert apexes == pytest.approx([e**2, e**4], abs=4 * h * np.sqrt(2 * G))


@pytest.mark.parametrize("number", range(1, 8))
@pytest.mark.parametrize("e", [0.0, 1.0])
def test_energy_balance_of_gaps(number: int, e: float) -> None:
    """On gaps energy rises by at most -b.r_n, which is the push out of overlaps; a gap that is left takes energy."""
    made = scene(f"example_{number}", restitution=e)
    first = energy = made.energy(made.q0, made.v0)
    for now in states(made, "stewart_trinkle", 120):
        before, energy = energy, made.energy(now.q, now.v)
        fed = sum(float(-step.problem.bias @ step.impulse[:, 0]) for step in now.solved)
        assert energy <= before + fed + 1e-9 * first


def test_force_scheme_fails_on_painleve_rod() -> None:
    made = scene("painleve_rod")
    with pytest.raises(NoSolution, match=r"no bounded force .* sliding at \(.*, at t = 0 s"):
        list(states(made, "acceleration"))
    for name in ("anitescu_potra", "stewart_trinkle", "moreau"):
        *_, first = states(made, name, 1)
        assert first.solved[-1].problem.contact_velocity(first.solved[-1].impulse) == pytest.approx(np.zeros((1, 2)), abs=1e-9)


@pytest.mark.parametrize(("friction", "spin"), [(0.2, 0.0), (0.5, -1.0), (1.2, 1.0), (1.3, 2.0)])
def test_forces_on_a_sliding_rod(friction: float, spin: float) -> None:
    """f_n = -K/p with K = l spin^2 sin - g, where p > 0; at any step, for a force does not depend on it."""
    for h in (1e-2, 1e-5):
        made = scene("painleve_rod", friction=friction, spin=spin, tip_velocity=-3.0, step=h)
        cos, sin = np.cos(made.q0[2]), np.sin(made.q0[2])
        p, K = 1 + 3 * cos**2 - 3 * friction * sin * cos, spin**2 * sin - G
        assert p > 0 > K
        *_, first = states(made, "acceleration", 1)
        assert first.solved[-1].impulse[0] / h == pytest.approx([-K / p, -friction * K / p], rel=1e-4)


def test_fast_rod_lifts_without_force() -> None:
    """p < 0 < K: forces have two solutions, open and closed; the scheme opens."""
    *_, first = states(scene("painleve_rod", spin=4.0, tip_velocity=-3.0), "acceleration", 1)
    assert first.solved[-1].problem.contacts == 0


def test_relaxation_gap_of_sliding_block() -> None:
    """With gaps it rides at h mu |v_t|, which vanishes with the step."""
    top = []
    for h in (0.02, 0.01):
        made = scene("incline", step=h, duration=0.4)
        for now in simulate(made, relaxation, SCHEMES["stewart_trinkle"]):
            near = made.contacts(now.q, 1.0)
            assert near.gap == pytest.approx(h * 0.3 * np.abs(near.tangent @ now.v), abs=1e-9)
        top.append(near.gap.max())
    assert top[0] / top[1] == pytest.approx(2, rel=0.01)
