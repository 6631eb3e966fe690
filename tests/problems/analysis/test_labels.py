"""Labels of problems whose properties are known."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem
from frictionbench.problems.analysis.labels import labels, pointedness
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.random_bodies import random_problem
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.scene import Scene
from frictionbench.problems.subproblems import side_by_side
from tests.helpers.friction_problems import block, contacts_of, known_by_W


def jam(friction: float) -> FrictionProblem:
    walls = (half_plane((-0.5, 0), -np.pi / 2), half_plane((0.5, 0), np.pi / 2))
    return Scene(bodies=(rigid_box(1, 1),), obstacles=walls, q0=np.zeros(3), friction=friction).problem()


@pytest.mark.parametrize("blocks", [2, 10, 60])
@pytest.mark.parametrize("mass_ratio", [1.0, 1e6])
def test_stack_velocity_rank(blocks: int, mass_ratio: float) -> None:
    """4 rows per block and 3 freedoms, all of which the contacts move."""
    found = labels(scene("stack", blocks=blocks, mass_ratio=mass_ratio).problem())
    assert found["rank"] == 3 * blocks
    assert found["mass_ratio"] >= mass_ratio ** (1 - 2 / blocks)


def test_condition_against_numpy() -> None:
    problem = random_problem(4, contacts=4, bodies=4)
    found = labels(problem)
    assert found["rank"] == 8
    assert found["condition"] == pytest.approx(np.linalg.cond(problem.W.toarray()))


def test_large_problems_skip_the_dense_labels() -> None:
    found = labels(scene("stack", blocks=200).problem())
    assert found["rank"] is None
    assert found["condition"] is None
    assert found["pointedness"] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.3, 2.0])
def test_a_jam_is_not_pointed(friction: float) -> None:
    assert pointedness(jam(friction)) == pytest.approx(4)


def test_joint_momentum() -> None:
    """A contact on a body that a joint holds in place exchanges impulses with the joint."""
    assert pointedness(block()) == 0
    assert pointedness(block(joints=np.eye(2))) == pytest.approx(1)


def test_spatial_pointedness() -> None:
    eye = np.eye(3)
    normal, tangent = np.vstack([eye[2], -eye[2]]), np.vstack([eye[:2], eye[:2]])
    squeezed = contacts_of(normal, tangent, 0.1, np.zeros(3))
    assert pointedness(squeezed) == pytest.approx(2)
    assert labels(squeezed)["size"] == 20


def test_trivial_problems() -> None:
    assert labels(scene("long_bar").problem())["trivial"] == "no contact"
    assert labels(scene("stack", blocks=2, friction=0).problem())["trivial"] == "no friction"
    assert labels(scene("stack", blocks=2).problem().replace(bias=np.ones(4)))["trivial"] == "no impulse"
    assert labels(scene("stack", blocks=2).problem())["trivial"] == ""
    assert labels(scene("long_bar").problem())["rank"] == 0


def test_a_problem_of_several_answers_is_not_trivial_because_one_of_them_is_nothing():
    """The jam's r = 0 is one answer of a continuum; with gaps at the walls it is the only one."""
    assert labels(jam(0.5))["trivial"] == ""
    assert labels(jam(0.5).replace(bias=np.full(len(jam(0.5).bias), 0.1)))["trivial"] == "no impulse"


def test_the_rank_does_not_depend_on_units_or_masses():
    """Rows of bodies of unlike masses are as independent as others, and what a joint locks leaves no rank by rounding."""
    for ratio in (1.0, 1e6, 1e12):
        assert labels(scene("stack", blocks=4, mass_ratio=ratio).problem())["rank"] == 12
    assert labels(side_by_side(block(mass=1.0), block(mass=1e14)))["rank"] == 4
    random = np.random.default_rng(0)
    links = random.normal(size=(5, 6)) * 10.0 ** random.uniform(-4, 4, (5, 1))
    mass, (N, T) = np.diag(10.0 ** random.uniform(-6, 6, 6)), random.normal(size=(2, 3, 6))
    locked = contacts_of(N, T, 0.5, np.ones(6), mass=mass, joints=links)
    found = labels(locked)
    assert found["rank"] == 1  # five of six velocities are locked
    assert found["condition"] == pytest.approx(1)


def test_rows_of_joints_are_counted() -> None:
    """A contact, a frictionless contact with its tangents, a limit, dry friction, and a locked contact with friction."""
    N, T = np.zeros((5, 3)), np.zeros((10, 3))
    N[[0, 1, 2, 4], 2] = T[[0, 2, 6, 8], 0] = 1.0
    problem = contacts_of(N, T, [0.5, 0, 0, 0, 0.3], [1.0, 0, -1], bias=[0, 0, 0, 1, 0], friction_bias=[0, 0, 0, 0.1, 0])
    for form in (problem, known_by_W(problem)):
        assert (labels(form)["limits"], labels(form)["dry_friction"]) == (1, 1)
