"""The contact operator known only by its Delassus matrix: u = W r + q.

Its velocities (nc*d) are those of the symmetric root of W, W = J J', with unit mass. The root is dense, and computed only
where a method asks for the Jacobian, its normal or its tangent rows.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from scipy import sparse

from frictionbench.problems import check
from frictionbench.problems.check import Array, require
from frictionbench.problems.forms import delassus
from frictionbench.problems.forms.balance import delassus_factors
from frictionbench.problems.forms.definite import spectrum_ends
from frictionbench.problems.forms.delassus import Blocks
from frictionbench.problems.forms.islands import delassus_graph, delassus_units, islands, spread
from frictionbench.problems.operators.operator import NO_ROWS, Operator
from frictionbench.problems.rows import ByContact, Index64, Rows, by_contact

LARGEST = 1e150  # 1/kg, of an entry; squares of larger ones overflow
DIGITS = 1e-6  # of W's largest entry: what is unsymmetric by no more counts as rounding in a file
INDEFINITE = 1e-6  # of W's largest eigenvalue: recorded problems are indefinite by that much, as their files round W's digits


@dataclass(eq=False, repr=False)
class DelassusOperator(Operator):
    """The operator of a given W (nc*d, nc*d) and q (nc*d,), rows per contact, normal first.

    W is stored as given, also where it is unsymmetric, as gyroscopic or follower forces make it, or where its symmetric part
    has negative eigenvalues down to -INDEFINITE of the largest (as far as problems.forms.definite finds them). J is that of
    the symmetric part.
    """

    FIELDS: ClassVar[tuple[str, ...]] = ("W", "q", "friction", "friction_bias")
    W: sparse.csr_array
    q: Array
    dimension: int
    friction_bias: Array

    @classmethod
    def checked(cls, nc: int, d: int, W: Any, q: Any, friction_bias: Array) -> Self:
        """The operator of nc contacts of dimension d, of checked copies. Errors: InputError naming the field."""
        vector = check.vector("q", q, nc * d)
        matrix = check.matrix("W", W, (nc * d, nc * d))
        require(abs(matrix).max() < LARGEST if matrix.nnz else True, "W", f"its entries must be below {LARGEST:g}")
        _require_both_triangles(matrix)
        least, largest = spectrum_ends(matrix)
        require(least >= -INDEFINITE * max(largest, 0.0), "W", "not positive semidefinite")
        return cls(matrix, vector, d, friction_bias)

    def fresh(self) -> Self:
        return type(self)(self.W, self.q, self.dimension, self.friction_bias)

    @cached_property
    def asymmetry(self) -> float:
        """The largest |W - W'| over the largest |W|."""
        return float(abs(self.W - self.W.T).max() / abs(self.W).max()) if self.W.nnz else 0.0

    @cached_property
    def scale(self) -> Array:
        return delassus.block_scale(*self.blocks)

    @cached_property
    def velocity_scale(self) -> float:
        return float(delassus.largest(self.q, self.dimension))

    @cached_property
    def units(self) -> Array:
        units = self.units_at(self.q)
        units.setflags(write=False)
        return units

    def units_at(self, q: Array) -> Array:
        units: Array = delassus_units(*self.blocks, q, self.scale, self.friction_bias)
        return units

    @cached_property
    def spread(self) -> float:
        return float(spread(self.units))

    def balanced(self, units: Array) -> tuple[Self, Array]:
        factor: Array = delassus_factors(*self.blocks[:2], units)
        laws = self.q / np.repeat(factor, self.dimension), self.friction_bias / factor
        check.set_read_only(laws)
        same = type(self)(self.W, laws[0], self.dimension, laws[1])
        same.blocks = self.blocks
        return same, factor

    @cached_property
    def islands(self) -> Index64:
        return islands(*delassus_graph(*self.blocks, self.scale))

    @cached_property
    def blocks(self) -> Blocks:  # type: ignore[override]
        return delassus.blocks(self.W, self.dimension)

    @property
    def offset(self) -> Array:
        return self.q.reshape(-1, self.dimension)

    def contact_velocity(self, r: Array) -> Array:
        return delassus.act(*self.blocks, r, self.offset)

    def velocity_size(self, r: Array) -> Array:
        return delassus.act_size(*self.blocks, r, self.offset)

    @cached_property
    def bias(self) -> Array:  # type: ignore[override]
        return check.vector("q", self.q[:: self.dimension])

    @cached_property
    def mass_rows(self) -> Rows:  # type: ignore[override]
        n = len(self.q)
        return Rows(np.arange(n + 1, dtype=np.int32), np.arange(n, dtype=np.int32), np.ones(n))

    @property
    def inverse_rows(self) -> Rows:  # type: ignore[override]
        return self.mass_rows

    @property
    def joint_rows(self) -> Rows:  # type: ignore[override]
        return NO_ROWS

    @cached_property
    def free_velocity(self) -> Array:  # type: ignore[override]
        return check.vector("free_velocity", np.zeros(len(self.q)))

    @property
    def joint_bias(self) -> Array:  # type: ignore[override]
        return self.free_velocity[:0]

    @cached_property
    def contact_rows(self) -> ByContact:  # type: ignore[override]
        """J (nc*d, nc*d), J J' the symmetric part of W; dense but for the columns of W's null space, which are empty."""
        value, basis = np.linalg.eigh((self.W + self.W.T).toarray() / 2)
        floor = np.finfo(float).eps * len(value) * abs(value).max(initial=0.0)
        root = (basis * np.sqrt(np.where(value > floor, value, 0.0))).reshape(-1, self.dimension, len(value))
        normal, tangent = root[:, :1].reshape(-1, len(value)), root[:, 1:].reshape(-1, len(value))
        rows = *check.rows("W", normal, normal.shape), *check.rows("W", tangent, tangent.shape)
        return ByContact(*by_contact(*rows, self.dimension))


def _require_both_triangles(W: sparse.csr_array) -> None:
    """Errors: InputError naming W where it has entries on one side of its diagonal alone, as one stored by a triangle does,
    that are more than rounding."""
    sides = sparse.tril(W, -1, format="coo"), sparse.triu(W, 1, format="coo")
    for side, other in (sides, sides[::-1]):
        if side.nnz and not other.nnz and abs(side.data).max() > DIGITS * abs(W).max():
            most = abs(side.data).argmax()
            i, j = side.row[most], side.col[most]
            raise check.InputError(f"W: holds one triangle: entry ({i}, {j}) is {side.data[most]:.3g}, but ({j}, {i}) is 0")
