"""The defects of the parts of Coulomb's law, in measures used in the literature, besides problems.residual.

    signorini      0 <= u_n  ⟂  r_n >= 0:                   max_i |min(s_i r_n, u_n)| / unit_i
    dissipation    maximum dissipation of r_t:              max_i s_i |r_t - P_D(r_t - u_t/s_i)| / unit_i
    ncp            K ∋ r  ⟂  g(u) ∈ K*:                     the largest of s_i dist(r_i, K)/unit_i, dist(g_i, K*)/unit_i
                                                            and s_i |r_i.g_i + b_f |u_t|| / unit_i^2

with D the disc of radius mu r_n + b_f, g(u) = u + mu |u_t| e_n, and s_i and unit_i as in problems.residual, so that all three
are dimensionless. Each is zero at a solution; the first two together are zero only there. Le Lidec and others (2024)
compare simulators by a Signorini, a maximum dissipation and a complementarity defect of this kind, in units.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.forms.cone import project_cone
from frictionbench.problems.friction import FrictionProblem


class Defects(NamedTuple):
    """The defects of one answer; infinity where the answer is not finite."""

    signorini: float
    dissipation: float
    ncp: float


def defects(problem: FrictionProblem, impulse: Array) -> Defects:
    """The defects of impulse (nc, d)."""
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return Defects(0.0, 0.0, 0.0)
    if impulse.shape != (nc, d) or not np.isfinite(impulse).all():
        return Defects(np.inf, np.inf, np.inf)
    u, s, mu, b = problem.contact_velocity(impulse), problem.scale, problem.friction, problem.friction_bias
    free = np.where(problem.units > 0, problem.units, 1.0)
    speed = np.linalg.norm(u[:, 1:], axis=1)
    signorini = np.abs(np.minimum(s * impulse[:, 0], u[:, 0]))
    wanted = impulse[:, 1:] - u[:, 1:] / s[:, None]
    size, limit = np.linalg.norm(wanted, axis=1), np.maximum(mu * impulse[:, 0] + b, 0.0)
    nearest = wanted * np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0)[:, None]
    dissipation = s * np.linalg.norm(impulse[:, 1:] - nearest, axis=1)
    g = u.copy()
    g[:, 0] += mu * speed
    outside = s * np.linalg.norm(impulse - project_cone(impulse, mu, b), axis=1)
    separated = np.linalg.norm(project_cone(-g, mu, np.zeros(nc)), axis=1)  # = dist(g, K*)
    product = s * np.abs(np.sum(impulse * g, axis=1) + b * speed) / free
    worst = np.max(np.array([signorini, dissipation, np.maximum(np.maximum(outside, separated), product)]) / free, axis=1)
    return Defects(*(float(value) if np.isfinite(value) else np.inf for value in worst))
