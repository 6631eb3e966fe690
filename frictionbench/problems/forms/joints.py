"""Joint equations F v + b_F = 0 of any rank: the nearest velocities that satisfy them, and what they change in W.

With G = F M^-1 F' the nearest velocity in the kinetic metric is v - M^-1 F' X (F v + b_F). Redundant equations make G singular;
any X with G X G = G gives the same velocities. For few equations X is dense. Many, each on few bodies, are taken in Cuthill and
McKee's order of the graph in which equations are neighbours that share a body, or whose bodies touch: then G, and the entries
of its inverse that a contact's own block of W needs, lie within a band. Chains and trees of thousands of links have narrow
bands. Equations that depend on earlier ones are left out of the band's factors (problems.forms.banded).

Redundant equations must agree: where F v + b_F = 0 has no solution, no impulses satisfy it, and the problem is refused.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.linalg import lstsq
from scipy.sparse.csgraph import reverse_cuthill_mckee

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.forms import banded, delassus, held
from frictionbench.problems.rows import ByContact, Rows, from_matrix

FEW = 100  # equations up to which a dense inverse is as fast as a factorisation of a band
# Of a joint's bias: a larger defect is a contradiction. It is the tightest tolerance of the suites.
CONTRADICTION = 1e-8
# Of the largest terms of any joint equation, as speeds of unit kinetic energy: what rounding leaves.
ROUNDING = 1000 * held.EPSILON
# Of the terms' rounding errors, which are independent: their sum is seldom larger than twice the root of their squares' sum.
PROBES, DEVIATIONS = 8, 2.0


@dataclass(eq=False)
class FewJoints:
    """With a dense X. rows: F (nj, nv) by rows. bias: b_F (nj,). inverse_mass: M^-1 by rows. contacts: J by contacts.

    Errors: InputError naming joints where G overflows.
    """

    rows: Rows
    bias: Array
    inverse_mass: Rows
    contacts: ByContact

    def __post_init__(self) -> None:
        self.response: Array = delassus.joint_response(*self.rows, *self.inverse_mass)  # M^-1 F' (nv, nj)
        G = delassus.product(*self.rows, self.response)
        check.require(bool(np.isfinite(G).all()), "joints", "F M^-1 F' overflows")
        self.inverse: Array = held.generalised_inverse(G)

    def hold(self, velocity: Array, share: float = 1.0) -> Array:
        """The velocity (nv,) nearest in the kinetic metric that satisfies the equations with a share of the biases."""
        nearest: Array = held.hold(*self.rows, share * self.bias, self.response, self.inverse, velocity)
        return nearest

    def solution(self) -> Array:
        """A velocity that satisfies the equations, where one does: of least squares, with each velocity in that of a unit of
        kinetic energy, and each equation in the speed that such velocities give it."""
        root = np.sqrt(self.inverse_mass.matrix(len(self.response)).diagonal())
        F = self.rows.dense(len(self.response)) * root
        size = np.linalg.norm(F, axis=1)
        unit = np.where(size > 0, size, 1.0)
        F /= unit[:, None]
        check.require(bool(np.isfinite(F).all()), "joints", "F M^-1 F' overflows")
        v: Array = lstsq(F, -self.bias / unit, cond=np.sqrt(held.DEPENDENT * len(F)), lapack_driver="gelsy")[0]
        return v * root

    def rounding(self, velocity: Array) -> Array:
        """(nv,) the absolute values of the terms that `hold` adds to a velocity."""
        size: Array = held.hold_rounding(*self.rows, self.bias, self.response, self.inverse, velocity, self.hold(velocity))
        return size

    def shares(self) -> tuple[Array, Array]:
        """(nc*d,) each: the diagonal of J M^-1 F' X F M^-1 J', which W lacks, and the same of its terms' absolute values."""
        factors = self._coupling, self.inverse, self._coupling
        taken = np.einsum("ji,jk,ki->i", *factors)
        return taken, np.einsum("ji,jk,ki->i", *map(np.abs, factors))

    def coupled(self) -> Array:
        """J M^-1 F' X F M^-1 J' (nc*d, nc*d), which W lacks."""
        coupled: Array = self._coupling.T @ self.inverse @ self._coupling
        return coupled

    @cached_property
    def _coupling(self) -> Array:
        """F M^-1 J' (nj, nc*d)."""
        coupling: Array = delassus.coupling(*self.contacts, self.response)
        return coupling


