"""Scenes in generalised coordinates: any mass matrix and forces, contacts given by gap functions, and no bodies.

    M(q) v' = k(q, v, t) + N' f_n + T' f_t,    q' = v,    N = d gap/dq,    T v the sliding velocities.

k contains the Coriolis and centrifugal forces, which come from M'(q), and the springs. A linear part -K q of the springs may be
given as `stiffness`, which the theta schemes treat implicitly.
"""

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.planar.bodies import Body, Shape
from frictionbench.problems.planar.collision import Contacts
from frictionbench.problems.rows import Rows, from_dense
from frictionbench.problems.scene import Scene
from frictionbench.problems.spatial.bodies import Solid


@dataclass(frozen=True, eq=False)
class GivenContacts(Contacts):
    """Contacts with given rows N and T (nc, nv). T gives the velocity along n rotated by -90 degrees. place: for drawing."""

    N: Array
    T: Array

    @cached_property
    def normal_rows(self) -> Rows:
        return from_dense(self.N)

    @cached_property
    def tangent_rows(self) -> Rows:
        return from_dense(self.T)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class GeneralisedScene(Scene):
    """q0, v0: (nv,). size: of the mechanism, m, for tolerances. The other fields are as in Scene."""

    bodies: tuple[Body | Solid, ...] = ()
    size: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "q0", check.vector("q0", self.q0))
        object.__setattr__(self, "v0", check.vector("v0", 0 * self.q0 if self.v0 is None else self.v0, len(self.q0)))
        self._require_laws()

    @abstractmethod
    def inertia(self, q: Array) -> Array:
        """M(q) (nv, nv), symmetric positive definite."""

    @abstractmethod
    def force(self, q: Array, v: Array, t: float) -> Array:
        """k (nv,), including all springs and the Coriolis and centrifugal forces from M'(q)."""

    @abstractmethod
    def potential(self, q: Array) -> float:
        """The potential energy, J."""

    @abstractmethod
    def contacts(self, q: Array, margin: float | None = None) -> GivenContacts:
        """All contacts with gap <= margin, m; by default those that touch."""

    @property
    @abstractmethod
    def outlines(self) -> tuple[tuple[int, Shape], ...]:
        """The shapes to draw, each with the index of the pose that moves it, or -1 if it is fixed."""

    @abstractmethod
    def poses(self, q: Array) -> Array:
        """(nb, 3): x, y and angle of the moving shapes to draw."""

    @property
    def stiffness(self) -> Array | None:
        """The constant K (nv, nv) of a part -K q of the force; None if there is no such part."""
        return None

    @property
    def reach(self) -> float:
        return self.size

    def mass_matrix(self, q: Array, ahead: float = 0.0) -> sparse.csr_array:
        return sparse.csr_array(self._implicit(q, ahead))

    def accelerate(self, q: Array, force: Array, ahead: float = 0.0) -> Array:
        return np.asarray(np.linalg.solve(self._implicit(q, ahead), force))

    def _implicit(self, q: Array, ahead: float) -> Array:
        return self.inertia(q) if self.stiffness is None else self.inertia(q) + ahead**2 * self.stiffness

    def kinetic(self, q: Array, v: Array) -> float:
        return float(v @ self.inertia(q) @ v) / 2

    def energy(self, q: Array, v: Array) -> float:
        return self.kinetic(q, v) + self.potential(q)

    def fastest(self, v: Array) -> float:
        return float(np.abs(self.contacts(self.q0, np.inf).N @ v).max(initial=0.0))

    def moved(self, q: Array, way: Array) -> Array:
        return q + way

    def joints(self, q: Array) -> tuple[Array, sparse.csr_array]:
        return np.zeros(0), sparse.csr_array((0, len(q)))

    def _summary(self) -> list[str]:
        return [f"{len(self.q0)} coordinates", *super()._summary()[-2:]]
