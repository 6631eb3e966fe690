"""The equations of motion behind u = W r + q, the affine map from contact impulses r to contact velocities u.

With F the joints' Jacobian, P = M^-1 - M^-1 F' (F M^-1 F')^+ F M^-1 is the inverse mass on the null space of F, and

    W = J P J',      q = J (P M v* - M^-1 F' (F M^-1 F')^+ b_F) + b e_n.

W is formed only on demand. Everything derived is computed once; arrays and matrices are read-only.
"""

from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, ReadOnly
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.balance import factors, mechanical_parts
from frictionbench.problems.forms.delassus import CSR, Blocks, Dense
from frictionbench.problems.forms.islands import islands, lowered, mechanical_graph, mechanical_units, spread
from frictionbench.problems.forms.joints import FEW_EQUATIONS, FewJoints, JointEquations, ManyJoints
from frictionbench.problems.rows import ByContact, Index64, Rows, by_row

NO_ROWS = Rows(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0))  # a matrix without rows
NO_SHIFT = np.zeros(0)
check.set_read_only((NO_ROWS, NO_SHIFT))
Measures = tuple[Array, Array, float, Array, float]  # q, scale, velocity_scale, units and their spread


class Mechanics(ReadOnly):
    """nc contacts of dimension d (2 planar, 3 spatial) and nv velocities, with M (v - v*) = J' r + F' lam, F v + b_F = 0 and
    u = J v + offset.

    The matrices are stored as plain arrays (problems.rows) for compiled code; SciPy's matrices are made from them on demand.

    mass_rows, inverse_rows: M and M^-1 (nv, nv), joint_rows: F (nj, nv), by rows. contact_rows: J (nc*d, nv), by contacts.
    free_velocity: v* (nv,). bias: b (nc,), m/s. joint_bias: b_F (nj,), m/s.
    friction: mu (nc,). friction_bias: b_f (nc,), N s, on which the units depend.
    """

    DEFINED_BY: ClassVar[tuple[str, ...]] = (
        *("dimension", "friction", "friction_bias", "mass_rows", "inverse_rows", "joint_rows"),
        *("free_velocity", "bias", "joint_bias", "contact_rows"),
    )
    dimension: int
    friction: Array
    friction_bias: Array
    mass_rows: Rows
    inverse_rows: Rows
    joint_rows: Rows
    contact_rows: ByContact
    free_velocity: Array
    bias: Array
    joint_bias: Array

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name}: a problem cannot be changed; problem.replace() makes another one")

    def _like(self, **changes: Any) -> Self:
        """A copy without derived data and with changed defining fields, which must be checked and read-only."""
        fields, copy = vars(self), object.__new__(type(self))
        vars(copy).update({name: fields[name] for name in self.DEFINED_BY} | changes)
        return copy

    def fresh(self) -> Self:
        """The same problem without anything derived from it, so that the cost of preparation is incurred again."""
        return self._like()

    @property
    def contacts(self) -> int:
        """nc, the number of contacts."""
        return len(self.friction)

    @cached_property
    def mass(self) -> sparse.csr_array:
        """M (nv, nv). All matrices are read-only."""
        return self._matrix(self.mass_rows)

    @cached_property
    def inverse_mass(self) -> sparse.csr_array:
        """M^-1 (nv, nv)."""
        return self._matrix(self.inverse_rows)

    @cached_property
    def joints(self) -> sparse.csr_array:
        """F (nj, nv)."""
        return self._matrix(self.joint_rows)

    @cached_property
    def jacobian(self) -> sparse.csr_array:
        """J (nc*d, nv), rows per contact, normal first."""
        return self._contact_matrix(0, self.dimension)

    @cached_property
    def normal(self) -> sparse.csr_array:
        """The normal rows of J (nc, nv)."""
        return self._contact_matrix(0, 1)

    @cached_property
    def tangent(self) -> sparse.csr_array:
        """The tangent rows of J (nc*(d-1), nv)."""
        return self._contact_matrix(1, self.dimension)

    def _matrix(self, rows: Rows) -> sparse.csr_array:
        return rows.matrix(len(self.free_velocity))

    def _contact_matrix(self, first: int, end: int) -> sparse.csr_array:
        return self._matrix(Rows(*by_row(*self.contact_rows, first, end)))

    @cached_property
    def offset(self) -> Array:
        """u (nc, d) for v = 0."""
        offset = np.zeros((self.contacts, self.dimension))
        offset[:, 0] = self.bias
        offset.setflags(write=False)
        return offset

    @cached_property
    def q(self) -> Array:
        """The free contact velocity with its bias (nc*d,): u for r = 0. Read-only."""
        return self._motion[0]

    @cached_property
    def W(self) -> sparse.csr_array:
        """The Delassus matrix J P J' (nc*d, nc*d)."""
        W = self.blocks.matrix()
        check.set_read_only(W)
        return W

    @cached_property
    def blocks(self) -> Blocks:
        """W by blocks of contacts (problems.forms.delassus)."""
        free = Blocks(*delassus.delassus(*self.contact_rows, *self.inverse_rows))
        if not self._has_joints:
            return free
        W, (_, locked, lost) = delassus.array_of_blocks(*free) - self._held.coupled(), self._joint_diagonal
        for k in np.flatnonzero(lost & ~locked).tolist():
            W[k] = W[:, k] = self.jacobian @ self._held_response(k)
        W[locked.ravel()] = W[:, locked.ravel()] = 0.0
        return Blocks(*delassus.blocks_of_array(W, self.dimension))

    def dense(self) -> Dense:
        """W and q as dense C-contiguous arrays, for code in C or Fortran: formed once and read-only.

        >>> import frictionbench as fb
        >>> W, q = fb.scene("stack", blocks=2).problem().dense()
        >>> W.shape, q.shape, W.flags.c_contiguous
        ((8, 8), (8,), True)
        """
        return self._dense

    @cached_property
    def _dense(self) -> Dense:
        return self.blocks.dense(self.q)

    def csr(self) -> CSR:
        """W in compressed rows (CSR) and q, as plain arrays: indptr, indices, data, q; formed once and read-only."""
        return self._csr

    @cached_property
    def _csr(self) -> CSR:
        return self.blocks.csr(self.q)

    @property
    def asymmetry(self) -> float:
        """The largest |W - W'| divided by the largest |W|; 0 if the mechanics are given."""
        return 0.0

    @property
    def scale(self) -> Array:
        """s (nc,), 1/kg: the mean of the positive diagonal entries of each contact's block of W. If joints lock the contact, W
        without joints is used; if no entry is positive, the mean of all contacts."""
        return self._motion[1]

    @property
    def velocity_scale(self) -> float:
        """max_i |q_i|, m/s."""
        return self._motion[2]

    @property
    def units(self) -> Array:
        """(nc,), m/s: the velocity relative to which the residual of each contact is measured (problems.forms.islands), the
        largest closing speed of the contacts of its island that can carry load. A solver with a single tolerance for all
        contacts stops at tol * min(units)."""
        return self._measures[3]

    @property
    def spread(self) -> float:
        """The largest of the units divided by the smallest; 1 if nothing moves."""
        return self._measures[4]

    @property
    def _motion(self) -> Measures:
        """Measures of which only q, scale and velocity_scale are used: these are equal for both laws, so that those of the
        relaxation serve if they have been computed already."""
        return self._relaxed_measures if "_relaxed_measures" in vars(self) else self._measures

    @cached_property
    def _measures(self) -> Measures:
        return self._measured(NO_SHIFT)

    @cached_property
    def _relaxed_measures(self) -> Measures:
        return self._measured(self.friction)

    def _measured(self, mu: Array) -> Measures:
        """q, scale, velocity_scale, units and their spread, computed together in one pass over the contacts: those of Coulomb's
        law, with mu (nc,) those of the convex relaxation."""
        free, bodies = self._on_joints(self.free_velocity), (*self.contact_rows, *self.inverse_rows)
        if not self._has_joints:
            measured: Measures = delassus.measures(*bodies, free, self.bias, self.friction_bias, mu)
            check.set_read_only((measured[0], measured[3]))
            return measured
        diagonal, locked, _ = self._joint_diagonal
        by_contact: Array = delassus.contact_velocity(*self.contact_rows, free, self.bias)
        terms = delassus.velocity_size(*bodies, self._moves, np.zeros(diagonal.shape), self.bias)
        by_contact[locked & (np.abs(by_contact) <= delassus.LOCKED * terms)] = 0.0
        q, scale = by_contact.ravel(), delassus.mean_diagonal(diagonal)
        units, _ = self._units_at(lowered(q, mu) if len(mu) else q, scale)
        check.set_read_only((q, units))
        return q, scale, delassus.largest(q, self.dimension), units, spread(units)

    def _units_at(self, q: Array, scale: Array) -> tuple[Array, Index64]:
        """The units (nc,) for free contact velocities q (nc*d,), and the islands (nc,) of contacts that share a unit."""
        return mechanical_units(*self._bodies, self._moves, self.bias, q, scale, self.friction_bias)

    @cached_property
    def _moves(self) -> Array:
        """(nv,): the sum of the absolute values of the terms of each velocity, for bounds on rounding errors."""
        moves = np.abs(self.free_velocity)
        return moves + self._held.rounding(self.free_velocity) if self._has_joints else moves

    @property
    def _bodies(self) -> tuple[NDArray[Any], ...]:
        """J by contacts, M^-1 by rows, and the sparsity pattern of F."""
        return *self.contact_rows, *self.inverse_rows, self.joint_rows.start, self.joint_rows.column

    @property
    def relaxation_units(self) -> Array:
        """(nc,), m/s: the units of the convex relaxation. They are those at q_n - mu |q_t|, because its impulses must raise u_n
        to mu |u_t| at a sliding contact."""
        return self._relaxed_measures[3]

    @property
    def relaxation_spread(self) -> float:
        """The spread of the relaxation's units."""
        return self._relaxed_measures[4]

    @cached_property
    def bearing_islands(self) -> Index64:
        """(nc,), labels below 2 nc + nv: contacts with equal labels are connected by contacts that can carry load."""
        return self._units_at(self.q, self.scale)[1]

    @cached_property
    def islands(self) -> Index64:
        """(nc,): the island of each contact, the connected component of the contact graph, numbered from 0."""
        return islands(*mechanical_graph(*self._bodies, self.scale))

    def balanced(self, relaxed: bool = False) -> tuple[Self, Array]:
        """The problem with its uncoupled parts scaled to similar units, and factor (nc,), by which its impulses are multiplied
        to give those of this problem.

        relaxed: scale by the units of the convex relaxation. A method with tolerances relative to the fastest contact solves
        the slow parts of the balanced problem as accurately as the fast ones.
        """
        factor = factors(self.parts, self.relaxation_units if relaxed else self.units)
        of_contacts = factor[: self.contacts]
        biases = self._over(factor) | {"bias": self.bias / of_contacts, "friction_bias": self.friction_bias / of_contacts}
        check.set_read_only(tuple(biases.values()))
        return self._like(**biases), of_contacts

    def _over(self, factor: Array) -> dict[str, Array]:
        """The fields that are velocities, except the contacts' bias, divided by the factors of the entries of parts."""
        of_velocities, of_joints = np.split(factor[self.contacts :], [len(self.free_velocity)])
        return {"free_velocity": self.free_velocity / of_velocities, "joint_bias": self.joint_bias / of_joints}

    @cached_property
    def parts(self) -> Index64:
        """The part of each contact (nc,), numbered from 0. If the problem is mechanical, the parts of the velocities and of the
        joint equations follow, with -1 for those that are not connected to any contact."""
        J, M, F = self.contact_rows, self.mass_rows, self.joint_rows
        return mechanical_parts(J.start, J.column, M.start, M.column, F.start, F.column)

    def velocity(self, impulse: Array) -> Array:
        """v (nv,) after the contact impulses (nc, d) or (nc*d,), which satisfies the joint equations; computed without W."""
        return self._on_joints(self._pushed(self._by_contact(impulse)))

    def contact_velocity(self, impulse: Array) -> Array:
        """u (nc, d), bias included, after the contact impulses (nc, d) or (nc*d,); computed without W if mechanical."""
        r = self._by_contact(impulse)
        if not self._has_joints:
            return delassus.pushed_contact_velocity(*self.contact_rows, *self.inverse_rows, self.free_velocity, r, self.bias)
        u = delassus.contact_velocity(*self.contact_rows, self._on_joints(self._pushed(r)), self.bias)
        np.copyto(u, self.q.reshape(u.shape), where=self._joint_diagonal[1])  # directions that joints lock
        return u

    def velocity_size(self, impulse: Array) -> Array:
        """(nc, d): the sum of the absolute values of the terms of contact_velocity, whose rounding error is a few eps of it."""
        r, free = self._by_contact(impulse), self.free_velocity
        if self._has_joints:
            free = np.abs(free) + self._held.rounding(self._pushed(r))
        return delassus.velocity_size(*self.contact_rows, *self.inverse_rows, free, r, self.bias)

    def _by_contact(self, impulse: Array) -> Array:
        shape = self.contacts, self.dimension
        fits = type(impulse) is np.ndarray and impulse.shape == shape and impulse.dtype == np.float64
        if fits and impulse.flags.c_contiguous:
            return impulse
        flat, actual = check.entries("impulse", impulse, shape[0] * shape[1]), np.shape(impulse)
        check.require(actual == shape or len(actual) == 1, "impulse", f"must have shape {shape}, got {actual}")
        return flat.reshape(shape)

    def _pushed(self, r: Array) -> Array:
        """v (nv,) after the contact impulses r (nc, d), without the joints."""
        return delassus.velocity(*self.contact_rows, *self.inverse_rows, self.free_velocity, r)

    def _on_joints(self, velocity: Array) -> Array:
        """The velocity v nearest to the given one in the kinetic metric, subject to F v + b_F = 0."""
        return self._held.hold(velocity) if self._has_joints else velocity

    @property
    def _has_joints(self) -> bool:
        return len(self.joint_rows.start) > 1

    @cached_property
    def _held(self) -> JointEquations:
        """The joint equations with an inverse of F M^-1 F'."""
        inverted = FewJoints if len(self.joint_bias) <= FEW_EQUATIONS else ManyJoints
        return inverted(self.joint_rows, self.joint_bias, self.inverse_rows, self.contact_rows)

    @cached_property
    def _joint_diagonal(self) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
        """The diagonal of W, the locked directions and the directions with cancellation, each (nc, d). In a locked direction
        joints prevent any change of velocity, so that W's diagonal is a rounding error. It is 0 here, or that of W without
        joints if the whole contact is locked. `_held_response` computes W's rows in the directions with cancellation."""
        diagonal: Array = delassus.diagonal(*self.contact_rows, *self.inverse_rows)
        held, terms = (share.reshape(diagonal.shape) for share in self._held.shares())
        left = diagonal - held
        lost: NDArray[np.bool_] = (left <= delassus.LOST * (diagonal + terms)) & (diagonal > 0)
        for k in np.flatnonzero(lost).tolist():
            left.flat[k] = (self.jacobian[[k]] @ self._held_response(k))[0]
        locked: NDArray[np.bool_] = left <= delassus.LOCKED * diagonal
        return np.where(locked.all(axis=1, keepdims=True), diagonal, np.where(locked, 0.0, left)), locked, lost

    def _held_response(self, k: int) -> Array:
        """P J_k' (nv,) for row k of J, accurate to rounding even if it is a small difference of large terms."""
        pushed = self.inverse_mass @ self.jacobian[[k]].toarray()[0]
        return self._held.hold(self._held.hold(pushed, 0.0), 0.0)
