"""A scene: rigid bodies, fixed obstacles, the laws of contact and the initial state, in the plane or in space.

    M v' = k(q, v, t) + forces of contacts and joints,    q' = H(q) v,    M diagonal and constant.

In the plane q = (x, y, angle) of each body's centre of mass and q' = v. In space q = (x, y, z, unit quaternion), v is the
velocity of the centre and the spin in the body's own frame, and k contains the gyroscopic torque. Only `Scene.moved` changes
coordinates. It rotates a body by the vector h times its spin, so that quaternions keep unit length.

A scene provides the mechanics and the geometry. Time is discretised by a scheme (problems.schemes), which computes the contacts
with the scene and sets up a FrictionProblem.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, counted, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.planar.bodies import Body, Geometry, Shape
from frictionbench.problems.planar.collision import Contacts, find_contacts
from frictionbench.problems.planar.joints import Hinge, hinge_equations
from frictionbench.problems.spatial.bodies import HalfSpace, Solid, SpatialGeometry
from frictionbench.problems.spatial.collision import find_spatial_contacts

GRAVITY = 9.81
MOST_STEPS = 1e15  # of a motion: whole numbers that a double and a column of the tables hold exactly


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Scene:
    """nb bodies with 3 nb velocities and 3 nb coordinates in the plane, or 6 nb velocities and 7 nb coordinates in space.

    bodies: all planar (problems.planar) or all spatial (problems.spatial). hinges: only in the plane. q0, v0: the initial
    state, by default at rest. friction: mu of contacts between bodies of roughness 1 (see coefficients). restitution: e in
    [0, 1], of every contact. gravity: m/s^2, a vector. step: h, s. duration: T, s. path: the centres of mass (nb, d) at a time,
    if the motion has a closed form. name and parameters: those of the generator.
    Errors: InputError naming the field.
    """

    bodies: tuple[Body | Solid, ...]
    obstacles: tuple[Shape | HalfSpace, ...] = ()
    hinges: tuple[Hinge, ...] = ()
    q0: Array
    v0: Array = None  # type: ignore[assignment]  # at rest
    friction: float = 0.0
    restitution: float = 0.0
    gravity: tuple[float, ...] = None  # type: ignore[assignment]  # down
    step: float = 0.01
    duration: float = 3.0
    path: Callable[[float], Array] | None = None
    name: str = ""
    parameters: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        nb, d = len(self.bodies), self.dimension
        nq, nv = nb * self.geometry.coordinates, nb * self.geometry.velocities
        object.__setattr__(self, "q0", check.vector("q0", np.ravel(self.q0), nq))
        object.__setattr__(self, "v0", check.vector("v0", np.zeros(nv) if self.v0 is None else np.ravel(self.v0), nv))
        lengths = np.linalg.norm(self.q0.reshape(nb, -1)[:, 3:], axis=1)
        require(d == 2 or bool((abs(lengths - 1) < 1e-9).all()), "q0", f"quaternions must have unit length, got {lengths}")
        down = (*[0.0] * (d - 1), -GRAVITY)
        object.__setattr__(self, "gravity", tuple(check.vector("gravity", down if self.gravity is None else self.gravity, d)))
        unknown = [hinge.bodies for hinge in self.hinges if max(hinge.bodies) >= len(self.bodies)]
        require(not unknown, "hinges", f"refer to bodies that do not exist: {unknown}")
        self._require_laws()

    def _require_laws(self) -> None:
        require(0 <= self.friction < np.inf, "friction", f"must not be negative, got {self.friction!r}")
        require(0 <= self.restitution <= 1, "restitution", f"must be between 0 and 1, got {self.restitution!r}")
        require(0 < self.step < np.inf, "step", f"must be positive, got {self.step!r}")
        require(0 < self.duration < np.inf, "duration", f"must be positive, got {self.duration!r}")
        many = f"{self.step!r} s is too short: {self.duration!r} s would take more than {MOST_STEPS:g} steps"
        require(self.duration / self.step <= MOST_STEPS, "step", many)

    @property
    def steps(self) -> int:
        """The number of steps that cover the duration, at least one."""
        return max(1, round(self.duration / self.step))

    @property
    def dimension(self) -> int:
        """d: 2 in the plane, 3 in space."""
        return 3 if self.bodies and isinstance(self.bodies[0], Solid) else 2

    @cached_property
    def weights(self) -> Array:
        """The diagonal (nv,) of the mass matrix, in kg for translations and kg m^2 for rotations."""
        return np.array([body.weights for body in self.bodies]).reshape(-1)

    @cached_property
    def _roughness(self) -> Array:
        """The roughness of every body, followed by that of the obstacles, whose index is -1."""
        return np.array([*(body.roughness for body in self.bodies), 1.0])

    def coefficients(self, contacts: Contacts) -> Array:
        """mu of each contact (nc,): `friction` times the geometric mean of its bodies' roughness, which is 1 for obstacles."""
        return np.asarray(self.friction * np.sqrt(self._roughness[contacts.bodies].prod(axis=1)))

    @cached_property
    def mass(self) -> sparse.csr_array:
        """M (nv, nv), diagonal."""
        return sparse.csr_array(sparse.diags_array(self.weights))

    def restitutions(self, contacts: Contacts) -> Array:
        """e of each contact (nc,)."""
        return np.full(len(contacts), self.restitution)

    def accelerate(self, q: Array, force: Array, ahead: float = 0.0) -> Array:
        """M(q)^-1 force: the acceleration due to a force (nv,), or the velocity due to an impulse; (nv, n) for n of them.

        ahead: as in mass_matrix.
        """
        return np.asarray((force.T / self.weights).T)

    def mass_matrix(self, q: Array, ahead: float = 0.0) -> sparse.csr_array:
        """M(q) + ahead^2 K (nv, nv), where ahead is a time in s and K a stiffness; bodies have no springs, so K = 0 here."""
        return self.mass

    @property
    def reach(self) -> float:
        """The size of the largest body, m: the largest distance of one of its points from its centre of mass."""
        return self.geometry.reach

    @cached_property
    def geometry(self) -> Geometry | SpatialGeometry:
        solids = [body for body in self.bodies if isinstance(body, Solid)]
        spaces = [obstacle for obstacle in self.obstacles if isinstance(obstacle, HalfSpace)]
        bodies = [body for body in self.bodies if isinstance(body, Body)]
        shapes = [obstacle for obstacle in self.obstacles if isinstance(obstacle, Shape)]
        require(not (bodies and solids), "bodies", "must all be planar or all be spatial")
        require(not (shapes if solids else spaces), "obstacles", "must be planar where the bodies are, else spatial")
        require(not (solids and self.hinges), "hinges", "are only possible in the plane")
        return SpatialGeometry(solids, spaces) if solids else Geometry(bodies, shapes, self.hinges)

    @property
    def touch(self) -> float:
        """The gap, m, up to which a contact counts as touching: 1e-6 times the size of the largest body. It is far above the
        gaps that rounding and a solver's tolerance leave at a closed contact, and far below the motion in one step."""
        return 1e-6 * self.reach

    def force(self, q: Array, v: Array, t: float) -> Array:
        """The external force k (nv,), N and N m; in space it includes the mean gyroscopic torque of a step from v."""
        turns = [0.0] * (self.geometry.velocities - self.dimension)
        return self.weights * np.tile([*self.gravity, *turns], len(self.bodies)) + self.geometry.gyroscopic(v, self.step)

    def fastest(self, v: Array) -> float:
        """A bound on the speed of any point of a body, m/s."""
        each = v.reshape(-1, self.geometry.velocities)
        linear, spin = np.split(each, [self.dimension], axis=1)
        return float((np.linalg.norm(linear, axis=1) + self.reach * np.linalg.norm(spin, axis=1)).max(initial=0.0))

    def moved(self, q: Array, way: Array) -> Array:
        """The coordinates q after a displacement (nv,), a velocity times a time."""
        return self.geometry.moved(q, way)

    def contacts(self, q: Array, margin: float | None = None) -> Contacts:
        """All contacts with gap <= margin, m; by default those that touch."""
        within, geometry = self.touch if margin is None else margin, self.geometry
        if isinstance(geometry, SpatialGeometry):
            return find_spatial_contacts(geometry, q, within)
        return find_contacts(geometry, q, within)

    def path_error(self, q: Array, t: float) -> float | None:
        """The largest distance, m, of a centre of mass from the closed form; None if there is no closed form."""
        return None if self.path is None else float(np.linalg.norm(self.geometry.centres(q) - self.path(t), axis=1).max())

    def deepest_overlap(self, q: Array) -> float:
        """The deepest overlap (m) of two bodies, or of a body and an obstacle; 0 if there is none."""
        return float(max(0.0, -self.contacts(q, 0.0).gap.min(initial=0.0)))

    def joints(self, q: Array) -> tuple[Array, sparse.csr_array]:
        """The joints' residual Theta(q) (nj,), m, and Jacobian F (nj, nv)."""
        theta, rows = hinge_equations(self.hinges, q)
        return theta, rows.matrix(len(self.weights))

    def kinetic(self, q: Array, v: Array) -> float:
        """The kinetic energy, J."""
        return float(v @ (self.weights * v) / 2)

    def energy(self, q: Array, v: Array) -> float:
        """Kinetic and potential energy, J; the potential is zero at the origin."""
        mass = self.weights[:: self.geometry.velocities]
        return float(self.kinetic(q, v) - mass @ (self.geometry.centres(q) @ self.gravity))

    def friction_problem(
        self,
        q: Array,
        free_velocity: Array,
        contacts: Contacts,
        bias: Array | float = 0.0,
        friction_bias: Array | float = 0.0,
        joint_bias: Array | float = 0.0,
        ahead: float = 0.0,
    ) -> FrictionProblem:
        """The friction problem of these contacts and of the joints at q. A bias may be one number for all contacts or joints.
        ahead: as in mass_matrix."""
        nc, F = len(contacts), hinge_equations(self.hinges, q)[1] if self.hinges else None
        return FrictionProblem(
            mass=self.mass_matrix(q, ahead),
            normal=contacts.normal_rows,  # as plain arrays
            tangent=contacts.tangent_rows,
            friction=self.coefficients(contacts),
            free_velocity=free_velocity,
            bias=np.broadcast_to(bias, nc),
            friction_bias=np.broadcast_to(friction_bias, nc),
            joints=F,
            joint_bias=np.broadcast_to(joint_bias, 2 * len(self.hinges)),
            dimension=self.dimension,
        )

    def problem(self) -> FrictionProblem:
        """The friction problem of the first time step of Anitescu and Potra's scheme."""
        free = self.v0 + self.step * self.accelerate(self.q0, self.force(self.q0, self.v0, 0.0))
        return self.friction_problem(self.q0, free, self.contacts(self.q0))

    def in_units(self, mass: float, length: float) -> "Scene":
        """The scene with every mass multiplied by `mass` and every length by `length`: the motion is the same.

        The unit of time is unchanged. A solver whose results depend on the units has an absolute tolerance.
        Errors: InputError if the scene has no bodies, because the units of generalised coordinates are unknown.
        """
        require(bool(self.bodies), "mass_unit, length_unit", "a scene in generalised coordinates has its own units only")

        def scaled(state: Array, size: int) -> Array:
            """The first d of `size` entries of each body are lengths."""
            unit = np.ones(size)
            unit[: self.dimension] = length
            return state * np.tile(unit, len(self.bodies))

        return replace(
            self,
            bodies=tuple(body.scaled(mass, length) for body in self.bodies),
            obstacles=tuple(obstacle.scaled(length) for obstacle in self.obstacles),
            hinges=tuple(Hinge(hinge.bodies, hinge.points * length) for hinge in self.hinges),
            q0=scaled(self.q0, self.geometry.coordinates),
            v0=scaled(self.v0, self.geometry.velocities),
            gravity=tuple(length * g for g in self.gravity),
            path=self.path and partial(_lengths, self.path, length),
        )

    def __repr__(self) -> str:
        return f"Scene({self.name}: {', '.join(self._summary())})" if self.name else f"Scene({', '.join(self._summary())})"

    def _summary(self) -> list[str]:
        hinges = [counted(len(self.hinges), "hinge")] if self.hinges else []
        time = f"{counted(self.steps, 'step')} of {self.step:g} s"
        return [counted(len(self.bodies), "body"), *hinges, f"mu = {self.friction:g}", time]


def _lengths(path: Callable[[float], Array], length: float, time: float) -> Array:
    return length * path(time)
