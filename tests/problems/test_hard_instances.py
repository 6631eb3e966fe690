"""Instances at the edges of what methods solve: each has what it was made for."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.analysis.labels import labels, pointedness
from frictionbench.problems.analysis.thresholds import POINTED, gaps_only
from frictionbench.problems.instances import make_instance
from frictionbench.problems.instances.recorded_step import recorded_steps
from frictionbench.problems.residual import residual
from frictionbench.solvers import solve


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e6])
def test_islands_share_nothing_but_the_file(ratio) -> None:
    problem = make_instance("unlike_islands", islands=3, contacts=4, velocity_ratio=ratio)
    assert labels(problem).islands >= 3
    same = make_instance("unlike_islands", islands=3, contacts=4, velocity_ratio=1.0)
    share = problem.q.reshape(3, -1) / same.q.reshape(3, -1)
    assert np.allclose(share, np.array([ratio, np.sqrt(ratio), 1.0])[:, None])


def test_island_ratio() -> None:
    two = {"mass": np.eye(4), "normal": np.eye(4)[[1, 3]], "tangent": np.eye(4)[[0, 2]], "bias": np.zeros(2)}
    problem = FrictionProblem(**two, friction=np.ones(2), free_velocity=np.array([3.0, -4.0, 0.0, -1e-3]))
    assert _islands(problem) == (2, pytest.approx(4e3))
    assert _islands(problem.replace(free_velocity=np.array([3.0, -4.0, 0.0, 0.0]))) == (2, 1.0)


def test_islands_are_those_that_the_residual_is_judged_by() -> None:
    """Two bodies on a third that is 1e14 times as heavy are apart, though W is not zero between them."""
    normal = np.array([[1.0, 0.0, -1.0], [0.0, 1.0, -1.0]])
    problem = FrictionProblem(
        mass=np.diag([1.0, 1.0, 1e14]),
        normal=normal,
        tangent=np.zeros((2, 3)),
        friction=np.ones(2),
        free_velocity=np.array([-1.0, -1e-3, 0.0]),
        bias=np.zeros(2),
    )
    assert problem.W[0, 2] > 0
    assert _islands(problem) == (2, pytest.approx(1e3))


def _islands(problem: FrictionProblem) -> tuple[int, float]:
    found = labels(problem)
    return found.islands, found.island_ratio


@pytest.mark.parametrize("tilt", [0.05, 1.5])
def test_a_slot_jams_where_the_cones_of_its_two_contacts_overlap(tilt) -> None:
    assert pointedness(make_instance("slots", points=1, tilt=tilt, excess=-1e-2)) <= POINTED
    assert pointedness(make_instance("slots", points=1, tilt=tilt, excess=1e-2)) == pytest.approx(2)


def test_the_normals_of_a_slot_are_opposite_but_for_its_tilt() -> None:
    problem = make_instance("slots", points=3, tilt=0.2)
    first, second = problem.normal.toarray()[:3], problem.normal.toarray()[3:]
    side = problem.tangent.toarray()[:3]
    assert np.allclose(second, np.sin(0.2) * side - np.cos(0.2) * first)


def test_a_local_graph_touches_near_bodies_only() -> None:
    problem = make_instance("local_graph", bodies=60)
    assert problem.contacts == 96
    touched = np.abs(problem.normal.toarray().reshape(96, 60, 3)[:, :, :2]).sum(axis=2) > 0
    assert (touched.sum(axis=1) == 2).all()
    together = np.tile([0.3, -0.5, 0.0], 60)
    assert np.allclose(problem.jacobian @ together, 0)
    assert residual(problem, solve(problem, "interior_point").impulse) <= 1e-8


def test_the_contacts_of_a_random_graph_are_between_two_bodies_each_at_its_own_arm() -> None:
    problem = make_instance("random_graph", bodies=60)
    assert problem.contacts == 96
    rows = problem.normal.toarray().reshape(96, 60, 3)
    touched = np.abs(rows[:, :, :2]).sum(axis=2) > 0
    assert (touched.sum(axis=1) == 2).all()
    assert np.allclose(problem.jacobian @ np.tile([0.3, -0.5, 0.0], 60), 0)
    arms = rows[:, :, 2][touched].reshape(96, 2)
    assert np.abs(arms.sum(axis=1)).min() > 1e-6
    assert residual(problem, solve(problem, "interior_point").impulse) <= 1e-8


@pytest.mark.parametrize("case", recorded_steps())
def test_recorded_steps_have_a_solution(case) -> None:
    problem = make_instance("recorded_step", case=case)
    assert gaps_only(problem) or problem.contacts <= 13  # where theory does not tell, a solver does
    if problem.contacts <= 13:
        assert residual(problem, solve(problem, "hybrid").impulse) <= 1e-8


def test_an_unknown_step_is_refused() -> None:
    with pytest.raises(InputError, match="case: unknown step 'other'; known are"):
        make_instance("recorded_step", case="other")
