"""Rigid bodies in space: spheres and boxes, on half spaces.

A body has seven coordinates, its centre of mass and a unit quaternion. Its six velocities are that of its centre in the world's
frame and the spin in the body's frame, so that the mass matrix is constant, diag(m, m, m, I1, I2, I3).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.spatial import rotation


@dataclass(frozen=True, eq=False)
class Sphere:
    """radius: m."""

    radius: float

    def __post_init__(self) -> None:
        require(0 < self.radius < np.inf, "radius", f"must be positive, got {self.radius!r}")

    @property
    def reach(self) -> float:
        return self.radius

    def scaled(self, length: float) -> "Sphere":
        return Sphere(self.radius * length)


@dataclass(frozen=True, eq=False)
class Cuboid:
    """half: (3,), m, half the lengths of its edges."""

    half: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "half", check.vector("half", np.array(self.half, dtype=float), 3))
        require(bool((self.half > 0).all()), "half", f"must be positive, got {self.half}")

    @property
    def reach(self) -> float:
        return float(np.linalg.norm(self.half))

    def scaled(self, length: float) -> "Cuboid":
        return Cuboid(self.half * length)


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """A fixed obstacle: the points x with normal . x <= height. normal: (3,), a unit vector. height: m."""

    normal: Array
    height: float = 0.0

    def __post_init__(self) -> None:
        normal = check.vector("normal", np.array(self.normal, dtype=float), 3)
        require(bool(abs(normal @ normal - 1) < 1e-12), "normal", f"must be a unit vector, got {normal}")
        object.__setattr__(self, "normal", normal)

    def scaled(self, length: float) -> "HalfSpace":
        return HalfSpace(self.normal, self.height * length)


LEVEL_GROUND = HalfSpace(np.array([0.0, 0.0, 1.0]))


@dataclass(frozen=True, eq=False)
class Solid:
    """mass: kg. inertia: (3,), kg m^2, the principal moments about the centre of mass, along the shape's axes. roughness:
    relative to that of an obstacle (Scene.coefficients)."""

    mass: float
    inertia: Array
    shape: Sphere | Cuboid
    roughness: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "inertia", check.vector("inertia", np.array(self.inertia, dtype=float), 3))
        require(0 < self.mass < np.inf, "mass", f"must be positive, got {self.mass!r}")
        require(bool((self.inertia > 0).all()), "inertia", f"must be positive, got {self.inertia}")
        require(0 <= self.roughness < np.inf, "roughness", f"must not be negative, got {self.roughness!r}")

    @property
    def weights(self) -> Array:
        """The diagonal (6,) of the mass matrix."""
        return np.array([self.mass] * 3 + [*self.inertia])

    def scaled(self, mass: float, length: float) -> "Solid":
        """The body in other units."""
        return Solid(self.mass * mass, self.inertia * mass * length**2, self.shape.scaled(length), self.roughness)


def solid_sphere(radius: float, mass: float = 1.0) -> Solid:
    """A homogeneous sphere."""
    return Solid(mass, np.full(3, 0.4 * mass * radius**2), Sphere(radius))


def solid_box(half: Sequence[float], mass: float = 1.0) -> Solid:
    """A homogeneous box; half: m, half the lengths of its edges."""
    squares = np.square(half)
    return Solid(mass, mass / 3 * (squares.sum() - squares), Cuboid(np.array(half)))


class SpatialGeometry:
    """The bodies and obstacles of a scene in space, and the change of coordinates q (7 nb,) by velocities v (6 nb,).

    reach: m, the largest distance of a body's point from its centre of mass.
    """

    coordinates, velocities = 7, 6  # of a body

    def __init__(self, bodies: Sequence[Solid], obstacles: Sequence[HalfSpace]) -> None:
        self.bodies, self.obstacles = tuple(bodies), tuple(obstacles)
        self.reach = max((body.shape.reach for body in bodies), default=1.0)
        kinds = {type(body.shape) for body in bodies}
        require(len(kinds) < 2, "bodies", "must be all spheres or all boxes: contacts between the two are not implemented")
        self._inertia = np.array([body.inertia for body in bodies]).reshape(-1, 3)

    def centres(self, q: Array) -> Array:
        """The centres of mass (nb, 3), m."""
        return q.reshape(-1, 7)[:, :3]

    def rotations(self, q: Array) -> Array:
        """The rotations (nb, 3, 3) from the bodies' frames to the world's."""
        return rotation.matrices(q.reshape(-1, 7)[:, 3:])

    def moved(self, q: Array, way: Array) -> Array:
        """The coordinates after the displacement `way` (6 nb,), a velocity times a time; quaternions keep unit length."""
        pose, step = q.reshape(-1, 7), way.reshape(-1, 6)
        return np.hstack([pose[:, :3] + step[:, :3], rotation.turned(pose[:, 3:], step[:, 3:])]).ravel()

    def gyroscopic(self, v: Array, step: float) -> Array:
        """The generalised force (6 nb,) of the gyroscopic torques, averaged over a step."""
        force = np.zeros((len(self.bodies), 6))
        force[:, 3:] = rotation.gyroscopic(self._inertia, v.reshape(-1, 6)[:, 3:], step)
        return force.ravel()
