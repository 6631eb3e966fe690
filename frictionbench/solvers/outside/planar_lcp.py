"""Glocker and Pfeiffer's friction LCP in the plane, of three unknowns per contact, dense, for libraries of LCPs.

With s = mu r_n + b_f + r_t, the distance of the impulse from one edge of the cone, and u_t = g+ - g-,

    0 <= (r_n, s, g-)   ⟂   (u_n, g+, 2 mu r_n + 2 b_f - s) >= 0.

It has the same solutions as the LCP of Stewart and Trinkle (problems.forms.lcp), which has four unknowns per contact, and M is
no more dense. It is made of the dimensionless W^ and q^ of solvers.outside.scaled_delassus.
Reference: Glocker and Pfeiffer 1992.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems import LCP, FrictionProblem
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel
from frictionbench.solvers.interface import Answer, Status
from frictionbench.solvers.outside.scaled_delassus import ScaledDelassus, scaled_delassus
from frictionbench.solvers.pivots.dense_lcp import DenseLCP, dense_lcp


class PlanarLCP(NamedTuple):
    """The right-hand side of w = M y + q, the scaled form it was made from, and the dimensionless b_f (nc,)."""

    problem: FrictionProblem
    form: ScaledDelassus
    q: Array
    bias: Array

    @property
    def unit(self) -> Array:
        """(2, 3 nc): the factors of y and w in the residual."""
        force = self.form.theta / (self.form.E * np.where(self.problem.units > 0, self.problem.units, 1.0))
        return np.tile(np.concatenate([force, *[(1 + self.form.friction) * force] * 2]), (2, 1))

    def answer(self, y: Array, status: Status, detail: str = "", clock: float | None = None, **work: int) -> Answer:
        """The answer of a scaled solution y (3 nc,)."""
        impulse = _impulse(y, self.form.friction, self.bias, self.form.theta * self.form.E)
        return Answer(impulse, status, work, detail=detail, clock=clock)


def smallest_lcp(problem: FrictionProblem | LCP) -> DenseLCP:
    """The LCP above for a friction problem in the plane; for others that of solvers.pivots.dense_lcp."""
    if isinstance(problem, LCP) or problem.dimension == 3:
        return dense_lcp(problem)
    form = scaled_delassus(problem)
    M, q, bias = _three_rows(form.W, form.q, form.friction, problem.friction_bias, form.theta * form.E)
    return DenseLCP(PlanarLCP(problem, form, q, bias), M, q)


@kernel
def _three_rows(W, q, mu, b_f, size):  # type: ignore[no-untyped-def]
    """M, its right-hand side, and b_f over the size of impulses."""
    n, b = len(mu), b_f / size
    M, right = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for i in range(n):
        for k in range(2):  # u_n, then u_t = g+ - g-
            right[k * n + i] = q[2 * i + k]
            for j in range(n):
                M[k * n + i, j] = W[2 * i + k, 2 * j] - mu[j] * W[2 * i + k, 2 * j + 1]
                M[k * n + i, n + j] = W[2 * i + k, 2 * j + 1]
                right[k * n + i] -= W[2 * i + k, 2 * j + 1] * b[j]
        M[n + i, 2 * n + i], M[2 * n + i, i], M[2 * n + i, n + i], right[2 * n + i] = 1.0, 2 * mu[i], -1.0, 2 * b[i]
    return M, right, b


@kernel
def _impulse(y, mu, b, size):  # type: ignore[no-untyped-def]
    """(nc, 2): r_n and r_t = s - mu r_n - b_f."""
    n, r = len(mu), np.empty((len(mu), 2))
    for i in range(n):
        r[i, 0], r[i, 1] = size[i] * y[i], size[i] * (y[n + i] - mu[i] * y[i] - b[i])
    return r
