"""Contacts of spheres and boxes in space: gaps, points, ties, and rows that are the gaps' gradients."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from frictionbench.problems import InputError
from frictionbench.problems.planar.bodies import half_plane, rigid_box
from frictionbench.problems.scene import Scene
from frictionbench.problems.spatial.bodies import Cuboid, HalfSpace, Solid, SpatialGeometry, Sphere, solid_box, solid_sphere
from frictionbench.problems.spatial.collision import SpatialContacts, find_spatial_contacts
from frictionbench.problems.spatial.rotation import matrices

GROUND = HalfSpace(np.array([0.0, 0, 1]))


def pose(*place: float, turn: Rotation | None = None) -> list[float]:
    return [*place, *(turn or Rotation.identity()).as_quat(scalar_first=True)]


def near(bodies: list[Solid], obstacles: list[HalfSpace], q: list[list[float]], margin: float = 0.1) -> SpatialContacts:
    return find_spatial_contacts(SpatialGeometry(bodies, obstacles), np.ravel(q), margin)


def check_rows(bodies: list[Solid], obstacles: list[HalfSpace], q: list[list[float]]) -> None:
    """The normal rows are the gap's gradient, and all rows the relative velocity of the two bodies' points."""
    geometry, at = SpatialGeometry(bodies, obstacles), np.ravel(q)
    found = find_spatial_contacts(geometry, at, 0.1)
    assert len(found)
    for k, e in enumerate(np.eye(found.velocities)):
        slopes = []
        for eps in (1e-8, -1e-8):
            moved = find_spatial_contacts(geometry, geometry.moved(at, eps * e), 0.2)
            at_feature = dict(zip(map(tuple, moved.feature.tolist()), moved.gap, strict=True))
            slopes.append([at_feature[tuple(feature)] / 2e-8 for feature in found.feature.tolist()])
        assert found.normal.toarray()[:, k] == pytest.approx(np.subtract(*slopes), abs=3e-6)
    v = np.random.default_rng(0).standard_normal((len(bodies), 6))
    speed = np.zeros((len(found), 3))
    for side, sign in ((0, 1), (1, -1)):
        for i, body in enumerate(found.bodies[:, side]):
            if body >= 0:
                spin = matrices(np.array(q)[:, 3:])[body] @ v[body, 3:]
                speed[i] += sign * (v[body, :3] + np.cross(spin, found.point[i] - q[body][:3]))
    assert found.normal @ v.ravel() == pytest.approx((found.direction * speed).sum(axis=1))
    tangential = (found.tangent @ v.ravel()).reshape(-1, 2)
    sliding = speed - (found.direction * speed).sum(axis=1)[:, None] * found.direction
    assert np.linalg.norm(tangential, axis=1) == pytest.approx(np.linalg.norm(sliding, axis=1))


TILTED = Rotation.from_rotvec([0.1, 0.05, 0.4])


@pytest.mark.parametrize(
    ("bodies", "obstacles", "q"),
    [
        ([solid_sphere(0.5)], [GROUND], [pose(1, 2, 0.55, turn=TILTED)]),
        ([solid_sphere(0.5), solid_sphere(0.3)], [], [pose(0, 0, 0, turn=TILTED), pose(0.5, 0.4, 0.5)]),
        ([solid_box((0.1, 0.2, 0.3))], [HalfSpace(np.array([0.6, 0, 0.8]), -0.3)], [pose(0, 0.1, -0.05, turn=TILTED)]),
        ([solid_box((0.1, 0.2, 0.3)), solid_box((0.3, 0.3, 0.1))], [], [pose(0.05, 0.02, 0.42, turn=TILTED), pose(0, 0, 0)]),
        ([solid_box((0.3, 0.3, 0.1)), solid_box((0.2, 0.2, 0.2))], [], [pose(0, 0, 0), pose(0.05, 0.25, 0.31)]),
    ],
)
def test_rows(bodies: list[Solid], obstacles: list[HalfSpace], q: list[list[float]]) -> None:
    check_rows(bodies, obstacles, q)


def test_boxes_stand_on_the_corners_of_their_common_face() -> None:
    cube, tall = solid_box((0.5, 0.5, 0.5)), solid_box((0.2, 0.3, 1.0))

    def corners(bodies: list[Solid], *q: list[float]) -> list[list[float]]:
        found = near(bodies, [], [*q])
        assert found.gap == pytest.approx(np.zeros(len(found)), abs=1e-12)
        assert found.direction == pytest.approx(np.tile([0, 0, -1.0 if q[0][2] < q[1][2] else 1.0], (len(found), 1)))
        assert len({*map(tuple, found.feature.tolist())}) == len(found)
        return sorted(np.round(found.point, 9).tolist())

    flush = corners([cube, cube], pose(0, 0, 0), pose(1e-9, 0, 1))
    assert flush == pytest.approx(np.array([(x, y, 0.5) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]), abs=1e-8)
    shifted = corners([cube, cube], pose(0.25, 0.25, 1), pose(0, 0, 0))  # two are corners, two are crossings of edges
    assert shifted == [[x, y, 0.5] for x in (-0.25, 0.5) for y in (-0.25, 0.5)]
    small = corners([cube, tall], pose(0, 0, 0), pose(0.1, 0, 1.5))
    assert small == pytest.approx(np.array([(0.1 + x, y, 0.5) for x in (-0.2, 0.2) for y in (-0.3, 0.3)]))
    crossed = corners([cube, cube], pose(0, 0, 0), pose(0, 0, 1, turn=Rotation.from_rotvec([0, 0, np.pi / 4])))
    assert len(crossed) == 8
    assert len(near([cube, cube], [], [pose(0, 0, 0), pose(0.8, 0.9, 1.2)])) == 0  # beside and above


def test_overlap_and_order() -> None:
    spheres = near([solid_sphere(0.5), solid_sphere(0.5)], [GROUND], [pose(0, 0, 0.49), pose(0, 0, 1.4)], 0.0)
    assert spheres.gap == pytest.approx([-0.01, -0.09])
    assert spheres.bodies.tolist() == [[0, -1], [0, 1]]
    assert spheres.direction.tolist() == [[0, 0, 1], [0, 0, -1]]
    assert len(near([solid_box((1, 1, 1))], [GROUND], [pose(0, 0, 1.5)], 0.0)) == 0
    made = Scene(bodies=(solid_box((1, 1, 1)),), obstacles=(GROUND,), q0=np.array(pose(0, 0, 0.9)), friction=0.5)
    assert made.deepest_overlap(made.q0) == pytest.approx(0.1)
    assert made.problem().dimension == 3
    assert made.gravity == (0, 0, -9.81)


def test_fields_are_checked() -> None:
    for name, make in (
        ("radius", lambda: Sphere(0.0)),
        ("half", lambda: Cuboid(np.array([1.0, 1.0]))),
        ("normal", lambda: HalfSpace(np.array([0.0, 0.0, 2.0]))),
        ("inertia", lambda: Solid(1.0, np.zeros(3), Sphere(1.0))),
        ("bodies", lambda: Scene(bodies=(solid_box((1, 1, 1)), rigid_box(1, 1)), q0=np.zeros(10), friction=0.0)),
        ("obstacles", lambda: Scene(bodies=(solid_box((1, 1, 1)),), obstacles=(half_plane(),), q0=np.eye(7)[3], friction=0.0)),
        ("q0", lambda: Scene(bodies=(solid_box((1, 1, 1)),), q0=np.zeros(7), friction=0.0)),
    ):
        with pytest.raises(InputError, match=f"^{name}: "):
            make()
