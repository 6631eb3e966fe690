"""Joint equations F v + b_F = 0 by a dense inverse of G = F M^-1 F': for few of them, of any rank.

Redundant equations make G singular; any X with G X G = G gives the same velocities, v - M^-1 F' X (F v + b_F).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lstsq

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.forms import delassus
from frictionbench.problems.rows import ByContact, Rows


@dataclass(eq=False)
class FewJoints:
    """rows: F (nj, nv) by rows. bias: b_F (nj,). inverse_mass: M^-1 by rows. contacts: J by contacts.

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
        self.inverse = _generalised_inverse(G)

    def hold(self, velocity: Array) -> Array:
        """The velocity (nv,) nearest in the kinetic metric that satisfies the equations.

        The second pass removes what the rounding of the inverse leaves of the first, where rows are nearly dependent.
        """
        for _ in range(2):
            off = delassus.product(*self.rows, velocity[:, None].copy())[:, 0] + self.bias
            velocity = velocity - self.response @ (self.inverse @ off)
        return velocity

    def solution(self) -> Array:
        """A velocity that satisfies the equations, where one does: of least squares, with each velocity in that of a unit of
        kinetic energy, and each equation in the speed that such velocities give it."""
        root = np.sqrt(self.inverse_mass.matrix(len(self.response)).diagonal())
        F = self._dense * root
        size = np.linalg.norm(F, axis=1)
        unit = np.where(size > 0, size, 1.0)
        F /= unit[:, None]
        check.require(bool(np.isfinite(F).all()), "joints", "F M^-1 F' overflows")
        v: Array = lstsq(F, -self.bias / unit, cond=np.sqrt(_dependent(len(F))), lapack_driver="gelsy")[0]
        return v * root

    def rounding(self, velocity: Array) -> Array:
        """(nv,) the absolute values of the terms that `hold` adds to a velocity."""
        terms = np.abs(self._dense) @ np.abs(velocity) + np.abs(self.bias)
        size: Array = np.abs(self.response) @ (np.abs(self.inverse) @ terms)
        return size

    def shares(self) -> tuple[Array, Array]:
        """(nc*d,) each: the diagonal of J M^-1 F' X F M^-1 J', which W lacks, and the same of its terms' absolute values."""
        factors = self._coupling, self.inverse, self._coupling
        held = np.einsum("ji,jk,ki->i", *factors)
        return held, np.einsum("ji,jk,ki->i", *map(np.abs, factors))

    def coupled(self) -> Array:
        """J M^-1 F' X F M^-1 J' (nc*d, nc*d), which W lacks."""
        coupled: Array = self._coupling.T @ self.inverse @ self._coupling
        return coupled

    @cached_property
    def _dense(self) -> Array:
        dense: Array = self.rows.matrix(len(self.response)).toarray()
        return dense

    @cached_property
    def _coupling(self) -> Array:
        """F M^-1 J' (nj, nc*d)."""
        coupling: Array = delassus.coupling(*self.contacts, self.response)
        return coupling


def _generalised_inverse(G: Array) -> Array:
    """X with G X G = G of a symmetric positive semidefinite G (nj, nj), symmetric.

    The rank is that of G with a unit diagonal, so that it does not depend on the units of the joints' equations.
    """
    diagonal = G.diagonal()
    unit = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    inverse = np.linalg.pinv(unit[:, None] * G * unit, rcond=_dependent(len(G)), hermitian=True)
    return np.asarray(unit[:, None] * inverse * unit)


def _dependent(nj: int) -> float:
    """The share of the largest eigenvalue of F M^-1 F' up to which those of dependent rows come out as rounding errors."""
    return 10 * nj * float(np.finfo(float).eps)
