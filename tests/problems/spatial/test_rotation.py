"""Rotations by quaternions, and the free rotation of a body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frictionbench.problems.scene import Scene
from frictionbench.problems.schemes import SCHEMES
from frictionbench.problems.simulate import simulate
from frictionbench.problems.spatial import rotation
from frictionbench.problems.spatial.bodies import solid_box


def test_matrices_and_turns_are_those_of_scipy() -> None:
    random = np.random.default_rng(0)
    turns, way = Rotation.random(20, random), random.standard_normal((20, 3))
    way[0] = 0
    quaternions = turns.as_quat(scalar_first=True)
    assert rotation.matrices(quaternions) == pytest.approx(turns.as_matrix())
    after = (turns * Rotation.from_rotvec(way)).as_matrix()
    assert rotation.matrices(rotation.turned(quaternions, way)) == pytest.approx(after)


def spinning(step: float, scheme: str) -> tuple[Scene, list[np.ndarray], list[np.ndarray]]:
    """A box thrown with a spin about no axis of its, without gravity, for a second."""
    box = solid_box((0.1, 0.2, 0.4))
    v0 = np.array([1.0, 0, 0, 3.0, 2.0, 1.0])
    made = Scene(bodies=(box,), q0=np.eye(7)[3], v0=v0, friction=0.0, gravity=(0.0, 0.0, 0.0), step=step, duration=1.0)
    taken = list(simulate(made, lambda problem: np.zeros((problem.contacts, 3)), SCHEMES[scheme]))
    return made, [step.q for step in taken], [step.v for step in taken]


def momentum(made: Scene, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The angular momentum (3,) in the world's frame."""
    return rotation.matrices(q[None, 3:])[0] @ (made.weights[3:] * v[3:])


@pytest.mark.parametrize("scheme", [name for name, scheme in SCHEMES.items() if not scheme.events])
def test_free_rotation_conserves_energy_and_angular_momentum(scheme: str) -> None:
    """Energy and the momentum's size to round-off, its direction to the scheme's order: two of Moreau's midpoint rule."""
    turned = []
    for step in (0.02, 0.01, 0.005):
        made, q, v = spinning(step, scheme)
        assert [made.energy(*state) for state in zip(q, v, strict=True)] == pytest.approx([made.energy(q[0], v[0])] * len(q))
        assert [np.linalg.norm(quaternion[3:]) for quaternion in q] == pytest.approx([1] * len(q), abs=1e-15)
        L = [momentum(made, *state) for state in zip(q, v, strict=True)]
        assert [np.linalg.norm(each) for each in L] == pytest.approx([np.linalg.norm(L[0])] * len(L))
        assert abs(v[-1][3:] - v[0][3:]).max() > 0.1  # it tumbles
        turned.append(np.linalg.norm(L[-1] - L[0]) / np.linalg.norm(L[0]))
    order = max(2 if scheme == "moreau" else 1, round(np.log2(turned[1] / turned[2])))  # a contributor's may be higher
    assert turned[0] / turned[1] == pytest.approx(2**order, rel=0.2)
    assert turned[1] / turned[2] == pytest.approx(2**order, rel=0.1)
