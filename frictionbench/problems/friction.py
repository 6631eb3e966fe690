"""One time step of rigid bodies in contact with Coulomb friction.

In velocities v (nv) and contact impulses r (nc*d, per contact the normal first), with J the contact Jacobian,

    M (v - v*) = J' r + F' lam,      F v + b_F = 0,      u = J v + b,

and at each contact Coulomb's law between its impulse and its velocity u = (u_n, u_t), b acting on u_n alone:

    0 <= u_n  ⟂  r_n >= 0,      |r_t| <= mu r_n + b_f,      r_t opposes u_t with |r_t| = mu r_n + b_f wherever u_t != 0.

Eliminating v and lam leaves the Delassus form u = W r + q with W = J P J', P the inverse mass on the null space of F.
References: Anitescu and Potra 1997; Acary and Brogliato 2008, chapter 10.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from scipy import sparse

from frictionbench.problems import check, sizes
from frictionbench.problems.check import Array, ReadOnly, require
from frictionbench.problems.display import count, extent, html_table
from frictionbench.problems.forms.arrays import CSR, Dense
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.forms.lcp import LCP, content_hash, friction_lcp, tangent_basis
from frictionbench.problems.forms.relaxation import QP, ConeProgram, VelocityForm, relaxation_cone, relaxation_qp
from frictionbench.problems.operators.delassus import DIGITS, DelassusOperator
from frictionbench.problems.operators.mechanical import MechanicalOperator
from frictionbench.problems.rows import ByContact, Index64, Rows

LEAST_BIAS = 1e-12  # of a contact's unit: what a friction bias must be able to do to its velocity, to be part of a program


@dataclass(frozen=True, eq=False, init=False, repr=False)
class FrictionProblem(ReadOnly):
    """A friction problem with nc contacts of dimension d (2 planar, 3 spatial) and nv velocities.

    mass: (nv, nv), symmetric positive definite. normal: (nc, nv). tangent: (nc*(d-1), nv), rows per contact.
    friction: (nc,), >= 0. free_velocity: (nv,), the velocity without any constraint.
    bias: (nc,), m/s, added to the normal velocity: gap/step, or a restitution target.
    friction_bias: (nc,), N s, >= 0: friction available without a normal impulse of this step (Poisson's decompression).
    joints: (nj, nv), joint_bias: (nj,), m/s: bilateral constraints, of any rank, satisfied exactly.

    Everything is checked, copied and made read-only here. Errors: InputError naming the field.

    The bodies enter through the operator alone: of given mechanics, or of a given Delassus matrix (from_delassus), whose
    velocities (nc*d) are those of W's symmetric root with unit mass. Compiled passes work on plain arrays (problems.rows):
    contact_rows, the Jacobian J by contacts, and mass_rows, inverse_rows and joint_rows; scipy's matrices are made on demand.

    >>> import frictionbench as fb
    >>> point = fb.FrictionProblem(  # a point of 2 kg that slides on the floor and falls onto it at 0.1 m/s
    ...     mass=[[2.0, 0.0], [0.0, 2.0]],
    ...     normal=[[0.0, 1.0]],
    ...     tangent=[[1.0, 0.0]],
    ...     friction=[0.5],
    ...     free_velocity=[1.0, -0.1],
    ...     bias=[0.0],
    ... )
    >>> fb.solve(point, "lemke").impulse.round(6).tolist()
    [[0.2, -0.1]]
    """

    dimension: int
    friction: Array
    friction_bias: Array
    operator: MechanicalOperator | DelassusOperator

    def __init__(
        self,
        *,
        mass: Any,
        normal: Any,
        tangent: Any,
        friction: Any,
        free_velocity: Any,
        bias: Any,
        friction_bias: Any = None,
        joints: Any = None,
        joint_bias: Any = None,
        dimension: int = 2,
    ) -> None:
        require(_is_dimension(dimension), "dimension", f"must be 2 or 3, got {dimension!r:.100}")
        mechanics = {
            "normal": normal,
            "tangent": tangent,
            "mass": mass,
            "free_velocity": free_velocity,
            "bias": bias,
            "joints": joints,
            "joint_bias": joint_bias,
        }
        sizes.agree(dimension, mechanics | {"friction": friction, "friction_bias": friction_bias})
        law = _law(friction, friction_bias)
        operator = MechanicalOperator.checked(len(law[0]), dimension, friction_bias=law[1], **mechanics)
        self._assign(dimension, *law, operator)

    @classmethod
    def from_delassus(cls, W: Any, q: Any, friction: Any, d: int, friction_bias: Any = None) -> Self:
        """The problem of which only u = W r + q is known; rows per contact, normal first (FCLIB's order).

        W: (nc*d, nc*d), 1/kg, its symmetric part positive semidefinite; stored as given, also where it is unsymmetric, by what
        `asymmetry` and the summary tell. Methods that work in velocities do not take it then. q: (nc*d,), m/s.
        friction: (nc,).
        Errors: InputError naming the field.

        >>> import frictionbench as fb
        >>> fb.FrictionProblem.from_delassus([[0.5, 0.0], [0.0, 0.5]], [-0.1, 1.0], [0.5], d=2).contacts
        1
        """
        require(_is_dimension(d), "d", f"must be 2 or 3, got {d!r:.100}")
        sizes.agree(d, {"W": W, "q": q, "friction": friction, "friction_bias": friction_bias}, {"dimension": "d"})
        law = _law(friction, friction_bias)
        return object.__new__(cls)._assign(d, *law, DelassusOperator.checked(len(law[0]), d, W, q, law[1]))

    def _assign(self, d: int, friction: Array, friction_bias: Array, operator: MechanicalOperator | DelassusOperator) -> Self:
        """Set the fields, all checked."""
        assign = object.__setattr__  # the class is frozen
        assign(self, "dimension", d)
        assign(self, "friction", friction)
        assign(self, "friction_bias", friction_bias)
        assign(self, "operator", operator)
        return self

    def fresh(self) -> Self:
        """The same problem without anything derived from it, so that the cost of preparing it is incurred again."""
        again = object.__new__(type(self))
        return again._assign(self.dimension, self.friction, self.friction_bias, self.operator.fresh())

    def replace(self, **changes: Any) -> Self:
        """The same problem with some of its fields changed. Errors: InputError naming the field."""
        given = {name: getattr(self, name) for name in self.operator.FIELDS} | changes
        if self.mechanical:
            return type(self)(dimension=self.dimension, **given)
        return self.from_delassus(d=self.dimension, **given)

    @property
    def mechanical(self) -> bool:
        """Whether the mechanics are given; where not, only W and q are."""
        return isinstance(self.operator, MechanicalOperator)

    @property
    def contacts(self) -> int:
        """nc, the number of contacts."""
        return len(self.friction)

    @property
    def mass(self) -> sparse.csr_array:
        """M (nv, nv), read-only, as all matrices."""
        return self.operator.mass

    @property
    def inverse_mass(self) -> sparse.csr_array:
        """M^-1 (nv, nv)."""
        return self.operator.inverse_mass

    @property
    def jacobian(self) -> sparse.csr_array:
        """J (nc*d, nv), rows per contact, normal first."""
        return self.operator.jacobian

    @property
    def normal(self) -> sparse.csr_array:
        """The normal rows of J (nc, nv)."""
        return self.operator.normal

    @property
    def tangent(self) -> sparse.csr_array:
        """The tangent rows of J (nc*(d-1), nv)."""
        return self.operator.tangent

    @property
    def joints(self) -> sparse.csr_array:
        """F (nj, nv)."""
        return self.operator.joints

    @property
    def free_velocity(self) -> Array:
        """v* (nv,)."""
        return self.operator.free_velocity

    @property
    def bias(self) -> Array:
        """b (nc,), m/s."""
        return self.operator.bias

    @property
    def joint_bias(self) -> Array:
        """b_F (nj,), m/s."""
        return self.operator.joint_bias

    @property
    def mass_rows(self) -> Rows:
        """M by rows."""
        return self.operator.mass_rows

    @property
    def inverse_rows(self) -> Rows:
        """M^-1 by rows."""
        return self.operator.inverse_rows

    @property
    def joint_rows(self) -> Rows:
        """F by rows."""
        return self.operator.joint_rows

    @property
    def contact_rows(self) -> ByContact:
        """J by contacts."""
        return self.operator.contact_rows

    @property
    def q(self) -> Array:
        """The free contact velocity with its bias (nc*d,): u where r = 0. Read-only."""
        return self.operator.q

    @property
    def W(self) -> sparse.csr_array:
        """The Delassus matrix J P J' (nc*d, nc*d)."""
        return self.operator.W

    def dense(self) -> Dense:
        """W and q as dense C-contiguous arrays, for code in C or Fortran: formed once, by a compiled pass, and read-only.

        >>> import frictionbench as fb
        >>> W, q = fb.scene("stack", blocks=2).problem().dense()
        >>> W.shape, q.shape, W.flags.c_contiguous
        ((8, 8), (8,), True)
        """
        return self.operator.dense

    def csr(self) -> CSR:
        """W in compressed rows and q, as plain arrays: indptr, indices, data, q; formed once and read-only."""
        return self.operator.csr

    @property
    def blocks(self) -> Blocks:
        """W by blocks of contacts (problems.forms.delassus)."""
        return self.operator.blocks

    @property
    def asymmetry(self) -> float:
        """The largest |W - W'| over the largest |W|; 0 where the mechanics are given."""
        return self.operator.asymmetry

    @property
    def scale(self) -> Array:
        """s (nc,), 1/kg: the mean of the positive diagonal entries of each contact's block of W, where joints lock it of W
        without joints; where none is positive, the mean of all contacts."""
        return self.operator.scale

    @property
    def velocity_scale(self) -> float:
        """max_i |q_i|, m/s."""
        return self.operator.velocity_scale

    @property
    def units(self) -> Array:
        """(nc,), m/s: the velocity in which the residual of each contact is measured (problems.forms.islands): the largest
        closing speed of the contacts of its island that can bear. A solver that stops by one number stops at tol * min(units).
        """
        return self.operator.units

    @cached_property
    def relaxation_units(self) -> Array:
        """(nc,), m/s: those of the convex relaxation: the units at q_n - mu |q_t|, as its impulses have to lift u_n to mu |u_t|
        where a contact slides."""
        q = self.q.reshape(-1, self.dimension).copy()
        q[:, 0] -= self.friction * np.linalg.norm(q[:, 1:], axis=1)
        return self.operator.units_at(q.ravel())

    @property
    def spread(self) -> float:
        """The largest of the units over the smallest; 1 where nothing moves."""
        return self.operator.spread

    def balanced(self, relaxed: bool = False) -> tuple[Self, Array]:
        """The problem with islands that nothing couples in like units, and factor (nc,): impulses r of it are factor r here.

        relaxed: in like units of the convex relaxation. A method whose tolerances are relative to the fastest contact solves
        this one as well for the slow islands.
        """
        operator, factor = self.operator.balanced(self.relaxation_units if relaxed else self.units)
        same = object.__new__(type(self))
        return same._assign(self.dimension, self.friction, operator.friction_bias, operator), factor

    @property
    def islands(self) -> Index64:
        """(nc,): the island of each contact, the connected component of the contact graph, numbered from 0."""
        return self.operator.islands

    @property
    def offset(self) -> Array:
        """u (nc, d) where v = 0."""
        return self.operator.offset

    def velocity(self, impulse: Array) -> Array:
        """v (nv,) after the contact impulses (nc, d) or (nc*d,), the joints' equations satisfied; computed without W."""
        return self.operator.velocity(self._by_contact(impulse))

    def contact_velocity(self, impulse: Array) -> Array:
        """u (nc, d), bias included, after the contact impulses (nc, d) or (nc*d,); of given mechanics computed without W."""
        return self.operator.contact_velocity(self._by_contact(impulse))

    def velocity_size(self, impulse: Array) -> Array:
        """(nc, d): the sum of the absolute values of the terms of contact_velocity; its rounding error is some eps of this."""
        return self.operator.velocity_size(self._by_contact(impulse))

    def _by_contact(self, impulse: Array) -> Array:
        shape = self.contacts, self.dimension
        if (
            type(impulse) is np.ndarray
            and impulse.shape == shape
            and impulse.dtype == np.float64
            and impulse.flags.c_contiguous
        ):
            return impulse
        flat, given = check.entries("impulse", impulse, shape[0] * shape[1]), np.shape(impulse)
        check.require(given == shape or len(given) == 1, "impulse", f"must have shape {shape}, got {given}")
        return flat.reshape(shape)

    def lcp(self, facets: int = 8) -> LCP:
        """The friction LCP of nc (K + 2) unknowns (problems.forms.lcp). Exact in the plane, where K = 2.

        In space the cone's section is an inscribed polygon with K = facets corners.
        Errors: InputError naming facets where they are odd or fewer than 4.
        """
        basis = tangent_basis(self.dimension, facets)
        return friction_lcp(self.blocks, self.q, self.friction, self.friction_bias, basis)

    def qp(self, facets: int = 8) -> QP:
        """The convex relaxation as a quadratic program in the velocities (Anitescu 2006).

        min 1/2 x'Px + q'x with h - G x >= 0 and A x = b, matrices in CSC form. In space the cone's section is a polygon with
        `facets` corners; in the plane facets has no effect.
        """
        return relaxation_qp(self._velocity_form, facets)

    def cone(self) -> ConeProgram:
        """The convex relaxation as a second-order cone program in the velocities (Anitescu and Tasora 2010).

        min 1/2 x'Px + q'x with h - G x in second-order cones {s_0 >= |s_1:|}, one block of d rows for each, and A x = b.
        """
        return relaxation_cone(self._velocity_form)

    @property
    def _velocity_form(self) -> VelocityForm:
        """Without friction biases of rounding's size: in a program their slack would cost nothing, and grow without bound."""
        bias = self.friction_bias
        if bias.any():
            bias = np.where(bias * self.scale > LEAST_BIAS * self.units, bias, 0.0)
        return VelocityForm(
            self.contact_rows,
            self.mass_rows,
            self.free_velocity,
            self.offset,
            self.friction,
            bias,
            self.joint_rows,
            self.joint_bias,
        )

    @cached_property
    def hash(self) -> str:
        """Content hash: equal for equal problems, whatever form the fields were given in."""
        return content_hash(dimension=self.dimension, **{name: getattr(self, name) for name in self.operator.FIELDS})

    @property
    def summary(self) -> str:
        """Its size in words: 9 contacts in space, 40 joint equations, 54 velocities."""
        size = [f"{count(self.contacts, 'contact')} in {'the plane' if self.dimension == 2 else 'space'}"]
        if not self.mechanical:
            off = self.asymmetry
            return f"{size[0]}, known by W" + (f", unsymmetric by {off:.1g}" if off > DIGITS else "")
        if len(self.joint_bias):
            size.append(count(len(self.joint_bias), "joint equation"))
        return ", ".join([*size, count(len(self.free_velocity), "velocity")])

    def __repr__(self) -> str:
        return f"FrictionProblem({self.summary})"

    def _repr_html_(self) -> str:
        rows = {"size": self.summary, "friction": extent(self.friction), "free speeds up to": self.velocity_scale}
        return html_table("FrictionProblem", rows | {"hash": self.hash})


def _is_dimension(value: object) -> bool:
    return isinstance(value, int | np.integer) and value in (2, 3)


def _law(friction: Any, friction_bias: Any) -> tuple[Array, Array]:
    """The coefficients mu and the friction biases (nc,), checked; no friction_bias stands for zeros."""
    mu = check.vector("friction", friction)
    bias = check.vector("friction_bias", np.zeros(len(mu)) if friction_bias is None else friction_bias, len(mu))
    check.not_negative("friction", mu)
    check.not_negative("friction_bias", bias)
    return mu, bias


def require_problem(given: object) -> None:
    """Errors: InputError naming `problem` where it is neither a friction problem nor an LCP."""
    require(isinstance(given, FrictionProblem | LCP), "problem", f"must be a FrictionProblem or an LCP, got {type(given)}")
