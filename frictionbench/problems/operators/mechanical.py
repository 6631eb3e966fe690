"""The contact operator of given mechanics: a mass matrix, contact Jacobian and joints, of which W is formed only on demand.

With F the joints' Jacobian, P = M^-1 - M^-1 F' (F M^-1 F')^+ F M^-1 is the inverse mass on the null space of F, and

    W = J P J',      q = J (P M v* - M^-1 F' (F M^-1 F')^+ b_F) + b e_n.

Joints may be redundant: the inverse is a generalised one, dense for few equations (few_joints) and of a band for many
(many_joints). Redundant equations must agree: where F v + b_F = 0 has no solution, no impulses satisfy it, and the problem is
refused.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.balance import mechanical_factors
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.forms.islands import islands, mechanical_graph, mechanical_units, spread
from frictionbench.problems.forms.mass import inverse_mass
from frictionbench.problems.operators.few_joints import FewJoints
from frictionbench.problems.operators.many_joints import ManyJoints
from frictionbench.problems.operators.operator import NO_ROWS, Operator
from frictionbench.problems.rows import ByContact, Index64, Rows, by_contact

# Of a joint's bias: a larger defect is a contradiction. It is the tightest tolerance of the suites.
CONTRADICTION = 1e-8
# Of the largest terms of any joint equation, as speeds of unit kinetic energy: what rounding leaves.
ROUNDING = 1000 * float(np.finfo(float).eps)

FEW = 100  # joint equations up to which a dense inverse is as fast as a factorisation of a band


@dataclass(eq=False, repr=False)
class MechanicalOperator(Operator):
    """The operator of M (v - v*) = J' r + F' lam, F v + b_F = 0 and u = J v + b e_n; see Operator for the fields."""

    FIELDS: ClassVar[tuple[str, ...]] = (
        *("mass", "normal", "tangent", "friction", "free_velocity", "bias", "friction_bias", "joints", "joint_bias"),
    )
    mass_rows: Rows
    inverse_rows: Rows
    joint_rows: Rows
    contact_rows: ByContact
    free_velocity: Array
    bias: Array
    friction_bias: Array
    joint_bias: Array

    @classmethod
    def checked(
        cls, nc: int, d: int, mass: Any, normal: Any, tangent: Any, free_velocity: Any, bias: Any, friction_bias: Array,
        joints: Any, joint_bias: Any,
    ) -> Self:  # fmt: skip
        """The operator of nc contacts of dimension d, of checked copies; joints and joint_bias may be None.

        Errors: InputError naming the field.
        """
        v = check.vector("free_velocity", free_velocity)
        nv = len(v)
        joint_rows = NO_ROWS if joints is None else check.rows("joints", joints, (None, nv))
        nj = len(joint_rows.start) - 1
        mass_rows = check.rows("mass", mass, (nv, nv))
        normal_rows = check.rows("normal", normal, (nc, nv))
        tangent_rows = check.rows("tangent", tangent, (nc * (d - 1), nv))
        b = check.vector("bias", bias, nc)
        b_F = check.vector("joint_bias", np.zeros(nj) if joint_bias is None else joint_bias, nj)
        contact_rows = ByContact(*by_contact(*normal_rows, *tangent_rows, d))
        operator = cls(mass_rows, inverse_mass(mass_rows), joint_rows, contact_rows, v, b, friction_bias, b_F)
        if nj:
            operator._require_joints_that_hold()
        return operator

    @property
    def asymmetry(self) -> float:
        return 0.0

    def fresh(self) -> Self:
        rows = self.mass_rows, self.inverse_rows, self.joint_rows, self.contact_rows
        return type(self)(*rows, self.free_velocity, self.bias, self.friction_bias, self.joint_bias)

    @property
    def q(self) -> Array:  # type: ignore[override]
        return self._measures[0]

    @property
    def scale(self) -> Array:
        return self._measures[1]

    @property
    def velocity_scale(self) -> float:
        return self._measures[2]

    @property
    def units(self) -> Array:
        return self._measures[3]

    def units_at(self, q: Array) -> Array:
        units: Array = mechanical_units(*self._bodies, self._moves, self.bias, q, self.scale, self.friction_bias)
        return units

    @property
    def _moves(self) -> Array:
        """(nv,): the size of the terms of each velocity."""
        moves = np.abs(self.free_velocity)
        return moves + self._held.rounding(self.free_velocity) if self._has_joints else moves

    @property
    def spread(self) -> float:
        return self._measures[4]

    def balanced(self, units: Array) -> tuple[Self, Array]:
        joints = self.joint_rows.start, self.joint_rows.column
        factor, by_velocity = mechanical_factors(
            self.contact_rows.start, self.contact_rows.column, *self.mass_rows[:2], *joints, units
        )
        joint_bias = self.joint_bias / by_velocity[self.joint_rows.column[self.joint_rows.start[:-1]]]
        rows = self.mass_rows, self.inverse_rows, self.joint_rows, self.contact_rows
        laws = self.free_velocity / by_velocity, self.bias / factor, self.friction_bias / factor, joint_bias
        check.set_read_only(laws)
        return type(self)(*rows, *laws), factor

    @cached_property
    def islands(self) -> Index64:
        return islands(*mechanical_graph(*self._bodies, self.scale))

    @property
    def _bodies(self) -> tuple[NDArray[Any], ...]:
        """J by contacts, M^-1 by rows, and where the joints have their entries."""
        return *self.contact_rows, *self.inverse_rows, self.joint_rows.start, self.joint_rows.column

    @cached_property
    def offset(self) -> Array:
        offset = np.zeros((len(self.bias), self.contact_rows.value.shape[1]))
        offset[:, 0] = self.bias
        offset.setflags(write=False)
        return offset

    @cached_property
    def blocks(self) -> Blocks:  # type: ignore[override]
        return delassus.blocks(self.W, self.contact_rows.value.shape[1]) if self._has_joints else self._free_blocks()

    @cached_property
    def W(self) -> sparse.csr_array:
        if not self._has_joints:
            return self.blocks.matrix()
        moves = sparse.diags_array((~self._locked).astype(float).ravel())
        W = self._free_blocks().matrix() - sparse.csr_array(self._held.coupled())
        W = sparse.csr_array(moves @ W @ moves)
        W.eliminate_zeros()
        return W

    def velocity(self, r: Array) -> Array:
        """v (nv,) after the contact impulses r (nc, d), the joints' equations satisfied; computed without W."""
        return self._on_joints(super().velocity(r))

    def contact_velocity(self, r: Array) -> Array:
        if not self._has_joints:
            return delassus.pushed_contact_velocity(*self.contact_rows, *self.inverse_rows, self.free_velocity, r, self.bias)
        u = delassus.contact_velocity(*self.contact_rows, self.velocity(r), self.bias)
        np.copyto(u, self.q.reshape(u.shape), where=self._locked)
        return u

    def velocity_size(self, r: Array) -> Array:
        size: Array = delassus.velocity_size(*self.contact_rows, *self.inverse_rows, self.free_velocity, r, self.bias)
        if self._has_joints:
            size += (abs(self.jacobian) @ self._held.rounding(super().velocity(r))).reshape(size.shape)
        return size

    @property
    def _has_joints(self) -> bool:
        return len(self.joint_rows.start) > 1

    def _free_blocks(self) -> Blocks:
        """J M^-1 J': W without the joints."""
        return Blocks(*delassus.delassus(*self.contact_rows, *self.inverse_rows))

    @cached_property
    def _held(self) -> FewJoints | ManyJoints:
        """The joints' equations with an inverse of F M^-1 F'."""
        if len(self.joint_bias) <= FEW:
            return FewJoints(self.joint_rows, self.joint_bias, self.inverse_rows, self.contact_rows)
        return ManyJoints(self.joints, self.joint_bias, self.inverse_mass, self.jacobian)

    def _on_joints(self, velocity: Array) -> Array:
        """The velocity nearest in the kinetic metric with F v + b_F = 0."""
        return self._held.hold(velocity) if self._has_joints else velocity

    @cached_property
    def _joint_units(self) -> Array:
        """(nj,) the speed that a unit of kinetic energy gives each joint, 1 for rows of zeros, with the diagonal of M^-1."""
        size = np.sqrt(self.joints.multiply(self.joints) @ self.inverse_mass.diagonal())
        return np.where(size > 0, size, 1.0)

    def _require_joints_that_hold(self) -> None:
        """Errors: InputError naming joint_bias where the equations contradict each other, joints where rounding breaks them."""
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows compares as false and is refused
            if self.joint_bias.any():  # without biases, v = 0 satisfies all
                self._require_consistent_joints()
            self._require_held_joints()

    def _require_consistent_joints(self) -> None:
        """Errors: InputError naming joint_bias where no velocity satisfies F v + b_F = 0, by more than rounding explains.

        Whether one does depends on F and b_F alone. With each row in its own unit, the velocity of least squares is compared
        with the rounding of its terms and of those of F v*.
        """
        unit = self._joint_units
        F, bias = self.joints, self.joint_bias / unit
        check.require(bool(np.isfinite(bias).all()), "joints", "b_F overflows")
        v = self._held.solution()
        terms = abs(F) @ (np.abs(v) + np.abs(self.free_velocity)) / unit + np.abs(bias)
        defect = np.abs(F @ v / unit + bias)
        bad = np.flatnonzero(~(defect <= np.maximum(CONTRADICTION * np.abs(bias), ROUNDING * terms.max())))
        listed = ", ".join(map(str, bad[:6].tolist())) + ", ..." * (len(bad) > 6)
        missed = f"rows {listed} are missed by up to {(defect * unit)[bad].max(initial=0.0):.2g} m/s"
        check.require(not len(bad), "joint_bias", f"the joint equations contradict each other: {missed}")

    def _require_held_joints(self) -> None:
        """Errors: InputError naming joints where rounding leaves F v + b_F, of the nearest velocity, above CONTRADICTION of its
        terms, each row in its own unit: of rows that are nearly dependent the inverse has too few digits."""
        F, v = self.joints, self._on_joints(self.free_velocity)
        left = np.abs(F @ v + self.joint_bias)
        terms = (abs(F) @ (np.abs(v) + np.abs(self.free_velocity)) + np.abs(self.joint_bias)) / self._joint_units
        held = bool((left / self._joint_units <= CONTRADICTION * terms.max()).all())
        told = f"rows are so nearly dependent that rounding leaves them unsatisfied by up to {left.max():.2g} m/s"
        check.require(held, "joints", f"{told}; remove those that follow from others")

    @cached_property
    def _measures(self) -> tuple[Array, Array, float, Array, float]:
        """(q, scale, velocity_scale, units and their spread), which one pass over the contacts computes together."""
        free = self._on_joints(self.free_velocity)
        q, scale, velocity_scale, units = delassus.measures(
            *self.contact_rows, *self.inverse_rows, free, self.bias, self.friction_bias
        )
        moves, unlike = self._moves, 1.0
        if self._has_joints:
            diagonal, locked = self._joint_diagonal
            by_contact = q.reshape(diagonal.shape)
            terms = delassus.velocity_size(*self.contact_rows, *self.inverse_rows, moves, np.zeros_like(by_contact), self.bias)
            by_contact[locked & (np.abs(by_contact) <= delassus.LOCKED * terms)] = 0.0
            scale, velocity_scale = delassus.mean_diagonal(diagonal), delassus.largest(q, diagonal.shape[1])
        if self._has_joints or not len(units):
            units = mechanical_units(*self._bodies, moves, self.bias, q, scale, self.friction_bias)
            unlike = spread(units)
        q.setflags(write=False)
        units.setflags(write=False)
        return q, scale, velocity_scale, units, unlike

    @cached_property
    def _joint_diagonal(self) -> tuple[Array, NDArray[np.bool_]]:
        """The diagonal (nc, d) of W, 0 in locked directions, but without the joints where they lock the whole contact; and the
        locked directions (nc, d): those in which joints leave a contact no velocity that impulses could change, so that W's
        diagonal is a rounding error."""
        diagonal: Array = delassus.diagonal(*self.contact_rows, *self.inverse_rows)
        held, terms = (share.reshape(diagonal.shape) for share in self._held.shares())
        size = diagonal + terms
        locked: NDArray[np.bool_] = diagonal - held <= delassus.LOCKED * size
        return np.where(locked.all(axis=1, keepdims=True), diagonal, np.where(locked, 0.0, diagonal - held)), locked

    @property
    def _locked(self) -> NDArray[np.bool_]:
        """(nc, d): see _joint_diagonal."""
        return self._joint_diagonal[1]
