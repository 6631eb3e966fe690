"""Joint equations F v + b_F = 0 of any rank: the nearest velocities that satisfy them, and their contribution to W.

With G = F M^-1 F', the nearest velocity in the kinetic metric is v - M^-1 F' X (F v + b_F). Redundant equations make G
singular; any X with G X G = G gives the same velocities. For few equations, X is dense. Many equations, each on few bodies, are
put into the reverse Cuthill-McKee order of a graph, in which equations are neighbours if they share a body or if their bodies
touch. Then G, and the entries of its inverse that a contact's own block of W needs, lie within a band, which is narrow for
chains and trees of thousands of links. Equations that depend on earlier ones are left out of the factors (forms.banded).

Redundant equations must be consistent: if F v + b_F = 0 has no solution, no impulses satisfy it, and the problem is refused.
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
from frictionbench.problems.forms.islands import EPSILON
from frictionbench.problems.rows import ByContact, Index32, Rows, by_row, row_of_entry

FEW_EQUATIONS = 100  # the number of equations up to which a dense inverse is as fast as a band factorisation
# Relative to a joint's bias: a larger defect is a contradiction. The value is the tightest tolerance of the suites.
CONTRADICTION = 1e-8
# Relative to the largest terms of any joint equation, with each equation in its own unit: a defect that rounding may leave.
DEFECT_ROUNDING = 1000 * EPSILON
# Samples of random signs of the rounding errors, and the standard deviations that a sum of independent errors seldom exceeds.
PROBES, DEVIATIONS = 8, 2.0


@dataclass(eq=False)
class FewJoints:
    """Few equations, with a dense X. rows: F (nj, nv) by rows. bias: b_F (nj,). inverse_mass: M^-1 by rows. contacts: J.

    Errors: InputError naming joints if G overflows.
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
        """The nearest velocity (nv,), in the kinetic metric, that satisfies the equations with share times the biases."""
        return held.hold(*self.rows, share * self.bias, self.response, self.inverse, velocity)

    def solution(self) -> Array:
        """A velocity that satisfies the equations, if there is one: the least-squares solution. Each velocity is scaled by the
        speed that has unit kinetic energy, and then each equation by the norm of its row."""
        root = np.sqrt(self.inverse_mass.matrix(len(self.response)).diagonal())
        F = self.rows.dense(len(self.response)) * root
        size = np.linalg.norm(F, axis=1)
        unit = np.where(size > 0, size, 1.0)
        F /= unit[:, None]
        check.require(bool(np.isfinite(F).all()), "joints", "F M^-1 F' overflows")
        v: Array = lstsq(F, -self.bias / unit, cond=np.sqrt(held.DEPENDENT_ROW * len(F)), lapack_driver="gelsy")[0]
        return v * root

    def rounding(self, velocity: Array) -> Array:
        """(nv,): the sum of the absolute values of the terms that `hold` adds to a velocity."""
        return held.hold_rounding(*self.rows, self.bias, self.response, self.inverse, velocity, self.hold(velocity))

    def shares(self) -> tuple[Array, Array]:
        """The diagonal of J M^-1 F' X F M^-1 J' and the sums of the absolute values of its terms, each (nc*d,)."""
        C, size = self._coupling, np.abs(self._coupling)
        return np.sum(C * (self.inverse @ C), axis=0), np.sum(size * (np.abs(self.inverse) @ size), axis=0)

    def coupled(self) -> Array:
        """J M^-1 F' X F M^-1 J' (nc*d, nc*d), by which the joints reduce W."""
        return self._coupling.T @ self.inverse @ self._coupling

    @cached_property
    def _coupling(self) -> Array:
        """F M^-1 J' (nj, nc*d)."""
        return delassus.coupling(*self.contacts, self.response)


