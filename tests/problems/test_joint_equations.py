"""Joint equations of any rank and number, by a dense inverse or a banded one; those that no velocity satisfies are refused.

Redundant ones that agree are not, whatever their rank and units.
"""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError, mechanics
from frictionbench.problems.catalogue import scene
from frictionbench.problems.instances.rod_chain import rod_chain
from frictionbench.problems.residual import residual
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


def test_what_joints_at_rest_miss_by_less_than_the_rounding_of_the_free_velocity_is_accepted() -> None:
    """A closed chain that lies folded and falls: its links hardly move against each other, beside the velocity of the fall."""
    joints, slow = [[1.0, 0.0, 0.0], [np.cos(3e-7), np.sin(3e-7), 0.0]], [1e-11, 2e-11]
    fields = FIELDS | {"joints": joints, "joint_bias": [0.0, 0.0]}
    falling = FrictionProblem(**fields | {"free_velocity": [*slow, 1.0]})
    assert np.abs(falling.joints @ falling.velocity(np.zeros((2, 2)))).max() < 1e-16
    with pytest.raises(InputError, match="joints: rows are so nearly dependent"):
        FrictionProblem(**fields | {"free_velocity": [*slow, 0.0]})


def test_rounding_of_joints_that_move_fast_is_no_contradiction() -> None:
    joints, moving = np.array([[0.1, 0.7, 0.3]] * 2), np.array([1e9, 1e9, 1e9])
    bias = -joints @ moving * [1.0, 1.0 + 1e-15]
    assert FrictionProblem(**FIELDS | {"free_velocity": moving}, joints=joints, joint_bias=bias).contacts == 2


def _loops() -> FrictionProblem:
    """Two closed loops in space whose hinge equations hold twice and in other units, with a foot that the joints lock."""
    problem = rod_chain(links=6)
    F = np.vstack([problem.joints.toarray(), 1e3 * problem.joints.toarray()[:7], np.eye(36)[:6], np.eye(36)[2:5]])
    return problem.replace(joints=F, joint_bias=np.concatenate([np.zeros(22), 0.01 * np.ones(6), 0.01 * np.ones(3)]))


PROBLEMS = {
    "planar chain": lambda: scene("chain", links=40, ripple=1.0, fall=1.0, mass_ratio=1e4).problem(),
    "chain in space": lambda: rod_chain(links=12, mass_ratio=100.0),
    "redundant and locked": _loops,
}


def _both(name: str, monkeypatch: pytest.MonkeyPatch) -> list[FrictionProblem]:
    """The problem with a dense inverse of the joints' equations, and with a banded one."""
    made = []
    for few in (10_000, 0):
        monkeypatch.setattr(mechanics, "FEW_EQUATIONS", few)
        made.append(PROBLEMS[name]())
    return made


@pytest.mark.parametrize("name", PROBLEMS)
def test_both_inverses_agree(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    few, many = _both(name, monkeypatch)
    assert few.hash == many.hash
    r = np.random.default_rng(0).uniform(0.0, 1.0, (few.contacts, few.dimension))
    W = few.W.toarray()
    assert many.W.toarray() == pytest.approx(W, abs=1e-9 * np.abs(W).max())
    size = few.velocity_size(r).max()
    assert many.contact_velocity(r) == pytest.approx(few.contact_velocity(r), abs=1e-12 * size)
    assert many.scale == pytest.approx(few.scale, rel=1e-7)
    assert many.units == pytest.approx(few.units, rel=1e-9)


@pytest.mark.parametrize("name", PROBLEMS)
def test_size_of_terms_covers_the_velocity_of_the_joints(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The estimate of |X| from a few right sides stays within its number of equations of the exact sum."""
    few, many = _both(name, monkeypatch)
    r = np.random.default_rng(1).uniform(0.0, 1.0, (few.contacts, few.dimension))
    exact, estimate = few.velocity_size(r), many.velocity_size(r)
    assert np.all(estimate >= np.abs(many.contact_velocity(r)) - 1e-9)
    assert np.all(estimate <= 3 * exact)
    assert np.median(exact / estimate) <= np.sqrt(len(few.joint_bias))


def test_a_long_chain_needs_no_dense_matrix() -> None:
    """1500 links; the dense inverse took minutes."""
    problem = rod_chain(links=1500)
    assert residual(problem, solve(problem, "hybrid").impulse) <= 1e-8
    assert problem._held.factor.shape[1] < 20


def test_contradictions_among_many_are_named() -> None:
    problem = scene("chain", links=80).problem()
    F = np.vstack([problem.joints.toarray(), problem.joints.toarray()[100]])
    bias = np.zeros(len(F))
    bias[100] = 1e-3
    with pytest.raises(InputError, match=r"^joint_bias: the joint equations contradict each other: rows (100|158) "):
        problem.replace(joints=F, joint_bias=bias)
    bias[158] = 1e-3
    agreed = problem.replace(joints=F, joint_bias=bias)
    v = agreed.velocity(np.zeros((agreed.contacts, 2)))
    assert np.abs(F @ v + bias).max() <= 1e-12
