"""Joint equations F v + b_F = 0 by a banded factorisation of G = F M^-1 F': for many of them, each on few bodies.

The equations are taken in Cuthill and McKee's order of the graph in which equations are neighbours that share a body, or whose
bodies touch: then G, and the entries of its inverse that a contact's own block of W needs, lie within a band. Chains and trees
of thousands of links have narrow bands. Equations that depend on earlier ones are left out (problems.forms.banded).
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.forms import banded
from frictionbench.problems.rows import from_matrix

# Of the terms' rounding errors, which are independent: their sum is seldom larger than twice the root of their squares' sum.
PROBES, DEVIATIONS = 8, 2.0


@dataclass(eq=False)
class ManyJoints:
    """joints: F (nj, nv). bias: b_F (nj,). inverse_mass: M^-1 (nv, nv). jacobian: J (nc*d, nv).

    Errors: InputError naming joints where G overflows.
    """

    joints: sparse.csr_array
    bias: Array
    inverse_mass: sparse.csr_array
    jacobian: sparse.csr_array

    def __post_init__(self) -> None:
        response = self.joints @ self.inverse_mass
        G = response @ self.joints.T
        check.require(bool(np.isfinite(G.data).all()), "joints", "F M^-1 F' overflows")
        size = G.diagonal()
        unit = sparse.diags_array(1 / np.sqrt(np.where(size > 0, size, 1.0)))
        coupling = abs(self.joints) @ abs(self.inverse_mass) @ abs(self.jacobian.T)
        order = reverse_cuthill_mckee(sparse.csr_matrix(abs(G) + coupling @ coupling.T), symmetric_mode=True)
        # From here on the equations are in that order and each in its own unit, so that G has a unit diagonal.
        F = sparse.csr_array((unit @ self.joints)[order])
        F.sort_indices()
        response = sparse.csr_array((unit @ response)[order])
        self.rows, self.response = from_matrix(F), response
        self.coupling = sparse.csr_array(self.jacobian @ response.T)  # J M^-1 F' (nc*d, nj)
        self.own_bias = (unit @ self.bias)[order]
        G = sparse.csr_array((unit @ G @ unit)[order][:, order])
        half = max(_half_bandwidth(self.coupling), int(np.abs(np.subtract(*G.nonzero())).max(initial=0)))
        self.factor = banded.by_band(G.indptr, G.indices, G.data, half)
        banded.factorise(self.factor, 10 * len(order) * float(np.finfo(float).eps))

    def hold(self, velocity: Array) -> Array:
        """The velocity (nv,) nearest in the kinetic metric that satisfies the equations."""
        return self._hold(self.own_bias, velocity)

    def solution(self) -> Array:
        """A velocity that satisfies the equations, where one does."""
        return self.hold(np.zeros(self.response.shape[1]))

    def rounding(self, velocity: Array) -> Array:
        """(nv,) the size of the terms that `hold` adds to a velocity, and of what errors in them change.

        |X| is not formed. Errors of each equation's terms, with signs such that those of 8 equations in a row are orthogonal,
        are put through X instead, and the root of the mean square of the results is taken.
        """
        off = abs(self.rows.matrix(len(velocity))) @ np.abs(velocity) + np.abs(self.own_bias)
        signs = _hadamard(PROBES)[:, np.arange(len(off)) % PROBES]
        zero = np.zeros(len(velocity))
        spread = np.sqrt(np.mean([self._hold(sign * off, zero) ** 2 for sign in signs], axis=0))
        return np.abs(self.hold(velocity) - velocity) + DEVIATIONS * spread

    def shares(self) -> tuple[Array, Array]:
        """(nc*d,) each: the diagonal of J M^-1 F' X F M^-1 J', which W lacks, and the same of its terms' absolute values."""
        coupling = self.coupling
        X = banded.inverse_in_band(self.factor)
        held, terms = banded.forms(X, coupling.indptr, coupling.indices, coupling.data).T
        return held, terms

    def coupled(self) -> Array:
        """J M^-1 F' X F M^-1 J' (nc*d, nc*d), which W lacks; dense."""
        whitened = self.coupling.toarray()
        banded.whiten(self.factor, whitened)
        coupled: Array = whitened @ whitened.T
        return coupled

    def _hold(self, bias: Array, velocity: Array) -> Array:
        response = self.response
        held: Array = banded.hold(self.factor, *self.rows, response.indptr, response.indices, response.data, bias, velocity)
        return held


def _half_bandwidth(rows: sparse.csr_array) -> int:
    """The largest difference between two columns of one row."""
    rows.sort_indices()
    filled = np.flatnonzero(np.diff(rows.indptr))
    first, last = rows.indices[rows.indptr[filled]], rows.indices[rows.indptr[filled + 1] - 1]
    return int((last - first).max(initial=0))


def _hadamard(n: int) -> Array:
    """Orthogonal rows of 1 and -1 (n, n), n a power of 2 (Sylvester's construction)."""
    signs = np.ones((1, 1))
    while len(signs) < n:
        signs = np.block([[signs, signs], [signs, -signs]])
    return signs
