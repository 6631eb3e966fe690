"""What the two contact operators share: the affine map u = W r + q from impulses r to contact velocities u.

What a problem asks of either is documented by FrictionProblem, which passes it on. Both also give the equations of motion
behind the map, M (v - v*) = J' r + F' lam with F v + b_F = 0 and u = J v + offset, as plain arrays (problems.rows) for compiled
passes and as scipy matrices for other callers.
"""

from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy import sparse

from frictionbench.problems.check import Array, ReadOnly
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.arrays import CSR, Dense, csr, dense
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.rows import ByContact, Rows, by_row

NO_ROWS = Rows(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0))  # a matrix without rows


class Operator(ReadOnly):
    """The operator of nc contacts of dimension d and nv velocities. Its arrays are read-only; what is derived is computed once.

    The operators are not frozen dataclasses, whose construction would add a tenth to the time of making a small problem's W.

    FIELDS: the names of the problem's fields that define it with this operator, in the order of the content hash.
    mass_rows, inverse_rows: M and M^-1 (nv, nv); joint_rows: F (nj, nv); contact_rows: J (nc*d, nv) by contacts.
    free_velocity: v* (nv,). bias: (nc,), of the normal velocities. joint_bias: b_F (nj,).
    friction_bias: (nc,), the law's, on which the units depend.
    q: (nc*d,), u where r = 0, rows per contact, normal first. W: the Delassus matrix (nc*d, nc*d); blocks: by contacts.
    """

    FIELDS: ClassVar[tuple[str, ...]]
    mass_rows: Rows
    inverse_rows: Rows
    joint_rows: Rows
    contact_rows: ByContact
    free_velocity: Array
    bias: Array
    friction_bias: Array
    joint_bias: Array
    q: Array
    W: sparse.csr_array
    blocks: Blocks

    @cached_property
    def dense(self) -> Dense:
        """W and q as dense arrays (problems.forms.arrays)."""
        return dense(self.blocks, self.q)

    @cached_property
    def csr(self) -> CSR:
        """W in compressed rows, and q (problems.forms.arrays)."""
        return csr(self.blocks, self.q)

    def velocity(self, r: Array) -> Array:
        """v (nv,) after the contact impulses r (nc, d)."""
        return delassus.velocity(*self.contact_rows, *self.inverse_rows, self.free_velocity, r)

    @cached_property
    def mass(self) -> sparse.csr_array:
        return self._matrix(self.mass_rows)

    @cached_property
    def inverse_mass(self) -> sparse.csr_array:
        return self._matrix(self.inverse_rows)

    @cached_property
    def joints(self) -> sparse.csr_array:
        return self._matrix(self.joint_rows)

    @cached_property
    def jacobian(self) -> sparse.csr_array:
        return self._contact_matrix(0, self.contact_rows.value.shape[1])

    @cached_property
    def normal(self) -> sparse.csr_array:
        return self._contact_matrix(0, 1)

    @cached_property
    def tangent(self) -> sparse.csr_array:
        return self._contact_matrix(1, self.contact_rows.value.shape[1])

    def _matrix(self, rows: Rows) -> sparse.csr_array:
        return rows.matrix(len(self.free_velocity))

    def _contact_matrix(self, first: int, end: int) -> sparse.csr_array:
        return self._matrix(Rows(*by_row(*self.contact_rows, first, end)))