@dataclass(eq=False)
class ManyJoints:
    """Many equations, with a band factorisation of G. Arguments and errors as in FewJoints."""

    rows: Rows
    bias: Array
    inverse_mass: Rows
    contacts: ByContact

    def __post_init__(self) -> None:
        (start, column, F), nv, nj = self.rows, len(self.inverse_mass.start) - 1, len(self.bias)
        first, near, block = delassus.delassus(start, column, F[:, None], *self.inverse_mass)
        check.require(bool(np.isfinite(block).all()), "joints", "F M^-1 F' overflows")
        G, row = Rows(first, near, block.ravel()).matrix(nj), row_of_entry(first)
        unit = 1 / np.sqrt(np.where(G.diagonal() > 0, G.diagonal(), 1.0))
        response = self.rows.matrix(nv) @ self.inverse_mass.matrix(nv)
        coupling = Rows(*by_row(*self.contacts, 0, self.contacts.value.shape[1])).matrix(nv) @ response.T
        touching = abs(coupling.T) @ abs(coupling)
        order = reverse_cuthill_mckee(sparse.csr_matrix(abs(G) + touching), symmetric_mode=True)
        # From here on the equations are in this order, each scaled so that G has a unit diagonal.
        place = np.argsort(order)
        self.own_bias = (unit * self.bias)[order]
        self.rows = _reordered(self.rows, unit, order)
        self.response = _reordered(Rows(response.indptr, response.indices, response.data), unit, order)
        within = place[coupling.indices].astype(np.int32)
        self.coupling = Rows(coupling.indptr, within, coupling.data * unit[coupling.indices])  # J M^-1 F' (nc*d, nj)
        below = place[row] - place[near]  # rows below the diagonal
        filled = coupling.indptr[:-1][np.diff(coupling.indptr) > 0]
        width = np.maximum.reduceat(within, filled) - np.minimum.reduceat(within, filled)  # of nonempty rows of the coupling
        half = int(max(width.max(initial=0), below.max(initial=0)))
        lower = below >= 0
        self.factor = np.zeros((nj, half + 1))
        self.factor[place[row[lower]], half - below[lower]] = (unit[row] * block[:, 0, 0] * unit[near])[lower]
        banded.factorise(self.factor, 10 * nj * EPSILON)

    def hold(self, velocity: Array, share: float = 1.0) -> Array:
        """As in FewJoints."""
        return self._hold(share * self.own_bias, velocity)

    def solution(self) -> Array:
        """A velocity that satisfies the equations, if there is one."""
        return self.hold(np.zeros(len(self.inverse_mass.start) - 1))

    def rounding(self, velocity: Array) -> Array:
        """(nv,): the size of the terms that `hold` adds to a velocity, of the effect of their errors, and of the remainder.

        |X| is not formed. Instead X is applied to errors of each equation's terms with random signs, and the root mean square
        of the results is taken.
        """
        settled, (start, column, F) = self.hold(velocity), self.rows
        off = np.abs(self.own_bias) + np.bincount(row_of_entry(start), np.abs(F * settled[column]), len(start) - 1)
        left = np.abs(self.hold(settled) - settled) / (2 * EPSILON)
        signs = np.random.default_rng(0).choice([-1.0, 1.0], (PROBES, len(off)))
        zero = np.zeros(len(velocity))
        spread = np.sqrt(np.mean([self._hold(sign * off, zero) ** 2 for sign in signs], axis=0))
        return np.abs(settled - velocity) + left + DEVIATIONS * spread

    def shares(self) -> tuple[Array, Array]:
        """As in FewJoints."""
        held, terms = banded.forms(banded.inverse_in_band(self.factor), *self.coupling).T
        return held, terms

    def coupled(self) -> Array:
        """As in FewJoints; dense."""
        whitened = self.coupling.dense(len(self.bias))
        banded.whiten(self.factor, whitened)
        return whitened @ whitened.T

    def _hold(self, bias: Array, velocity: Array) -> Array:
        return banded.hold(self.factor, *self.rows, *self.response, bias, velocity)


JointEquations = FewJoints | ManyJoints


def require_consistent(held: JointEquations, F: sparse.csr_array, bias: Array, inverse_mass: Array, free: Array) -> None:
    """Check that the equations have a solution, and that the velocity nearest to v* satisfies them despite rounding.

    held: the equations F v + bias = 0. inverse_mass: the diagonal of M^-1 (nv,). free: v* (nv,).
    Errors: InputError naming joint_bias if the equations contradict each other, or joints if a row, in its own unit, is missed
    by more than CONTRADICTION times the largest terms, because the inverse is inaccurate for nearly dependent rows.
    """
    size = np.sqrt(F.multiply(F) @ inverse_mass)  # the speed that a unit of kinetic energy gives each joint
    unit = np.where(size > 0, size, 1.0)
    with np.errstate(over="ignore", invalid="ignore"):  # after an overflow the test fails and refuses the problem
        if bias.any():  # without biases, v = 0 satisfies all
            _require_solution(held, F, bias, unit, free)
        v = held.hold(free)
        left = np.abs(F @ v + bias)
        terms = (abs(F) @ (np.abs(v) + np.abs(free)) + np.abs(bias)) / unit
        moving = (np.abs(free) / np.sqrt(inverse_mass)).max(initial=0.0)  # v* is known to its rounding alone
        satisfied = bool((left / unit <= max(CONTRADICTION * terms.max(), DEFECT_ROUNDING * moving)).all())
        reason = f"rows are so nearly dependent that rounding leaves them unsatisfied by up to {left.max():.2g} m/s"
        check.require(satisfied, "joints", f"{reason}; remove those that follow from others")


def _require_solution(held: JointEquations, F: sparse.csr_array, bias: Array, unit: Array, free: Array) -> None:
    """Errors: InputError naming joint_bias if every velocity violates F v + bias = 0 by more than rounding explains.

    This depends on F and the biases alone. With each row in its own unit, the defect of the least-squares velocity is compared
    with the rounding errors of its terms and of those of F v*.
    """
    scaled_bias = bias / unit
    check.require(bool(np.isfinite(scaled_bias).all()), "joints", "b_F overflows")
    v = held.solution()
    terms = abs(F) @ (np.abs(v) + np.abs(free)) / unit + np.abs(scaled_bias)
    defect = np.abs(F @ v / unit + scaled_bias)
    bad = np.flatnonzero(~(defect <= np.maximum(CONTRADICTION * np.abs(scaled_bias), DEFECT_ROUNDING * terms.max())))
    listed = ", ".join(map(str, bad[:6].tolist())) + ", ..." * (len(bad) > 6)
    missed = f"rows {listed} are missed by up to {(defect * unit)[bad].max(initial=0.0):.2g} m/s"
    check.require(not len(bad), "joint_bias", f"the joint equations contradict each other: {missed}")


def _reordered(rows: Rows, unit: Array, order: Index32) -> Rows:
    """The rows multiplied by their units and reordered."""
    count = np.diff(rows.start)
    start = np.append(0, count[order].cumsum()).astype(np.int32)
    entry = np.repeat(rows.start[order] - start[:-1], count[order]) + np.arange(start[-1])
    return Rows(start, rows.column[entry], (rows.value * np.repeat(unit, count))[entry])
