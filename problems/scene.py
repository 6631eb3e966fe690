"""A scene: rigid planar bodies, fixed obstacles, the laws of contact and the initial state.

    M v' = k(q, v, t) + forces of contacts and joints,    q' = v,    q = (x, y, angle) of each body's centre of mass.

A scene provides the mechanics and the geometry. Time is discretised by a scheme (problems.schemes), which computes the contacts
with the scene and sets up a FrictionProblem.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.display import count, html_table
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.planar.bodies import Body, Geometry, Shape
from frictionbench.problems.planar.collision import Contacts, find_contacts
from frictionbench.problems.planar.joints import Hinge, hinge_equations

GRAVITY = 9.81


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Scene:
    """nb bodies, nv = 3 nb coordinates and velocities.

    q0, v0: (nv,), the initial state; by default at rest. friction: mu of contacts between bodies of roughness 1, see
    coefficients. restitution: e in [0, 1], of every
    contact. gravity: m/s^2, a vector. step: h, s. duration: T, s. name and parameters: the generator's and its arguments.
    Errors: InputError naming the field.
    """

    bodies: tuple[Body, ...]
    obstacles: tuple[Shape, ...] = ()
    hinges: tuple[Hinge, ...] = ()
    q0: Array
    v0: Array = None  # type: ignore[assignment]  # at rest
    friction: float
    restitution: float = 0.0
    gravity: tuple[float, float] = (0.0, -GRAVITY)
    step: float = 0.01
    duration: float = 3.0
    name: str = ""
    parameters: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        nv = 3 * len(self.bodies)
        object.__setattr__(self, "q0", check.vector("q0", np.ravel(self.q0), nv))
        object.__setattr__(self, "v0", check.vector("v0", np.zeros(nv) if self.v0 is None else np.ravel(self.v0), nv))
        unknown = [hinge.bodies for hinge in self.hinges if max(hinge.bodies) >= len(self.bodies)]
        require(not unknown, "hinges", f"refer to bodies that do not exist: {unknown}")
        require(0 <= self.friction < np.inf, "friction", f"must not be negative, got {self.friction!r}")
        require(0 <= self.restitution <= 1, "restitution", f"must be between 0 and 1, got {self.restitution!r}")
        require(0 < self.step < np.inf, "step", f"must be positive, got {self.step!r}")
        require(0 < self.duration < np.inf, "duration", f"must be positive, got {self.duration!r}")

    @property
    def steps(self) -> int:
        """The number of steps that cover the duration."""
        return round(self.duration / self.step)

    @cached_property
    def weights(self) -> Array:
        """The diagonal (nv,) of the mass matrix: kg, kg, kg m^2 per body."""
        return np.array([[body.mass, body.mass, body.inertia] for body in self.bodies]).reshape(-1)

    @cached_property
    def _roughness(self) -> Array:
        """That of every body, and last that of the obstacles, whose index is -1."""
        return np.array([*(body.roughness for body in self.bodies), 1.0])

    def coefficients(self, contacts: Contacts) -> Array:
        """mu of each contact (nc,): `friction` times the geometric mean of its two bodies' roughness, 1 for an obstacle."""
        return np.asarray(self.friction * np.sqrt(self._roughness[contacts.bodies].prod(axis=1)))

    @cached_property
    def mass(self) -> sparse.csr_array:
        """M (nv, nv), diagonal."""
        return sparse.csr_array(sparse.diags_array(self.weights))

    @cached_property
    def geometry(self) -> Geometry:
        return Geometry(self.bodies, self.obstacles, self.hinges)

    @property
    def touch(self) -> float:
        """The gap, m, up to which a contact counts as touching: 1e-6 of the largest body, far above the
        gaps that round-off and a solver's tolerance leave at a closed contact, far below the gap after one step of motion."""
        return 1e-6 * self.geometry.reach

    def force(self, q: Array, v: Array, t: float) -> Array:
        """The external force k (nv,): N, N, N m per body."""
        return self.weights * np.tile([*self.gravity, 0.0], len(self.bodies))

    def contacts(self, q: Array, margin: float | None = None) -> Contacts:
        """All contacts with gap <= margin, m; by default those that touch."""
        return find_contacts(self.geometry, q, self.touch if margin is None else margin)

    def joints(self, q: Array) -> tuple[Array, sparse.csr_array]:
        """The joints' residual Theta(q) (nj,), m, and Jacobian F (nj, nv)."""
        theta, rows = hinge_equations(self.hinges, q)
        return theta, rows.matrix(len(q))

    def energy(self, q: Array, v: Array) -> float:
        """Kinetic and potential energy, J; the potential is zero at the origin."""
        height = np.tile([*self.gravity, 0.0], len(self.bodies)) @ (self.weights * q)
        return float(v @ (self.weights * v) / 2 - height)

    def friction_problem(
        self,
        q: Array,
        free_velocity: Array,
        contacts: Contacts,
        bias: Array | float = 0.0,
        friction_bias: Array | float = 0.0,
        joint_bias: Array | float = 0.0,
    ) -> FrictionProblem:
        """The friction problem of these contacts and of the joints at q; a bias may be one number for all."""
        nc, F = len(contacts), hinge_equations(self.hinges, q)[1] if self.hinges else None
        return FrictionProblem(
            mass=self.mass,
            normal=contacts.normal_rows,  # as plain arrays
            tangent=contacts.tangent_rows,
            friction=self.coefficients(contacts),
            free_velocity=free_velocity,
            bias=np.broadcast_to(bias, nc),
            friction_bias=np.broadcast_to(friction_bias, nc),
            joints=F,
            joint_bias=np.broadcast_to(joint_bias, 2 * len(self.hinges)),
        )

    def problem(self) -> FrictionProblem:
        """The friction problem of the first time step of Anitescu and Potra's scheme."""
        free = self.v0 + self.step * self.force(self.q0, self.v0, 0.0) / self.weights
        return self.friction_problem(self.q0, free, self.contacts(self.q0))

    def __repr__(self) -> str:
        return f"Scene({self.name}: {', '.join(self._summary())})" if self.name else f"Scene({', '.join(self._summary())})"

    def _repr_html_(self) -> str:
        rows = {"size": ", ".join(self._summary()), "restitution": self.restitution, **self.parameters}
        return html_table(f"Scene {self.name}".rstrip(), rows)

    def _summary(self) -> list[str]:
        hinges = [count(len(self.hinges), "hinge")] if self.hinges else []
        time = f"{count(self.steps, 'step')} of {self.step:g} s"
        return [count(len(self.bodies), "body"), *hinges, f"mu = {self.friction:g}", time]
