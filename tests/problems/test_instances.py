"""Instances: mechanical consistency, determinism, validation of parameters, and what each was made for."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.analysis.labels import labels, pointedness
from frictionbench.problems.analysis.thresholds import POINTED, gaps_only
from frictionbench.problems.catalogue import instances, make_instance, problem_of, scenes
from frictionbench.problems.instances.recorded_step import recorded_steps
from frictionbench.problems.residual import residual
from frictionbench.solvers import solve

SPATIAL = ("box_wall", "cubes", "packed_spheres", "random_bodies", "rod_chain", "sphere_pyramid")
SMALL = {
    "box_wall": {"rows": 3, "bricks": 3},
    "packed_spheres": {"spheres": 12},
    "sphere_pyramid": {"levels": 3},
    "cubes": {"boxes": 3},
}


@pytest.mark.parametrize("name", SPATIAL)
def test_rigid_translation(name) -> None:
    """A translation of all of them: no contact between two of them feels it, and one with the ground feels it all."""
    problem = make_instance(name, **SMALL.get(name, {}))
    together = np.tile([0.3, -0.5, 0.7, 0, 0, 0], len(problem.free_velocity) // 6)
    u = (problem.jacobian @ together).reshape(-1, 3)
    grounded = np.linalg.norm(u, axis=1) > 1e-9
    assert np.allclose(np.linalg.norm(u[grounded], axis=1), np.linalg.norm([0.3, -0.5, 0.7]))
    assert (np.abs(problem.normal).sum(axis=1) > 0).all()
    assert grounded.any() == (name != "random_bodies")


@pytest.mark.parametrize("name", SPATIAL)
def test_contact_frames_are_orthonormal(name) -> None:
    problem = make_instance(name, **SMALL.get(name, {}))
    J = problem.jacobian.toarray().reshape(problem.contacts, 3, -1, 6)
    first = np.argmax(np.abs(J[:, 0, :, :3]).sum(axis=2), axis=1)
    frame = J[np.arange(len(J)), :, first, :3]
    assert np.allclose(frame @ frame.transpose(0, 2, 1), np.eye(3), atol=2e-3)  # a pyramid's normals are askew by 1e-3


def test_a_stack_of_cubes_carries_its_weight() -> None:
    problem = make_instance("cubes", boxes=4, push=0.0, mass_ratio=8.0)
    mass = problem.mass.diagonal()[::6]
    assert np.allclose(mass, [1, 2, 4, 8])
    impulse = solve(problem, "interior_point", tol=1e-12).impulse
    carried = impulse[:, 0].reshape(4, 4).sum(axis=1)
    assert np.allclose(carried, 9.81 * 0.01 * np.cumsum(mass[::-1])[::-1], rtol=1e-9)


@pytest.mark.parametrize("points", [4, 8])
def test_a_wall_of_boxes_carries_its_weight(points) -> None:
    problem = make_instance("box_wall", rows=3, bricks=3, points=points, noise=0.0, push=0.0)
    assert problem.contacts == (3 + 2 * 2 + 2 * 2) * points + (2 + 1 + 2) * 4
    impulse = solve(problem, "interior_point").impulse
    held = np.abs(problem.jacobian.toarray().reshape(problem.contacts, 3, 8, 6)[:, 0, :, :3]).sum(axis=2) > 1e-9
    grounded = held.sum(axis=1) == 1
    assert impulse[grounded, 0].sum() == pytest.approx(8 * 9.81 * 0.01, rel=2e-3)  # the normals are askew by 1e-3


@pytest.mark.parametrize("fraction", [0.35, 0.64])
def test_sphere_packing_gaps(fraction) -> None:
    problem = make_instance("packed_spheres", spheres=40, fraction=fraction)
    felt = np.abs(problem.normal.toarray().reshape(problem.contacts, 40, 6)[:, :, :3]).sum(axis=2) > 1e-9
    between = np.sum(felt.sum(axis=1) == 2)
    assert (between > 2 * 40) == (fraction > 0.6)  # random close: four and more neighbours a sphere
    assert residual(problem, solve(problem, "hybrid").impulse) <= 1e-8


def test_instances_are_deterministic() -> None:
    for name in instances():
        again = make_instance(name, **SMALL.get(name, {}))
        assert make_instance(name, **SMALL.get(name, {})).hash == again.hash
        if "seed" in instances()[name].parameters:
            assert make_instance(name, **SMALL.get(name, {}) | {"seed": 1}).hash != again.hash


def test_ball_joints_move_together() -> None:
    problem = make_instance("rod_chain", links=4, pull=0.3, whirl=2.0)
    spin = np.array([0.2, -0.4, 0.7])
    F = problem.joints.toarray()
    assert F.shape == (9, 24)
    # A motion of the whole: the joints are where rods meet, at +1/2 along one and -1/2 along the next.
    along = np.cumsum(np.random.default_rng([0, 4]).uniform(-1.2, 1.2, 4))
    e = np.column_stack([np.cos(along), np.sin(along), np.zeros(4)])
    centre = np.vstack([np.zeros(3), np.cumsum((e[:-1] + e[1:]) / 2, axis=0)])
    whole = np.hstack([np.array([0.1, 0.2, 0.3]) + np.cross(spin, centre), np.tile(spin, (4, 1))]).ravel()
    assert F @ whole == pytest.approx(np.zeros(9), abs=1e-14)
    assert np.linalg.matrix_rank(F) == 9
    answer = solve(problem, "interior_point", tol=1e-10)
    assert residual(problem, answer.impulse) <= 1e-10
    assert F @ problem.velocity(answer.impulse) == pytest.approx(np.zeros(9), abs=1e-10)


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e6])
def test_islands_share_nothing_but_the_file(ratio) -> None:
    problem = make_instance("unlike_islands", islands=3, contacts=4, velocity_ratio=ratio)
    assert labels(problem)["islands"] >= 3
    same = make_instance("unlike_islands", islands=3, contacts=4, velocity_ratio=1.0)
    share = problem.q.reshape(3, -1) / same.q.reshape(3, -1)
    assert np.allclose(share, np.array([ratio, np.sqrt(ratio), 1.0])[:, None])


def test_island_ratio() -> None:
    two = {"mass": np.eye(4), "normal": np.eye(4)[[1, 3]], "tangent": np.eye(4)[[0, 2]], "bias": np.zeros(2)}
    problem = FrictionProblem(**two, friction=np.ones(2), free_velocity=np.array([3.0, -4.0, 0.0, -1e-3]))
    assert _islands(problem) == (2, pytest.approx(4e3))
    assert _islands(problem.replace(free_velocity=np.array([3.0, -4.0, 0.0, 0.0]))) == (2, 1.0)


def _islands(problem: FrictionProblem) -> tuple[int, float]:
    found = labels(problem)
    return found["islands"], found["island_ratio"]


@pytest.mark.parametrize("tilt", [0.05, 1.5])
def test_a_slot_jams_where_the_cones_of_its_two_contacts_overlap(tilt) -> None:
    assert pointedness(make_instance("slots", points=1, tilt=tilt, excess=-1e-2)) <= POINTED
    assert pointedness(make_instance("slots", points=1, tilt=tilt, excess=1e-2)) == pytest.approx(2)


@pytest.mark.parametrize("name", ["local_graph", "random_graph"])
def test_contacts_of_graphs_are_between_two_bodies(name) -> None:
    problem = make_instance(name, bodies=60)
    assert problem.contacts == 96
    rows = problem.normal.toarray().reshape(96, 60, 3)
    touched = np.abs(rows[:, :, :2]).sum(axis=2) > 0
    assert (touched.sum(axis=1) == 2).all()
    assert np.allclose(problem.jacobian @ np.tile([0.3, -0.5, 0.0], 60), 0)
    if name == "random_graph":  # each at its own arm
        assert np.abs(rows[:, :, 2][touched].reshape(96, 2).sum(axis=1)).min() > 1e-6
    assert residual(problem, solve(problem, "interior_point").impulse) <= 1e-8


@pytest.mark.parametrize("case", recorded_steps())
def test_recorded_steps_have_a_solution(case) -> None:
    problem = make_instance("recorded_step", case=case)
    assert gaps_only(problem) or problem.contacts <= 13  # where theory does not tell, a solver does
    if problem.contacts <= 13:
        assert residual(problem, solve(problem, "hybrid").impulse) <= 1e-8


@pytest.mark.parametrize("wrong", ["x", np.nan, [1], {}], ids=str)
def test_every_parameter_of_scenes_and_instances_is_checked(wrong) -> None:
    for name, found in {**scenes(), **instances()}.items():
        for parameter in found.parameters:
            with pytest.raises(InputError, match=f"^{parameter}: "):
                problem_of(name, **{parameter: wrong})