@dataclass(eq=False)
class ManyJoints:
    """With the factors of G's band. joints: F (nj, nv). bias: b_F (nj,). inverse_mass: M^-1 (nv, nv). jacobian: J (nc*d, nv).

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
        lower = sparse.coo_array(sparse.tril(G))
        self.factor = np.zeros((len(order), half + 1))
        self.factor[lower.row, lower.col - lower.row + half] = lower.data
        banded.factorise(self.factor, 10 * len(order) * held.EPSILON)

    def hold(self, velocity: Array, share: float = 1.0) -> Array:
        """As of FewJoints."""
        return self._hold(share * self.own_bias, velocity)

    def solution(self) -> Array:
        """A velocity that satisfies the equations, where one does."""
        return self.hold(np.zeros(self.response.shape[1]))

    def rounding(self, velocity: Array) -> Array:
        """(nv,) the size of the terms that `hold` adds to a velocity, of what errors in them change, and of what it leaves.

        |X| is not formed. Errors of each equation's terms, with random signs, are put through X instead, and the root of the
        mean square of the results is taken.
        """
        settled = self.hold(velocity)
        off = abs(self.rows.matrix(len(velocity))) @ np.abs(settled) + np.abs(self.own_bias)
        left = np.abs(self.hold(settled) - settled) / (2 * held.EPSILON)
        signs = np.random.default_rng(0).choice([-1.0, 1.0], (PROBES, len(off)))
        zero = np.zeros(len(velocity))
        spread = np.sqrt(np.mean([self._hold(sign * off, zero) ** 2 for sign in signs], axis=0))
        return np.abs(settled - velocity) + left + DEVIATIONS * spread

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


JointEquations = FewJoints | ManyJoints


def require_consistent(held: JointEquations, F: sparse.csr_array, bias: Array, inverse_mass: Array, free: Array) -> None:
    """Check that the equations have a solution, and that rounding leaves them satisfied by the velocity nearest to v*.

    held: the equations F v + bias = 0. inverse_mass: the diagonal of M^-1 (nv,). free: v* (nv,).
    Errors: InputError naming joint_bias where they contradict each other, joints where rounding leaves them above CONTRADICTION
    of their terms, each row in its own unit: of rows that are nearly dependent the inverse has too few digits.
    """
    size = np.sqrt(F.multiply(F) @ inverse_mass)  # the speed that a unit of kinetic energy gives each joint
    unit = np.where(size > 0, size, 1.0)
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows compares as false and is refused
        if bias.any():  # without biases, v = 0 satisfies all
            _require_solution(held, F, bias, unit, free)
        v = held.hold(free)
        left = np.abs(F @ v + bias)
        terms = (abs(F) @ (np.abs(v) + np.abs(free)) + np.abs(bias)) / unit
        satisfied = bool((left / unit <= CONTRADICTION * terms.max()).all())
        reason = f"rows are so nearly dependent that rounding leaves them unsatisfied by up to {left.max():.2g} m/s"
        check.require(satisfied, "joints", f"{reason}; remove those that follow from others")


def _require_solution(held: JointEquations, F: sparse.csr_array, bias: Array, unit: Array, free: Array) -> None:
    """Errors: InputError naming joint_bias where no velocity satisfies F v + bias = 0, by more than rounding explains.

    Whether one does depends on F and the biases alone. With each row in its own unit, the velocity of least squares is compared
    with the rounding of its terms and of those of F v*.
    """
    own = bias / unit
    check.require(bool(np.isfinite(own).all()), "joints", "b_F overflows")
    v = held.solution()
    terms = abs(F) @ (np.abs(v) + np.abs(free)) / unit + np.abs(own)
    defect = np.abs(F @ v / unit + own)
    bad = np.flatnonzero(~(defect <= np.maximum(CONTRADICTION * np.abs(own), ROUNDING * terms.max())))
    listed = ", ".join(map(str, bad[:6].tolist())) + ", ..." * (len(bad) > 6)
    missed = f"rows {listed} are missed by up to {(defect * unit)[bad].max(initial=0.0):.2g} m/s"
    check.require(not len(bad), "joint_bias", f"the joint equations contradict each other: {missed}")


def _half_bandwidth(rows: sparse.csr_array) -> int:
    """The largest difference between two columns of one row."""
    rows.sort_indices()
    filled = np.flatnonzero(np.diff(rows.indptr))
    first, last = rows.indices[rows.indptr[filled]], rows.indices[rows.indptr[filled + 1] - 1]
    return int((last - first).max(initial=0))
