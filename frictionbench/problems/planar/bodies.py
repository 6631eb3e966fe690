"""Planar rigid bodies and their shapes.

A body has three coordinates (x, y, angle) at its centre of mass, so that the mass matrix is constant, diag(m, m, I). A shape is
the convex hull of its corners, in counterclockwise order: three or more corners form a polygon, two a rod, and one with a
radius a disc. A half plane lies to the left of the line through its two corners, and a hollow is the outside of a circle. Both
can only be obstacles, and in a scene with a hollow all bodies are discs.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.planar.joints import Hinge


@dataclass(frozen=True, eq=False)
class Shape:
    """corners: (k, 2), m, in the body's frame (in the world's for an obstacle). radius: m, of a disc; negative for a hollow.
    endless: whether it is a half plane or a hollow."""

    corners: Array
    radius: float = 0.0
    endless: bool = False

    def __post_init__(self) -> None:
        corners = np.array(self.corners, dtype=float)
        require(
            corners.ndim == 2 and corners.shape[1] == 2 and len(corners) > 0, "corners", f"expected (k, 2), got {corners.shape}"
        )
        require(bool(np.isfinite(corners).all()), "corners", "must be finite")
        require(len(corners) < 3 or _convex(corners), "corners", "must be those of a convex polygon, counterclockwise")
        require((self.radius != 0) == (len(corners) == 1), "radius", "must be nonzero for one corner (disc, hollow), else 0")
        corners.setflags(write=False)
        object.__setattr__(self, "corners", corners)

    @property
    def reach(self) -> float:
        """The largest distance of a point of the shape from the origin of its frame, m."""
        return float(np.hypot(*self.corners.T).max()) + self.radius

    def scaled(self, length: float) -> "Shape":
        """The shape in another unit of length."""
        return Shape(self.corners * length, self.radius * length, self.endless)


@dataclass(frozen=True, eq=False)
class Body:
    """mass: kg. inertia: kg m^2 about the centre of mass, which is the origin of the shapes' frame. roughness: relative to that
    of an obstacle (Scene.coefficients)."""

    mass: float
    inertia: float
    shapes: tuple[Shape, ...]
    roughness: float = 1.0

    def __post_init__(self) -> None:
        require(0 < self.mass < np.inf, "mass", f"must be positive, got {self.mass!r}")
        require(0 < self.inertia < np.inf, "inertia", f"must be positive, got {self.inertia!r}")
        require(0 <= self.roughness < np.inf, "roughness", f"must not be negative, got {self.roughness!r}")

    @property
    def weights(self) -> Array:
        """The diagonal (3,) of the mass matrix: kg, kg, kg m^2."""
        return np.array([self.mass, self.mass, self.inertia])

    def scaled(self, mass: float, length: float) -> "Body":
        """The body in other units."""
        shapes = tuple(shape.scaled(length) for shape in self.shapes)
        return Body(self.mass * mass, self.inertia * mass * length**2, shapes, self.roughness)


def box(width: float, height: float, centre: Sequence[float] = (0.0, 0.0)) -> Shape:
    """An upright rectangle."""
    half = np.array([width, height]) / 2
    return Shape(np.array(centre) + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))


def half_plane(point: Sequence[float] = (0.0, 0.0), slope: float = 0.0) -> Shape:
    """The half plane below the line through `point` that rises at the angle `slope`, in radians."""
    along = np.array([np.cos(slope), np.sin(slope)])
    return Shape(np.array(point) - np.array([[0.0, 0.0], along]), endless=True)


def vertical_wall(x: float, side: float) -> Shape:
    """The half plane beyond the vertical line at x: to its right for side = 1, to its left for side = -1."""
    return half_plane((x, 0.0), slope=side * np.pi / 2)


def hollow(radius: float, centre: Sequence[float] = (0.0, 0.0)) -> Shape:
    """The outside of a circle."""
    return Shape(np.array([centre]), -radius, endless=True)


def rigid_box(width: float, height: float, density: float = 1.0, roughness: float = 1.0) -> Body:
    """A homogeneous rectangle; density in kg/m^2."""
    mass = density * width * height
    return Body(mass, mass * (width**2 + height**2) / 12, (box(width, height),), roughness)


def rigid_rod(half_length: float, mass: float = 1.0) -> Body:
    """A thin uniform rod along the body's x axis."""
    return Body(mass, mass * half_length**2 / 3, (Shape(np.array([[-half_length, 0.0], [half_length, 0.0]])),))


