"""One time step of rigid bodies in contact with Coulomb friction.

In velocities v (nv) and contact impulses r (nc*d, per contact the normal first), with J the contact Jacobian,

    M (v - v*) = J' r + F' lam,      F v + b_F = 0,      u = J v + b,

and at each contact Coulomb's law between its impulse and its velocity u = (u_n, u_t), b acting on u_n alone:

    0 <= u_n  ⟂  r_n >= 0,      |r_t| <= mu r_n + b_f,      r_t opposes u_t with |r_t| = mu r_n + b_f wherever u_t != 0.

Eliminating v and lam leaves the Delassus form u = W r + q with W = J P J', P the inverse mass on the null space of F.
References: Anitescu and Potra 1997; Acary and Brogliato 2008, chapter 10.
"""

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, Self

import numpy as np
from scipy import sparse

from problems import check
from problems.check import Array, require
from problems.forms.definite import spectrum_ends
from problems.forms.delassus import apply, delassus, delassus_diagonal, interleave, push, velocity_size
from problems.forms.lcp import LCP, content_hash, friction_lcp
from problems.forms.mass import invert_mass
from problems.forms.relaxation import QP, ConeProgram, Laws, VelocityForm, relaxation_cone, relaxation_qp

INDEFINITE = 1e-6  # of W's largest eigenvalue: recorded problems are indefinite by what their files' digits lost


