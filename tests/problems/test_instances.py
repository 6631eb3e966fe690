"""Single-step instances: mechanical consistency, determinism and validation of parameters."""

import numpy as np
import pytest

from frictionbench.problems import FrictionProblem, InputError
from frictionbench.problems.instances import instances, make_instance
from frictionbench.problems.reduce import keep_contacts
from frictionbench.problems.residual import residual
from frictionbench.solvers import solve

SPATIAL = ("cubes", "packed_spheres", "random_bodies", "sphere_pyramid")
SMALL = {"packed_spheres": {"spheres": 12}, "sphere_pyramid": {"levels": 3}, "cubes": {"boxes": 3}}


@pytest.mark.parametrize("name", SPATIAL)
def test_rigid_translation(name) -> None:
    """A translation of all of them: no contact between two of them feels it, and one with the ground feels it all."""
    problem = make_instance(name, **SMALL.get(name, {}))
    together = np.tile([0.3, -0.5, 0.7, 0, 0, 0], len(problem.free_velocity) // 6)
    u = (problem.jacobian @ together).reshape(-1, 3)
    grounded = np.linalg.norm(u, axis=1) > 1e-9
    assert np.allclose(np.linalg.norm(u[grounded], axis=1), np.linalg.norm([0.3, -0.5, 0.7]))
    on_two = np.abs(problem.normal).sum(axis=1) > 0
    assert on_two.all()
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


def test_spatial_subproblems() -> None:
    problem = make_instance("cubes", boxes=3, push=1.0)
    known = FrictionProblem.from_delassus(problem.W, problem.q, problem.friction, 3)
    part, known_part = (keep_contacts(one, [4, 5, 6]) for one in (problem, known))
    assert len(part.free_velocity) == 12  # the two bodies that touch there
    assert np.array_equal(part.W.toarray(), known_part.W.toarray())
    assert np.array_equal(part.q, known_part.q)
    assert np.array_equal(part.q, problem.q[12:21])


@pytest.mark.parametrize(
    ("name", "parameters", "field"),
    [
        ("nonesuch", {}, "instance"),
        ("cubes", {"spheres": 3}, "spheres"),
        ("cubes", {"boxes": 0}, "boxes"),
        ("cubes", {"friction": -1}, "friction"),
        ("cubes", {"mass_ratio": 0}, "mass_ratio"),
        ("packed_spheres", {"fraction": 0.9}, "fraction"),
        ("packed_spheres", {"spheres": 2.5}, "spheres"),
        ("random_bodies", {"mass_ratio": 0.5}, "mass_ratio"),
        ("sphere_pyramid", {"noise": "much"}, "noise"),
        ("random", {"contacts": 0}, "contacts"),
    ],
)
def test_bad_parameter(name, parameters, field) -> None:
    with pytest.raises(InputError, match=rf"^{field}: "):
        make_instance(name, **parameters)
