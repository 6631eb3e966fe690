"""Contact finding against brute force, finite differences, ties and moved frames."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from frictionbench.problems import InputError
from frictionbench.problems.planar.bodies import (
    Body,
    Geometry,
    Shape,
    box,
    half_plane,
    hollow,
    rigid_box,
    rigid_disc,
    rigid_rod,
    vertical_wall,
)
from frictionbench.problems.planar.collision import find_contacts


def random_polygon(random: np.random.Generator) -> Body:
    points = random.standard_normal((8, 2))
    return Body(1.0, 0.4, (Shape(points[ConvexHull(points).vertices]),))


def outline(body: Body, q: np.ndarray) -> np.ndarray:
    c, s = np.cos(q[2]), np.sin(q[2])
    return body.shapes[0].corners @ np.array([[c, s], [-s, c]]) + q[:2]


def signed_distance(a: np.ndarray, b: np.ndarray) -> tuple[float, bool]:
    """Distance of two convex polygons, minus the least translation that separates them where they overlap, from the hull of
    their Minkowski difference; and whether the nearest point lies inside one of its edges."""
    difference = (a[:, None] - b[None]).reshape(-1, 2)
    hull = ConvexHull(difference)
    inside = float(np.max(hull.equations[:, 2]))
    if inside <= 0:
        return inside, True
    corners = difference[hull.vertices]
    best, interior = np.inf, False
    for start, end in pairwise([*corners, corners[0]]):
        s = -start @ (end - start) / ((end - start) @ (end - start))
        distance = float(np.linalg.norm(start + np.clip(s, 0, 1) * (end - start)))
        if distance < best:
            best, interior = distance, bool(0.01 < s < 0.99)
    return best, interior


def scattered(seed: int, reach: float = 2.5) -> tuple[list[Body], Geometry, np.ndarray]:
    random = np.random.default_rng(seed)
    bodies = [random_polygon(random), random_polygon(random)]
    q = np.array([0.0, 0.0, random.uniform(0, 6), *(random.uniform(-reach, reach, 2)), random.uniform(0, 6)])
    return bodies, Geometry(bodies, []), q


@pytest.mark.parametrize("seed", range(100))
def test_smallest_gap_is_the_polygons_distance(seed: int) -> None:
    bodies, geometry, q = scattered(seed)
    distance, interior = signed_distance(outline(bodies[0], q[:3]), outline(bodies[1], q[3:]))
    contacts = find_contacts(geometry, q, margin=10.0)
    if interior:
        assert contacts.gap.min() == pytest.approx(distance, abs=1e-9)
    else:  # corner to corner: apart, and no contact says otherwise
        assert distance > 0
        assert (contacts.gap > 0).all()
    assert len(contacts) <= 2


def check_rows(geometry: Geometry, q: np.ndarray, margin: float = 0.5) -> None:
    """The normal rows are the gap's gradient, and the tangent rows the sliding of the two bodies' points."""
    contacts = find_contacts(geometry, q, margin)
    assert len(contacts)
    normal = contacts.normal.toarray()
    for k, e in enumerate(np.eye(len(q))):
        ahead, behind = (find_contacts(geometry, q + eps * e, margin + 0.1) for eps in (1e-6, -1e-6))
        for i, feature in enumerate(contacts.feature.tolist()):
            slope = (
                ahead.gap[ahead.feature.tolist().index(feature)] - behind.gap[behind.feature.tolist().index(feature)]
            ) / 2e-6
            assert normal[i, k] == pytest.approx(slope, abs=1e-7)
    v = np.random.default_rng(0).standard_normal(len(q))
    for i in range(len(contacts)):
        speed = np.zeros(2)
        for body, sign in zip(contacts.bodies[i], (1, -1), strict=True):
            if body >= 0:
                arm = contacts.point[i] - q[3 * body : 3 * body + 2]
                speed += sign * (v[3 * body : 3 * body + 2] + v[3 * body + 2] * np.array([-arm[1], arm[0]]))
        n = contacts.direction[i]
        assert (contacts.normal @ v)[i] == pytest.approx(n @ speed)
        assert (contacts.tangent @ v)[i] == pytest.approx(np.array([n[1], -n[0]]) @ speed)


@pytest.mark.parametrize("seed", [s for s in range(60) if len(find_contacts(*scattered(s, 1.5)[1:], 0.5))])
def test_rows_of_polygons(seed: int) -> None:
    _, geometry, q = scattered(seed, 1.5)
    check_rows(geometry, q)


@pytest.mark.parametrize(
    ("bodies", "obstacles", "q"),
    [
        ([rigid_disc(0.5), rigid_disc(0.3)], [], [0, 0, 0.3, 0.5, 0.6, 1]),
        ([rigid_disc(0.5), rigid_box(1, 2)], [], [0, 0, 0.3, 1.1, 0.2, 0.1]),  # against a face
        ([rigid_box(1, 2), rigid_disc(0.5)], [], [0, 0, 0.1, 0.8, 1.3, 1]),  # against a corner
        ([rigid_disc(0.5)], [half_plane((0, -0.6), 0.2)], [0, 0, 0.3]),
        ([rigid_rod(1.0)], [half_plane()], [0, 0.8, 1.0]),
        ([rigid_disc(0.5)], [hollow(2.0, (0.3, 0.1))], [1.1, -0.9, 0.3]),
        ([rigid_box(1, 2)], [vertical_wall(0.8, 1), vertical_wall(-0.8, -1)], [0.1, 0.0, 0.2]),
        ([rigid_rod(1.0)], [box(4, 1, (0, -0.5))], [0, 0.02, 0.01]),
        ([rigid_box(10, 0.4)], [box(1, 1, (x, -0.5)) for x in (-4, 0, 4)], [0.3, 0.21, 0.004]),
    ],
)
def test_rows_of_other_shapes(bodies: list[Body], obstacles: list[Shape], q: list[float]) -> None:
    check_rows(Geometry(bodies, obstacles), np.array(q, dtype=float))


def test_disc_gaps() -> None:
    face = find_contacts(Geometry([rigid_disc(0.5), rigid_box(1, 2)], []), np.array([1.25, 0.2, 0, 0, 0, 0]), 1.0)
    assert face.gap == pytest.approx([0.25])
    assert face.direction == pytest.approx(np.array([[1.0, 0.0]]))
    corner = find_contacts(Geometry([rigid_box(1, 2), rigid_disc(0.5)], []), np.array([0, 0, 0, 0.8, 1.4, 0]), 1.0)
    assert corner.gap == pytest.approx([0.0])
    assert corner.direction == pytest.approx(np.array([[-0.6, -0.8]]))
    within = find_contacts(Geometry([rigid_disc(0.5), rigid_box(4, 2)], []), np.array([0.1, 0.9, 0, 0, 0, 0]), 0.0)
    assert within.gap == pytest.approx([-0.6])
    discs = find_contacts(Geometry([rigid_disc(0.5), rigid_disc(0.5)], []), np.zeros(6), 0.0)
    assert discs.gap == pytest.approx([-1.0])
    assert np.isfinite(discs.normal.toarray()).all()


def test_gaps_in_a_hollow_and_between_walls() -> None:
    bowl = find_contacts(Geometry([rigid_disc(0.5)], [hollow(2.0)]), np.array([0.6, -0.8, 0]), 1.0)
    assert bowl.gap == pytest.approx([0.5])
    assert bowl.direction == pytest.approx(np.array([[-0.6, 0.8]]))
    assert bowl.point == pytest.approx(np.array([[0.9, -1.2]]))
    walls = find_contacts(Geometry([rigid_disc(0.5)], [vertical_wall(-1, -1), vertical_wall(0.6, 1)]), np.zeros(3), 1.0)
    assert walls.gap == pytest.approx([0.5, 0.1])
    assert walls.direction == pytest.approx(np.array([[1, 0], [-1, 0]]), abs=1e-15)


def test_a_choice_of_contacts() -> None:
    contacts = find_contacts(Geometry([rigid_box(1, 1)], [half_plane()]), np.array([0, 0.5, 0.1]), 0.2)
    assert len(contacts) == 2
    lower = contacts.only(contacts.gap < 0)
    assert len(lower) == 1
    assert lower.normal.toarray() == pytest.approx(contacts.normal.toarray()[contacts.gap < 0])
    assert contacts.only(np.zeros(2, dtype=bool)).tangent.shape == (0, 3)


@pytest.mark.parametrize("turn", [0.0, 0.1, 0.5, np.pi / 4, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("place", [(0.0, 0.0), (0.1, 0.3), (1e3, -7.7)])
def test_ties_give_two_contacts_an_interface(turn: float, place: tuple[float, float]) -> None:
    """A flush 2 by 2 block of equal boxes on the ground: 4 interfaces and 2 on the ground, nothing across the diagonals."""
    c, s = np.cos(turn), np.sin(turn)
    centres = np.array([[-0.5, 0.5], [0.5, 0.5], [-0.5, 1.5], [0.5, 1.5]]) @ np.array([[c, s], [-s, c]]) + place
    q = np.column_stack([centres, np.full(4, turn)]).ravel()
    contacts = find_contacts(Geometry([rigid_box(1, 1)] * 4, [half_plane(place, turn)]), q, 1e-6)
    met = [tuple(pair) for pair in contacts.bodies.tolist()]
    assert met == [(0, 1)] * 2 + [(0, 2)] * 2 + [(0, -1)] * 2 + [(1, 3)] * 2 + [(1, -1)] * 2 + [(2, 3)] * 2
    assert abs(contacts.gap).max() < 1e-9
    upright = contacts.direction @ np.array([[c, -s], [s, c]])
    assert upright == pytest.approx(
        np.array([[-1, 0]] * 2 + [[0, -1]] * 2 + [[0, 1]] * 2 + [[0, -1]] * 2 + [[0, 1]] * 2 + [[-1, 0]] * 2)
    )


def test_sweep_agrees_with_all_pairs() -> None:
    """The sweep finds what the pairs one by one find."""
    random = np.random.default_rng(5)
    bodies = [random_polygon(random) for _ in range(25)] + [rigid_disc(0.4) for _ in range(5)]
    q = np.column_stack([random.uniform(-6, 6, (30, 2)), random.uniform(0, 6, 30)])
    together = find_contacts(Geometry(bodies, []), q.ravel(), 0.1)
    apart = [
        gap
        for i in range(30)
        for j in range(i + 1, 30)
        for gap in find_contacts(Geometry([bodies[i], bodies[j]], []), q[[i, j]].ravel(), 0.1).gap
    ]
    assert len(together) > 20
    assert together.gap == pytest.approx(apart, abs=1e-12)


@pytest.mark.parametrize(
    "corners", [[[0, 0], [0, 1], [1, 0]], [[0, 0], [1, 0], [0.2, 0.2], [0, 1]], [[0, 0], [1, np.nan], [0, 1]]]
)
def test_bad_corners_are_refused(corners: list[list[float]]) -> None:
    with pytest.raises(InputError, match=r"^corners: "):
        Shape(np.array(corners))