def rigid_disc(radius: float, density: float = 1.0) -> Body:
    """A homogeneous disc; density in kg/m^2."""
    mass = density * np.pi * radius**2
    return Body(mass, mass * radius**2 / 2, (Shape(np.zeros((1, 2)), radius),))


def homogeneous(corners: Array) -> tuple[Body, Array]:
    """The body with the shape of a convex polygon (k, 2) and a density of 1 kg/m^2, and its centre of mass (2,)."""
    a, b = corners, np.roll(corners, -1, axis=0)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    mass = twice.sum() / 2
    centre = ((a + b) * twice[:, None]).sum(axis=0) / (6 * mass)
    about_origin = (twice * (a * a + a * b + b * b).sum(axis=1)).sum() / 12
    return Body(float(mass), float(about_origin - mass * centre @ centre), (Shape(corners - centre),)), centre


class Geometry:
    """All shapes of a scene in flat arrays, those of bodies first, then the fixed obstacles (owner -1); and the change of the
    coordinates, whose derivatives are the velocities in the plane.

    corners: (k, 2) in the owners' frames. start: (shapes+1,), the start of each shape's corners. owner, radius, endless:
    (shapes,). corner_owner: (k,). hinges: (hinges, 2), the bodies of each, sorted. reach: m, the largest distance of a
    body's point from its centre of mass.
    """

    coordinates = velocities = 3  # of a body

    def __init__(self, bodies: Sequence[Body], obstacles: Sequence[Shape], hinges: Sequence[Hinge] = ()) -> None:
        self.bodies, self.obstacles = tuple(bodies), tuple(obstacles)
        owned = [(i, shape) for i, body in enumerate(bodies) for shape in body.shapes]
        owned += [(-1, shape) for shape in obstacles]
        count = [len(shape.corners) for _, shape in owned]
        self.corners = np.vstack([np.zeros((0, 2)), *(shape.corners for _, shape in owned)])
        self.start = np.concatenate([[0], np.cumsum(count)]).astype(np.int64)
        self.owner = np.array([i for i, _ in owned], dtype=np.int64)
        self.radius = np.array([shape.radius for _, shape in owned], dtype=float)
        self.endless = np.array([shape.endless for _, shape in owned], dtype=bool)
        self.corner_owner = np.repeat(self.owner, np.array(count, dtype=np.int64))
        bowl, angular = (self.radius < 0).any(), (self.owner >= 0) & (self.radius <= 0)
        require(not (bowl and angular.any()), "obstacles", "a hollow is only possible where all bodies are discs")
        self.hinges = np.array([sorted(hinge.bodies) for hinge in hinges], dtype=np.int64).reshape(-1, 2)
        self.reach = max((shape.reach for i, shape in owned if i >= 0), default=1.0)

    def centres(self, q: Array) -> Array:
        """The centres of mass (nb, 2), m."""
        return q.reshape(-1, 3)[:, :2]

    def moved(self, q: Array, way: Array) -> Array:
        """The coordinates after the displacement `way` (nv,), a velocity times a time."""
        return q + way

    def gyroscopic(self, v: Array, step: float) -> Array:
        """Zero: there are no gyroscopic forces in the plane."""
        return np.zeros_like(v)

    def hinged(self, pairs: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether each pair (n, 2) of shapes belongs to two bodies on a common hinge, (n,)."""
        bodies = np.sort(self.owner[pairs], axis=1)
        held = self.hinges[self.hinges[:, 0] >= 0]
        pair = 1 + max(bodies.max(initial=0), held.max(initial=0)), 1  # encodes two bodies in one number
        return np.isin(bodies @ pair, held @ pair) & (bodies[:, 0] >= 0)

    def world_corners(self, q: Any) -> Array:
        """The corners (k, 2) in the world, for coordinates q (3 per body)."""
        x, y, angle = check.vector("q", q).reshape(-1, 3).T
        world = self.corners.copy()
        moved = self.corner_owner >= 0
        i = self.corner_owner[moved]
        cos, sin = np.cos(angle)[i], np.sin(angle)[i]
        a, b = self.corners[moved].T
        world[moved] = np.column_stack([x[i] + cos * a - sin * b, y[i] + sin * a + cos * b])
        return world


def _convex(corners: Array) -> bool:
    edge = np.roll(corners, -1, axis=0) - corners
    following = np.roll(edge, -1, axis=0)
    cross = edge[:, 0] * following[:, 1] - edge[:, 1] * following[:, 0]
    turn = np.arctan2(cross, np.sum(edge * following, axis=1))
    return bool(np.all(turn > 0) and abs(turn.sum() - 2 * np.pi) < 1e-6)
