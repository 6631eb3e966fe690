"""The dimensionless Delassus form, in which the tolerances of all outside libraries have the same meaning.

With E_i = 1/sqrt(s_i) on contact i's rows and theta = max_i min(|q_i|, unit_i) E_i, unit_i that of problems.residual,
r = theta E r^ turns u = W r + q into

    u^ = W^ r^ + q^,      W^ = E W E,      q^ = E q / theta,

a mean diagonal of 1 at every contact, free velocities of at most 1 but where a contact is open by far, the same cones. An error
of the natural map of eps at a contact, |r^_i - P_K(r^_i - g(u^_i))| <= eps, is an error of eps theta sqrt(s_i) in contact
velocity, so

    eps = share * tol,      share = min_i unit_i / (theta sqrt(s_i)) <= 1,

keeps the residual of problems.residual within tol.
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from frictionbench.problems import FrictionProblem
from frictionbench.problems.check import Array


class ScaledDelassus(NamedTuple):
    """W^ (nc*d, nc*d), q^ (nc*d,), friction (nc,), E (nc*d,), theta, share, s (nc,) and (nc, d)."""

    W: sparse.csr_array
    q: Array
    friction: Array
    E: Array
    theta: float
    share: float
    scale: Array
    contacts: tuple[int, int]

    def impulse(self, r: Array) -> Array:
        """The impulses (nc, d), N s, for r^ (nc*d,)."""
        return (self.theta * self.E * r).reshape(self.contacts)

    def in_space(self) -> tuple[Array, Array]:
        """W^ dense and q^ with three rows a contact; in the plane the third is decoupled, with the second's diagonal."""
        nc, d = self.contacts
        W = self.W.toarray()
        if d == 3:
            return W, self.q
        rows = np.delete(np.arange(3 * nc), np.s_[2::3])
        raised, q = np.zeros((3 * nc, 3 * nc)), np.zeros(3 * nc)
        raised[np.ix_(rows, rows)], q[rows] = W, self.q
        third = 3 * np.arange(nc) + 2
        raised[third, third] = W.diagonal()[1::2]
        return raised, q

    def from_space(self, r: Array) -> Array:
        """The impulses (nc, d) of r^ (nc*3,)."""
        nc, d = self.contacts
        return self.impulse(r.reshape(nc, 3)[:, :d].ravel())

    def to_space(self, impulse: Array) -> Array:
        """r^ (nc*3,) of impulses (nc, d)."""
        nc, d = self.contacts
        r = np.zeros((nc, 3))
        r[:, :d] = impulse / (self.theta * self.E).reshape(nc, d)
        return r.ravel()


def scaled_delassus(problem: FrictionProblem) -> ScaledDelassus:
    """The dimensionless Delassus form of a friction problem, without its friction_bias."""
    nc, d = problem.contacts, problem.dimension
    s = problem.scale
    E = np.repeat(1 / np.sqrt(s), d)
    size = np.linalg.norm(problem.q.reshape(nc, d), axis=1)
    theta = float((np.minimum(size, problem.units) / np.sqrt(s)).max(initial=0.0)) or 1.0
    share = float((problem.units / (theta * np.sqrt(s))).min()) if size.any() else 1.0
    W = sparse.csr_array(problem.W.multiply(E[:, None]).multiply(E))
    return ScaledDelassus(W, E * problem.q / theta, problem.friction, E, theta, share, s, (nc, d))
