"""Joint equations that no velocity satisfies are refused; redundant ones that agree are not, whatever their rank and units."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.recorded import read
from frictionbench.problems.residual import residual
from frictionbench.problems.scenes import scene
from frictionbench.solvers import solve

FIELDS = {
    "mass": np.diag([2.0, 2.0, 0.1]),
    "normal": [[0.0, 1.0, -0.5], [0.0, 1.0, 0.5]],
    "tangent": [[1.0, 0.0, 0.5], [1.0, 0.0, 0.5]],
    "friction": [0.5, 0.5],
    "free_velocity": [1.0, -0.1, 0.0],
    "bias": [0.0, 0.0],
}
CONTRADICTIONS = {
    "a row twice": ([[1.0, 0.0, 0.0]] * 2, [-0.5, 0.5]),
    "a row twice, in other units": ([[1.0, 0.0, 0.0], [1e6, 0.0, 0.0]], [0.0, 50.0]),
    "three of rank two": ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], [0.0, 0.0, 1e-3]),
    "a row of zeros": ([[0.0, 0.0, 0.0]], [1e-3]),
    "beside rows that agree": ([[0.0, 0.0, 1e3], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]], [1e3, 1e-3, -1e-3]),
}


@pytest.mark.parametrize("kind", CONTRADICTIONS)
def test_contradictions_are_refused(kind) -> None:
    joints, bias = CONTRADICTIONS[kind]
    with pytest.raises(InputError, match=r"^joint_bias: the joint equations contradict each other: rows"):
        FrictionProblem(**FIELDS, joints=joints, joint_bias=bias)


def test_contradiction_in_a_file_names_its_array(tmp_path) -> None:
    letters = {"mass": "M", "normal": "N", "tangent": "T", "friction": "mu", "free_velocity": "v", "bias": "b"}
    arrays = {letters[field]: value for field, value in FIELDS.items()}
    np.savez(tmp_path / "p.npz", **arrays, F=[[1.0, 0.0, 0.0]] * 2, bF=[-0.5, 0.5])
    with pytest.raises(InputError, match=r"p\.npz: bF: the joint equations"):
        read(tmp_path / "p.npz")


@pytest.mark.parametrize("seed", range(8))
def test_redundant_equations_that_agree(seed) -> None:
    """Of all ranks, with rows in units from 1e-6 to 1e6 and masses from 1e-4 to 1e4."""
    random = np.random.default_rng(seed)
    nv, rank = 12, int(random.integers(1, 9))
    F = (
        random.standard_normal((4 * rank, rank))
        @ random.standard_normal((rank, nv))
        * 10 ** random.uniform(-6, 6, (4 * rank, 1))
    )
    moving = random.standard_normal(nv)
    given = {"mass": np.diag(10 ** random.uniform(-4, 4, nv)), "free_velocity": random.standard_normal(nv)}
    normal, tangent = random.standard_normal((2, 3, nv))
    problem = FrictionProblem(
        **given, normal=normal, tangent=tangent, friction=[0.5] * 3, bias=[0.0] * 3, joints=F, joint_bias=-F @ moving
    )
    v = problem.velocity(np.zeros((3, 2)))
    assert np.all(np.abs(F @ (v - moving)) <= 1e-9 * (np.abs(F) @ (np.abs(v) + np.abs(moving))))
    with pytest.raises(InputError, match=r"^joint_bias: "):
        problem.replace(joint_bias=-F @ moving + np.abs(F) @ np.abs(moving) * random.standard_normal(len(F)) * 1e-3)


def test_rounding_in_a_joint_at_rest_is_no_contradiction() -> None:
    joints = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]
    problem = FrictionProblem(**FIELDS, joints=joints, joint_bias=[-1.0, 1e-15, -1e-15])
    assert residual(problem, solve(problem, "lemke", tol=1e-10).impulse) <= 1e-10


@pytest.mark.parametrize("again", [False, True])
@pytest.mark.parametrize("angle", [1e-3, 1e-4])
def test_rows_that_are_nearly_parallel_are_independent(angle: float, again: bool) -> None:
    """Their velocity is large, but there is one; again: beside a row that is there twice."""
    joints = np.array([[1.0, 0.0, 0.0], [np.cos(angle), np.sin(angle), 0.0], [1.0, 0.0, 0.0]][: 3 if again else 2])
    bias = np.array([0.3, 0.2, 0.3][: len(joints)])
    v = FrictionProblem(**FIELDS, joints=joints, joint_bias=bias).velocity(np.zeros((2, 2)))
    assert np.abs(joints @ v + bias).max() < 1e-4
    assert v[1] == pytest.approx(0.1 / angle, rel=1e-3)


@pytest.mark.parametrize("angle", [1e-5, 1e-6])
@pytest.mark.parametrize("bias", [(0.3, 0.2), (0.0, 0.0)])
def test_rows_that_rounding_leaves_unsatisfied_are_refused(angle, bias) -> None:
    """The inverse of their products has no digits that could satisfy them, and no residual in contact velocities would tell."""
    joints = [[1.0, 0.0, 0.0], [np.cos(angle), np.sin(angle), 0.0]]
    refused, fields = "", FIELDS | {"free_velocity": [1.0, 2.0, 3.0]}
    try:
        problem = FrictionProblem(**fields, joints=joints, joint_bias=bias)
    except InputError as error:
        refused = str(error)
    if refused:
        assert refused.startswith("joints: rows are so nearly dependent")
    else:
        v = problem.velocity(np.zeros((2, 2)))
        assert np.abs(problem.joints @ v + problem.joint_bias).max() <= 1e-8 * max(np.abs(v).max(), 3.0)


@pytest.mark.parametrize("speed", [1e8, 1e12])
def test_no_speed_hides_a_contradiction(speed: float) -> None:
    with pytest.raises(InputError, match=r"^joint_bias: the joint equations contradict each other: rows 0, 1 are missed by"):
        FrictionProblem(**FIELDS | {"free_velocity": [speed, speed, 0.0]}, joints=[[1.0, 0.0, 0.0]] * 2, joint_bias=[-0.5, 0.5])


def test_rounding_of_joints_that_move_fast_is_no_contradiction() -> None:
    joints, moving = np.array([[0.1, 0.7, 0.3]] * 2), np.array([1e9, 1e9, 1e9])
    bias = -joints @ moving * [1.0, 1.0 + 1e-15]
    assert FrictionProblem(**FIELDS | {"free_velocity": moving}, joints=joints, joint_bias=bias).contacts == 2


def test_joints_of_a_scene_that_have_drifted() -> None:
    problem = scene("slider_crank").problem()
    assert problem.replace(joint_bias=np.full(6, 1e-3)).velocity(np.zeros((problem.contacts, 2))).shape == (9,)
