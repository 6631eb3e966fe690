"""Contacts of spheres and boxes in space, with half spaces and with each other.

A sphere touches a half space or another sphere at a point, and a box touches a half space with its corners. Two boxes have
contacts along the normal of the reference face, the one with the largest separation or least overlap. The opposite face of the
other box is clipped to the reference face, and each corner of the rest is a contact. Contacts between edges, and between
spheres and boxes, are not implemented, because no scene needs them.

The arms of both bodies end at the contact point. For half spaces, for spheres and for parallel faces, the gradient of the gap
is exactly the contact's normal row.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.planar.narrow_phase import TIE
from frictionbench.problems.rows import Rows, relative
from frictionbench.problems.spatial.bodies import Cuboid, SpatialGeometry, Sphere
from frictionbench.problems.spatial.rotation import frames, matrices

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])

Contact = tuple[float, Array, Array, tuple[int, int], tuple[int, int]]  # gap, point, normal, bodies, feature


class SpatialContacts(Contacts):
    """place: (nc, 6), the point and the unit normal. feature: (nc, 2), 64 times a body plus the number of its corner, and 6
    times the other body plus the number of its face, or a negative number for a half space."""

    @property
    def velocities(self) -> int:
        return 6 * (len(self.q) // 7)

    @property
    def tangents(self) -> Array:
        return frames(self.direction)[:, 1:]

    def _rows(self, along: Array) -> Rows:
        pose = self.q.reshape(-1, 7)
        arms, turns = self.point[:, None] - pose[self.bodies, :3], matrices(pose[:, 3:])[self.bodies]
        spins = np.cross(arms[:, None], along[:, :, None])
        return relative(self.bodies, along, np.einsum("cksa,csab->cksb", spins, turns))  # in the bodies' frames


def find_spatial_contacts(geometry: SpatialGeometry, q: Array, margin: float) -> SpatialContacts:
    """All contacts with gap <= margin (m) at the coordinates q (7 nb,)."""
    q = check.vector("q", q)
    centre, turn = geometry.centres(q), geometry.rotations(q)
    contacts: list[Contact] = []
    for i, body in enumerate(geometry.bodies):
        points = centre[i, None] if isinstance(body.shape, Sphere) else _Box(body.shape.half, centre[i], turn[i]).points
        for k, plane in enumerate(geometry.obstacles):
            shift = body.shape.radius if isinstance(body.shape, Sphere) else 0.0
            gaps = points @ plane.normal - plane.height - shift
            contacts += [
                (gaps[c], points[c] - shift * plane.normal, plane.normal, (i, -1), (64 * i + c, -1 - k))
                for c in np.flatnonzero(gaps <= margin).tolist()
            ]
    for i, j in combinations(range(len(geometry.bodies)), 2):
        one, other = geometry.bodies[i].shape, geometry.bodies[j].shape
        if np.linalg.norm(centre[i] - centre[j]) > one.reach + other.reach + margin:
            continue
        if isinstance(one, Sphere) and isinstance(other, Sphere):
            between = centre[i] - centre[j]
            distance = float(np.linalg.norm(between))
            normal = between / distance if distance > 0 else np.array([0.0, 0.0, 1.0])
            gap = distance - one.radius - other.radius
            if gap <= margin:
                contacts.append((gap, centre[i] - one.radius * normal, normal, (i, j), (64 * i, 6 * j)))
        elif isinstance(one, Cuboid) and isinstance(other, Cuboid):
            contacts += _boxes((i, j), (_Box(one.half, centre[i], turn[i]), _Box(other.half, centre[j], turn[j])), margin)
    return SpatialContacts(
        gap=np.array([gap for gap, *_ in contacts]),
        place=np.array([[*point, *normal] for _, point, normal, *_ in contacts]).reshape(-1, 6),
        bodies=np.array([bodies for *_, bodies, _ in contacts], dtype=np.int64).reshape(-1, 2),
        feature=np.array([feature for *_, feature in contacts], dtype=np.int64).reshape(-1, 2),
        q=q,
    )


class _Box(NamedTuple):
    half: Array
    centre: Array
    turn: Array

    @property
    def points(self) -> Array:
        """The corners (8, 3)."""
        return np.asarray(self.centre + (CORNERS * self.half) @ self.turn.T)

    def normal(self, face: int) -> Array:
        """The outward normal (3,) of face 2 a + s, in the negative or positive direction of axis a for s = 0 or 1."""
        return np.asarray((2 * (face % 2) - 1) * self.turn[:, face // 2])

    def heights(self, face: int, points: Array) -> Array:
        """The heights (n,) of points (n, 3) above a face."""
        return np.asarray((points - self.centre) @ self.normal(face) - self.half[face // 2])

    def rectangle(self, face: int) -> tuple[Array, Array]:
        """The unit vectors (2, 3) along a face's sides, and half their lengths (2,)."""
        axes = [axis for axis in range(3) if axis != face // 2]
        return self.turn[:, axes].T, self.half[axes]


def _boxes(bodies: tuple[int, int], boxes: tuple[_Box, _Box], margin: float) -> list[Contact]:
    """The contacts of two boxes: the corners of the opposite face, clipped to the reference face."""
    tie = TIE * float(boxes[0].half.max())
    reference, face, depth = 1, 0, -np.inf
    for side in (1, 0):  # a later candidate must be better by more than rounding
        for candidate in range(6):
            least = float(boxes[side].heights(candidate, boxes[1 - side].points).min())
            if least > depth + tie:
                reference, face, depth = side, candidate, least
    if depth > margin:
        return []
    below, above = boxes[reference], boxes[1 - reference]
    normal = below.normal(face)
    opposed = int(np.argmin([above.normal(other) @ normal for other in range(6)]))
    points, name = _clipped(above, opposed, below, face, tie)
    heights = below.heights(face, points)
    up = normal if reference == 1 else -normal  # towards the first body
    owner = 64 * bodies[1 - reference], 6 * bodies[reference] + face
    return [
        (heights[k], points[k], up, bodies, (owner[0] + name[k], owner[1])) for k in np.flatnonzero(heights <= margin).tolist()
    ]


def _clipped(above: _Box, opposed: int, below: _Box, face: int, tie: float) -> tuple[Array, list[int]]:
    """The corners (n, 3) of a face clipped to another one (Sutherland and Hodgman), and a number for each.

    The number encodes the edges that meet there, 0 to 3 of the face and 4 to 7 of the other, and is the same in every step.
    """
    (u, v), (a, b) = above.rectangle(opposed)
    middle = above.centre + above.half[opposed // 2] * above.normal(opposed)
    corners = [middle + x * a * u + y * b * v for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    edges = [0, 1, 2, 3]  # edge k begins at corner k
    sides, half = below.rectangle(face)
    for side in range(4):
        along, limit = (2 * (side % 2) - 1) * sides[side // 2], half[side // 2]
        beyond = [float(along @ (corner - below.centre)) - limit for corner in corners]
        kept, labels = [], []
        for k, (corner, out) in enumerate(zip(corners, beyond, strict=True)):
            following, following_out = corners[(k + 1) % len(corners)], beyond[(k + 1) % len(corners)]
            if out <= tie:
                kept.append(corner)
                labels.append(edges[k])
            if (out <= tie) != (following_out <= tie):
                share = min(max(out / (out - following_out), 0.0), 1.0)
                kept.append(corner + share * (following - corner))
                labels.append(4 + side if out <= tie else edges[k])
        corners, edges = kept, labels
    points = np.array(corners).reshape(-1, 3)
    distinct = [k for k in range(len(points)) if not (np.linalg.norm(points[:k] - points[k], axis=1) <= 10 * tie).any()]
    return points[distinct], [8 * edges[k - 1] + edges[k] for k in distinct]