@dataclass(frozen=True, eq=False, kw_only=True)
class FrictionProblem:
    """A friction problem with nc contacts of dimension d (2 planar, 3 spatial) and nv velocities.

    mass: (nv, nv), symmetric positive definite. normal: (nc, nv). tangent: (nc*(d-1), nv), rows per contact.
    friction: (nc,), >= 0. free_velocity: (nv,), the velocity without any constraint.
    bias: (nc,), m/s, added to the normal velocity: gap/step, or a restitution target.
    friction_bias: (nc,), N s, >= 0: friction available without a normal impulse of this step (Poisson's decompression).
    joints: (nj, nv), joint_bias: (nj,), m/s: bilateral constraints, of any rank, kept exactly.

    Everything is checked, copied and made read-only here. Errors: InputError naming the field.
    """

    mass: sparse.csr_array
    normal: sparse.csr_array
    tangent: sparse.csr_array
    friction: Array
    free_velocity: Array
    bias: Array
    friction_bias: Array = None  # type: ignore[assignment]  # None stands for zeros
    joints: sparse.csr_array = None  # none
    joint_bias: Array = None  # type: ignore[assignment]  # zeros
    dimension: int = 2
    inverse_mass: sparse.csr_array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        require(self.dimension in (2, 3), "dimension", f"must be 2 or 3, got {self.dimension!r}")
        mu = check.vector("friction", self.friction)
        v = check.vector("free_velocity", self.free_velocity)
        nc, nv = len(mu), len(v)
        joints = check.matrix("joints", np.zeros((0, nv)) if self.joints is None else self.joints, (None, nv))
        nj = joints.shape[0]
        checked = {
            "friction": mu,
            "free_velocity": v,
            "mass": check.matrix("mass", self.mass, (nv, nv)),
            "normal": check.matrix("normal", self.normal, (nc, nv)),
            "tangent": check.matrix("tangent", self.tangent, (nc * (self.dimension - 1), nv)),
            "bias": check.vector("bias", self.bias, nc),
            "friction_bias": check.vector("friction_bias", _or_zeros(self.friction_bias, nc), nc),
            "joints": joints,
            "joint_bias": check.vector("joint_bias", _or_zeros(self.joint_bias, nj), nj),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        require(bool(np.all(mu >= 0)), "friction", "must not be negative")
        require(bool(np.all(self.friction_bias >= 0)), "friction_bias", "must not be negative")
        object.__setattr__(self, "inverse_mass", invert_mass(self.mass))

    @classmethod
    def from_delassus(cls, W: Any, q: Any, friction: Any, d: int, friction_bias: Any = None) -> Self:
        """The problem of which only u = W r + q is known; rows per contact, normal first (FCLIB's order).

        W: (nc*d, nc*d), kept as given, also where it is slightly unsymmetric. Errors: InputError naming the field.
        """
        require(d in (2, 3), "d", f"must be 2 or 3, got {d!r}")
        return DelassusProblem(W=W, q=q, friction=friction, friction_bias=friction_bias, dimension=d)  # type: ignore[return-value]

    def fresh(self) -> Self:
        """The same problem without anything derived from it: what preparing it costs is met again."""
        again = object.__new__(type(self))
        again.__dict__.update({name: self.__dict__[name] for name in self._given})
        return again

    @property
    def _given(self) -> tuple[str, ...]:
        return tuple(entry.name for entry in fields(self))

    @property
    def contacts(self) -> int:
        """nc, the number of contacts."""
        return len(self.friction)

    @cached_property
    def jacobian(self) -> sparse.csr_array:
        """J (nc*d, nv): per contact its normal row, then its tangent rows."""
        return interleave(self.normal, self.tangent, self.dimension)

    @cached_property
    def _joint_response(self) -> tuple[Array, Array]:
        """(M^-1 F', (F M^-1 F')^+), dense; joints are few, and may be redundant."""
        response = (self.inverse_mass @ self.joints.T).toarray()
        return response, np.linalg.pinv(self.joints @ response, hermitian=True)

    @property
    def _joint_coupling(self) -> tuple[Array, Array]:
        """(F M^-1 J', (F M^-1 F')^+), dense."""
        response, inverse = self._joint_response
        return (self.jacobian @ response).T, inverse

    def _on_joints(self, velocity: Array, bias: Array) -> Array:
        """The velocity nearest in the kinetic metric with F v + bias = 0."""
        if not self.joints.shape[0]:
            return velocity
        response, inverse = self._joint_response
        return velocity - response @ (inverse @ (self.joints @ velocity + bias))

    def _rows(self, impulse: Array) -> Array:
        return check.entries("impulse", impulse, self.contacts * self.dimension)

    def velocity(self, impulse: Array) -> Array:
        """v (nv,) after the contact impulses (nc, d) or (nc*d,), joints kept; computed without W."""
        r = self._rows(impulse)
        return self._on_joints(push(self.jacobian, self.inverse_mass, self.free_velocity, r), self.joint_bias)

    def contact_velocity(self, impulse: Array) -> Array:
        """u (nc, d), bias included, after the contact impulses (nc, d); computed without W."""
        u = apply(self.jacobian, self.velocity(impulse)).reshape(self.contacts, self.dimension)
        u[:, 0] += self.bias
        return u

    def velocity_size(self, impulse: Array) -> Array:
        """(nc, d): the size of the terms that add up to contact_velocity, of whose sum rounding takes some eps."""
        r = self._rows(impulse)
        size = velocity_size(self.jacobian, self.inverse_mass, self.free_velocity, r)
        if self.joints.shape[0]:
            pushed = push(self.jacobian, self.inverse_mass, self.free_velocity, r)
            response, inverse = self._joint_response
            held = abs(self.joints) @ np.abs(pushed) + np.abs(self.joint_bias)
            size += abs(self.jacobian) @ (np.abs(response) @ (np.abs(inverse) @ held))
        size = size.reshape(self.contacts, self.dimension)
        size[:, 0] += np.abs(self.bias)
        return size

    @cached_property
    def q(self) -> Array:
        """The free contact velocity with its bias (nc*d,): u where r = 0."""
        return self.contact_velocity(np.zeros((self.contacts, self.dimension))).ravel()

    @cached_property
    def W(self) -> sparse.csr_array:
        """The Delassus matrix J P J' (nc*d, nc*d), sparse."""
        W = delassus(self.jacobian, self.inverse_mass)
        if self.joints.shape[0]:
            coupling, inverse = self._joint_coupling
            W = sparse.csr_array(W - sparse.csr_array(coupling.T @ inverse @ coupling))
        return W

    @cached_property
    def scale(self) -> Array:
        """s (nc,): the mean diagonal of each contact's block of W, 1/kg; 1 where it vanishes."""
        diagonal = delassus_diagonal(self.jacobian, self.inverse_mass)
        if self.joints.shape[0]:
            coupling, inverse = self._joint_coupling
            diagonal = diagonal - np.einsum("ji,jk,ki->i", coupling, inverse, coupling)
        return _mean_diagonal(diagonal, self.dimension)

    def velocity_form(self) -> VelocityForm:
        """Mass, Jacobian and free velocity, for methods that work in v. Joints stay beside it, in `joints`."""
        offset = np.zeros((self.contacts, self.dimension))
        offset[:, 0] = self.bias
        return VelocityForm(self.mass, self.inverse_mass, self.jacobian, self.free_velocity, offset.ravel())

    @property
    def _laws(self) -> Laws:
        return Laws(self.friction, self.friction_bias, self.joints, self.joint_bias, self.dimension)

    def lcp(self, facets: int = 8) -> LCP:
        """The friction LCP. Exact in the plane; in space the cone's section is a polygon inscribed with `facets` corners."""
        if self.dimension == 2:
            directions = np.array([[1.0, -1.0]])
        else:
            require(facets >= 4 and facets % 2 == 0, "facets", f"must be even and at least 4, got {facets!r}")
            angle = 2 * np.pi * np.arange(facets) / facets
            directions = np.array([np.cos(angle), np.sin(angle)])
        return friction_lcp(self.W, self.q, self.friction, self.friction_bias, directions)

    def qp(self, facets: int = 8) -> QP:
        """The convex relaxation as a quadratic program in the velocities (Anitescu 2006); polygonal in space."""
        return relaxation_qp(self.velocity_form(), self._laws, facets)

    def cone(self) -> ConeProgram:
        """The convex relaxation as a second-order cone program in the velocities (Anitescu and Tasora 2010)."""
        return relaxation_cone(self.velocity_form(), self._laws)

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal problems, whatever form the fields came in."""
        names = ("mass", "normal", "tangent", "friction", "free_velocity", "bias", "friction_bias", "joints", "joint_bias")
        return content_hash(dimension=self.dimension, **{name: getattr(self, name) for name in names})


def _every(first: int) -> cached_property[sparse.csr_array]:
    """The rows of a DelassusProblem's Jacobian that are normal (first = 0) or tangential (1)."""

    def rows(problem: "DelassusProblem") -> sparse.csr_array:
        row = np.arange(len(problem.q)) % problem.dimension
        return problem.jacobian[(row == 0) if first == 0 else (row > 0)]

    return cached_property(rows)


@dataclass(frozen=True, eq=False, kw_only=True)
class DelassusProblem(FrictionProblem):
    """A friction problem known only by u = W r + q.

    W: (nc*d, nc*d), rows per contact, normal first, kept as given, also where it is slightly unsymmetric or has negative
    eigenvalues down to -INDEFINITE of the largest (as far as problems.forms.definite sees). q: (nc*d,).

    Its velocities (nc*d) are those of the symmetric root of W, with unit mass. The root is dense, and taken only where a method
    asks for the Jacobian, its normal or its tangent rows. Errors: InputError naming the field.
    """

    W: sparse.csr_array = field()
    q: Array = field()
    mass: sparse.csr_array = field(init=False, repr=False)
    free_velocity: Array = field(init=False, repr=False)
    bias: Array = field(init=False, repr=False)
    joints: sparse.csr_array = field(init=False, repr=False)
    joint_bias: Array = field(init=False, repr=False)
    normal: sparse.csr_array = field(init=False, repr=False, default=_every(0))
    tangent: sparse.csr_array = field(init=False, repr=False, default=_every(1))

    def __post_init__(self) -> None:
        d = self.dimension
        require(d in (2, 3), "dimension", f"must be 2 or 3, got {d!r}")
        mu = check.vector("friction", self.friction)
        nc = len(mu)
        q = check.vector("q", self.q, nc * d)
        identity = check.matrix("mass", sparse.eye_array(nc * d), (None, None))
        checked = {
            "friction": mu,
            "q": q,
            "W": check.matrix("W", self.W, (nc * d, nc * d)),
            "friction_bias": check.vector("friction_bias", _or_zeros(self.friction_bias, nc), nc),
            "mass": identity,
            "inverse_mass": identity,
            "free_velocity": check.vector("free_velocity", np.zeros(nc * d)),
            "bias": check.vector("q", q[::d]),
            "joints": check.matrix("joints", sparse.csr_array((0, nc * d)), (None, None)),
            "joint_bias": check.vector("joint_bias", np.zeros(0)),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        require(bool(np.all(mu >= 0)), "friction", "must not be negative")
        require(bool(np.all(self.friction_bias >= 0)), "friction_bias", "must not be negative")
        least, largest = spectrum_ends(self.W)
        require(least >= -INDEFINITE * max(largest, 0.0), "W", "not positive semidefinite")

    @property
    def _given(self) -> tuple[str, ...]:
        return tuple(name for name in super()._given if name not in ("normal", "tangent"))

    @cached_property
    def jacobian(self) -> sparse.csr_array:
        """J (nc*d, nc*d), with J J' the symmetric part of W; dense but for the columns of W's null space, which are empty."""
        value, basis = np.linalg.eigh((self.W + self.W.T).toarray() / 2)
        floor = np.finfo(float).eps * len(value) * abs(value).max(initial=0.0)
        return sparse.csr_array(basis * np.sqrt(np.where(value > floor, value, 0.0)))

    @cached_property
    def scale(self) -> Array:
        """s (nc,): the mean diagonal of each contact's block of W, 1/kg; 1 where it vanishes."""
        return _mean_diagonal(self.W.diagonal(), self.dimension)

    def contact_velocity(self, impulse: Array) -> Array:
        return (apply(self.W, self._rows(impulse)) + self.q).reshape(self.contacts, self.dimension)

    def velocity_size(self, impulse: Array) -> Array:
        return (apply(abs(self.W), np.abs(self._rows(impulse))) + np.abs(self.q)).reshape(self.contacts, self.dimension)

    def velocity_form(self) -> VelocityForm:
        return VelocityForm(self.mass, self.inverse_mass, self.jacobian, self.free_velocity, self.q)

    @cached_property
    def hash(self) -> str:
        named = {"friction": self.friction, "friction_bias": self.friction_bias}
        return content_hash(dimension=self.dimension, W=self.W, q=self.q, **named)


def _or_zeros(value: Any, length: int) -> Any:
    return np.zeros(length) if value is None else value


def _mean_diagonal(diagonal: Array, d: int) -> Array:
    mean = diagonal.reshape(-1, d).mean(axis=1)
    return np.where(mean > 0, mean, 1.0)
