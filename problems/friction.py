"""One time step of rigid bodies in contact with Coulomb friction.

In velocities v (nv) and contact impulses r (nc*d, per contact the normal first), with J the contact Jacobian,

    M (v - v*) = J' r + F' lam,      F v + b_F = 0,      u = J v + b,

and at each contact Coulomb's law between its impulse and its velocity u = (u_n, u_t), b acting on u_n alone:

    0 <= u_n  ⟂  r_n >= 0,      |r_t| <= mu r_n + b_f,      r_t opposes u_t with |r_t| = mu r_n + b_f wherever u_t != 0.

Eliminating v and lam leaves the Delassus form u = W r + q with W = J P J', P the inverse mass on the null space of F.
References: Anitescu and Potra 1997; Acary and Brogliato 2008, chapter 10.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache, cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.definite import spectrum_ends
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.forms.lcp import LCP, content_hash, friction_lcp, tangent_basis
from frictionbench.problems.forms.mass import inverse_mass
from frictionbench.problems.forms.relaxation import QP, ConeProgram, VelocityForm, relaxation_cone, relaxation_qp
from frictionbench.problems.rows import ByContact, Rows, by_contact, by_row

LOCKED = 1000 * float(np.finfo(float).eps)  # of what adds up to a diagonal of W: round-off was seen up to 160, else from 1e9
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

    Compiled passes work on plain arrays (problems.rows): contact_rows, the Jacobian J by contacts, and mass_rows,
    inverse_rows and joint_rows. The matrices as scipy has them are made when they are asked for.
    """

    mass: sparse.csr_array
    normal: sparse.csr_array
    tangent: sparse.csr_array
    friction: Array
    free_velocity: Array
    bias: Array
    friction_bias: Array = None  # type: ignore[assignment]  # None stands for zeros
    joints: sparse.csr_array = field(default_factory=lambda: None)  # none
    joint_bias: Array = None  # type: ignore[assignment]  # zeros
    dimension: int = 2
    contact_rows: ByContact = field(init=False, repr=False)
    mass_rows: Rows = field(init=False, repr=False)
    inverse_rows: Rows = field(init=False, repr=False)
    joint_rows: Rows = field(init=False, repr=False)

    def __post_init__(self) -> None:
        d, given = self.dimension, self.__dict__
        require(d in (2, 3), "dimension", f"must be 2 or 3, got {d!r}")
        mu = check.vector("friction", self.friction)
        v = check.vector("free_velocity", self.free_velocity)
        nc, nv = len(mu), len(v)
        joints, mass, normal, tangent = (given.pop(name) for name in _MATRICES)
        joint_rows = _NO_ROWS if joints is None else check.rows("joints", joints, (None, nv))
        nj = len(joint_rows.start) - 1
        mass_rows = check.rows("mass", mass, (nv, nv))
        normal_rows = check.rows("normal", normal, (nc, nv))
        tangent_rows = check.rows("tangent", tangent, (nc * (d - 1), nv))
        bias = check.vector("bias", self.bias, nc)
        friction_bias = check.vector("friction_bias", _or_zeros(self.friction_bias, nc), nc)
        joint_bias = check.vector("joint_bias", _or_zeros(self.joint_bias, nj), nj)
        check.not_negative("friction", mu)
        check.not_negative("friction_bias", friction_bias)
        given.update(
            friction=mu,
            free_velocity=v,
            bias=bias,
            friction_bias=friction_bias,
            joint_bias=joint_bias,
            contact_rows=ByContact(*by_contact(*normal_rows, *tangent_rows, d)),
            mass_rows=mass_rows,
            inverse_rows=inverse_mass(mass_rows),
            joint_rows=joint_rows,
        )

    def __getattr__(self, name: str) -> sparse.csr_array:
        """A matrix as scipy has it, read-only, made when it is first asked for."""
        if name not in _VIEWS or "mass_rows" not in self.__dict__:
            raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}")
        view = self.__dict__[name] = _VIEWS[name](self).matrix(len(self.free_velocity))
        return view

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
        given = self.__dict__
        again.__dict__.update({name: given[name] for name in _given(self.__class__)})  # type: ignore[arg-type]
        return again

    @property
    def contacts(self) -> int:
        """nc, the number of contacts."""
        return len(self.friction)

    @cached_property
    def _joint_response(self) -> tuple[Array, Array]:
        """(M^-1 F', (F M^-1 F')^+), dense; joints are few, and may be redundant."""
        response = delassus.joint_response(*self.joint_rows, *self.inverse_rows)
        return response, np.linalg.pinv(delassus.product(*self.joint_rows, response), hermitian=True)

    @property
    def _joint_coupling(self) -> tuple[Array, Array]:
        """(F M^-1 J', (F M^-1 F')^+), dense."""
        response, inverse = self._joint_response
        return delassus.coupling(*self.contact_rows, response), inverse

    def _on_joints(self, velocity: Array, bias: Array) -> Array:
        """The velocity nearest in the kinetic metric with F v + bias = 0."""
        if not self._has_joints:
            return velocity
        response, inverse = self._joint_response
        apart = delassus.product(*self.joint_rows, velocity[:, None].copy())[:, 0]
        return velocity - response @ (inverse @ (apart + bias))

    def velocity(self, impulse: Array) -> Array:
        """v (nv,) after the contact impulses (nc, d) or (nc*d,), joints kept; computed without W."""
        r = self._by_contact(impulse)
        pushed = delassus.velocity(*self.contact_rows, *self.inverse_rows, self.free_velocity, r)
        return self._on_joints(pushed, self.joint_bias)

    def contact_velocity(self, impulse: Array) -> Array:
        """u (nc, d), bias included, after the contact impulses (nc, d); computed without W."""
        if not self._has_joints:
            rows = *self.contact_rows, *self.inverse_rows
            return delassus.pushed_contact_velocity(*rows, self.free_velocity, self._by_contact(impulse), self.bias)
        u = delassus.contact_velocity(*self.contact_rows, self.velocity(impulse), self.bias)
        np.copyto(u, self.q.reshape(u.shape), where=self._locked)
        return u

    def _by_contact(self, impulse: Array) -> Array:
        shape = self.contacts, self.dimension
        if (
            type(impulse) is np.ndarray
            and impulse.shape == shape
            and impulse.dtype == np.float64
            and impulse.flags.c_contiguous
        ):
            return impulse
        return check.entries("impulse", impulse, shape[0] * shape[1]).reshape(shape)

    def velocity_size(self, impulse: Array) -> Array:
        """(nc, d): the size of the terms that add up to contact_velocity, of whose sum rounding takes some eps."""
        rows = *self.contact_rows, *self.inverse_rows
        size = delassus.velocity_size(*rows, self.free_velocity, self._by_contact(impulse))
        if self._has_joints:
            pushed = delassus.velocity(*rows, self.free_velocity, self._by_contact(impulse))
            response, inverse = self._joint_response
            held = abs(self.joints) @ np.abs(pushed) + np.abs(self.joint_bias)
            size += (abs(self.jacobian) @ (np.abs(response) @ (np.abs(inverse) @ held))).reshape(size.shape)
        size[:, 0] += np.abs(self.bias)
        return size

    def _measured(self, name: str) -> Any:
        """q, scale or fastest; all three are kept."""
        q, scale, fastest = self._measures()
        q.setflags(write=False)
        self.__dict__.update(q=q, scale=scale, fastest=fastest)
        return self.__dict__[name]

    def _measures(self) -> tuple[Array, Array, float]:
        free = self._on_joints(self.free_velocity, self.joint_bias)
        measures = delassus.measures(*self.contact_rows, *self.inverse_rows, free, self.bias)
        if not self._has_joints:
            return measures
        q = measures[0].reshape(self.contacts, self.dimension)
        q[self._locked & (np.abs(q) <= LOCKED * self.velocity_size(np.zeros_like(q)))] = 0.0
        diagonal = delassus.diagonal(*self.contact_rows, *self.inverse_rows)
        coupling, inverse = self._joint_coupling
        held = diagonal - np.einsum("ji,jk,ki->i", coupling, inverse, coupling).reshape(diagonal.shape)
        held[self._locked] = 0.0
        diagonal = np.where(self._locked.all(axis=1, keepdims=True), diagonal, held)
        return q.ravel(), delassus.mean_diagonal(diagonal), delassus.largest(q.ravel(), self.dimension)

    @cached_property
    def q(self) -> Array:
        """The free contact velocity with its bias (nc*d,): u where r = 0. Read-only, as where it is given."""
        return self._measured("q")

    @cached_property
    def blocks(self) -> Blocks:
        """W by blocks of contacts (problems.forms.delassus)."""
        if not self._has_joints:
            return Blocks(*delassus.delassus(*self.contact_rows, *self.inverse_rows))
        return delassus.blocks(self.W, self.dimension)

    @cached_property
    def W(self) -> sparse.csr_array:
        """The Delassus matrix J P J' (nc*d, nc*d), sparse."""
        if not self._has_joints:
            return self.blocks.matrix()
        W = Blocks(*delassus.delassus(*self.contact_rows, *self.inverse_rows)).matrix()
        coupling, inverse = self._joint_coupling
        moves = sparse.diags_array((~self._locked).astype(float).ravel())
        W = sparse.csr_array(moves @ (W - sparse.csr_array(coupling.T @ inverse @ coupling)) @ moves)
        W.eliminate_zeros()
        return W

    @cached_property
    def scale(self) -> Array:
        """s (nc,): the mean diagonal of each contact's block of W, 1/kg, where joints lock it of W without joints; 1 where
        that vanishes, too."""
        return self._measured("scale")

    @cached_property
    def _locked(self) -> NDArray[np.bool_]:
        """(nc, d): the directions in which joints leave a contact no velocity that impulses could change: W's diagonal is what
        rounding left of its parts."""
        coupling, inverse = self._joint_coupling
        diagonal = delassus.diagonal(*self.contact_rows, *self.inverse_rows).ravel()
        held = np.einsum("ji,jk,ki->i", coupling, inverse, coupling)
        size = diagonal + np.einsum("ji,jk,ki->i", np.abs(coupling), np.abs(inverse), np.abs(coupling))
        return (diagonal - held <= LOCKED * size).reshape(self.contacts, self.dimension)

    @cached_property
    def fastest(self) -> float:
        """max_i |q_i|, the unit of the residual."""
        return self._measured("fastest")

    @property
    def _has_joints(self) -> bool:
        return len(self.joint_rows.start) > 1

    def lcp(self, facets: int = 8) -> LCP:
        """The friction LCP. Exact in the plane; in space the cone's section is a polygon inscribed with `facets` corners."""
        basis = tangent_basis(self.dimension, facets)
        return friction_lcp(self.blocks, self.q, self.friction, self.friction_bias, basis)

    def qp(self, facets: int = 8) -> QP:
        """The convex relaxation as a quadratic program in the velocities (Anitescu 2006); polygonal in space."""
        return relaxation_qp(self._law, facets)

    def cone(self) -> ConeProgram:
        """The convex relaxation as a second-order cone program in the velocities (Anitescu and Tasora 2010)."""
        return relaxation_cone(self._law)

    @property
    def _law(self) -> VelocityForm:
        return VelocityForm(
            self.contact_rows,
            self.mass_rows,
            self.free_velocity,
            self.offset,
            self.friction,
            self.friction_bias,
            self.joint_rows,
            self.joint_bias,
        )

    @cached_property
    def offset(self) -> Array:
        """u (nc, d) where v = 0: the bias along the normal."""
        offset = np.zeros((self.contacts, self.dimension))
        offset[:, 0] = self.bias
        offset.setflags(write=False)
        return offset

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal problems, whatever form the fields came in."""
        names = ("mass", "normal", "tangent", "friction", "free_velocity", "bias", "friction_bias", "joints", "joint_bias")
        return content_hash(dimension=self.dimension, **{name: getattr(self, name) for name in names})


@cache
def _given(kind: Any) -> tuple[str, ...]:
    """The attributes that make a problem of this kind what it is."""
    derived = (*_MATRICES, "contact_rows") if kind is DelassusProblem else _MATRICES
    return tuple(entry.name for entry in fields(kind) if entry.name not in derived)


_MATRICES = ("joints", "mass", "normal", "tangent")
_NO_ROWS = Rows(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0))
_VIEWS: dict[str, Callable[[FrictionProblem], Rows]] = {
    "mass": lambda problem: problem.mass_rows,
    "inverse_mass": lambda problem: problem.inverse_rows,
    "joints": lambda problem: problem.joint_rows,
    "jacobian": lambda problem: Rows(*by_row(*problem.contact_rows, 0, problem.dimension)),
    "normal": lambda problem: Rows(*by_row(*problem.contact_rows, 0, 1)),
    "tangent": lambda problem: Rows(*by_row(*problem.contact_rows, 1, problem.dimension)),
}


def _root(problem: "DelassusProblem") -> ByContact:
    """J (nc*d, nc*d), with J J' the symmetric part of W; dense but for the columns of W's null space, which are empty."""
    value, basis = np.linalg.eigh((problem.W + problem.W.T).toarray() / 2)
    floor = np.finfo(float).eps * len(value) * abs(value).max(initial=0.0)
    root = (basis * np.sqrt(np.where(value > floor, value, 0.0))).reshape(problem.contacts, problem.dimension, len(value))
    normal, tangent = root[:, :1].reshape(-1, len(value)), root[:, 1:].reshape(-1, len(value))
    rows = *check.rows("W", normal, normal.shape), *check.rows("W", tangent, tangent.shape)
    return ByContact(*by_contact(*rows, problem.dimension))


_ROOT: Any = cached_property(_root)


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
    normal: sparse.csr_array = field(init=False, repr=False)
    tangent: sparse.csr_array = field(init=False, repr=False)
    joints: sparse.csr_array = field(init=False, repr=False)
    free_velocity: Array = field(init=False, repr=False)
    bias: Array = field(init=False, repr=False)
    joint_bias: Array = field(init=False, repr=False)
    contact_rows: ByContact = field(init=False, repr=False, default=_ROOT)

    def __post_init__(self) -> None:
        d = self.dimension
        require(d in (2, 3), "dimension", f"must be 2 or 3, got {d!r}")
        mu = check.vector("friction", self.friction)
        nc = len(mu)
        q = check.vector("q", self.q, nc * d)
        W = check.matrix("W", self.W, (nc * d, nc * d))
        friction_bias = check.vector("friction_bias", _or_zeros(self.friction_bias, nc), nc)
        check.not_negative("friction", mu)
        check.not_negative("friction_bias", friction_bias)
        identity = Rows(np.arange(len(q) + 1, dtype=np.int32), np.arange(len(q), dtype=np.int32), np.ones(len(q)))
        self.__dict__.update(
            friction=mu,
            q=q,
            W=W,
            friction_bias=friction_bias,
            mass_rows=identity,
            inverse_rows=identity,
            free_velocity=check.vector("free_velocity", np.zeros(nc * d)),
            bias=check.vector("q", q[::d]),
            joint_rows=_NO_ROWS,
            joint_bias=check.vector("joint_bias", np.zeros(0)),
        )
        least, largest = spectrum_ends(self.W)
        require(least >= -INDEFINITE * max(largest, 0.0), "W", "not positive semidefinite")

    @cached_property
    def scale(self) -> Array:
        """s (nc,): the mean diagonal of each contact's block of W, 1/kg; 1 where it vanishes."""
        return delassus.mean_diagonal(self.W.diagonal().reshape(-1, self.dimension))

    @cached_property
    def fastest(self) -> float:
        return float(delassus.largest(self.q, self.dimension))

    @cached_property
    def blocks(self) -> Blocks:
        return delassus.blocks(self.W, self.dimension)

    @cached_property
    def offset(self) -> Array:
        return self.q.reshape(-1, self.dimension)

    def contact_velocity(self, impulse: Array) -> Array:
        return delassus.act(*self.blocks, self._by_contact(impulse), self.offset)

    def velocity_size(self, impulse: Array) -> Array:
        first, beside, block = self.blocks
        return delassus.act(first, beside, np.abs(block), np.abs(self._by_contact(impulse)), np.abs(self.offset))

    @cached_property
    def hash(self) -> str:
        named = {"friction": self.friction, "friction_bias": self.friction_bias}
        return content_hash(dimension=self.dimension, W=self.W, q=self.q, **named)


def _or_zeros(value: Any, length: int) -> Any:
    return np.zeros(length) if value is None else value
