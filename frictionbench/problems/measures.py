"""Measures of an answer besides problems.residual: the defects of the parts of Coulomb's law.

`defects` are measures used in the literature, with D the disc of radius mu r_n + b_f and g(u) = u + mu |u_t| e_n,

    signorini      0 <= u_n  ⟂  r_n >= 0:                   max_i |min(s_i r_n, u_n)| / unit_i
    dissipation    maximum dissipation of r_t:              max_i s_i |r_t - P_D(r_t - u_t/s_i)| / unit_i
    ncp            K ∋ r  ⟂  g(u) ∈ K*:                     the largest of s_i dist(r_i, K)/unit_i, dist(g_i, K*)/unit_i
                                                            and s_i |r_i.g_i + b_f |u_t|| / unit_i^2

s_i and unit_i as in problems.residual, so that all three are dimensionless. Each is zero at a solution; the first two together
are zero only there. Le Lidec and others (2024) compare simulators by defects of this kind, in units.

`violations` state at each contact, as a velocity, by how much an engine's answer violates each law,

    signorini      |min(s r_n, u_n)|                   0 <= u_n  ⟂  r_n >= 0
    cone           s max(|r_t| - mu r_n - b_f, 0)      friction beyond the cone
    direction      the part of E across u_t            friction that does not oppose the slip
    dissipation    the part of E along u_t             slip although friction could still hold, or too little of it

with E = s (p - P_D(p - u_t/s)), p the friction impulse cut to D. The four are zero together exactly where Coulomb's law holds.

A step that begins with bodies that penetrate says nothing about how much of the penetration it has to take away: engines spread
that over many steps on purpose. The bias b = gap/step of such a contact is therefore read as any value from b to 0, the one
that suits the engine's answer best: what is left of the penetration is stated in metres, and a violation is only to go deeper,
or to separate faster than the penetration takes.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.forms.cone import project_cone
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.own import EngineStep


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
    nearest = _cut(impulse[:, 1:] - u[:, 1:] / s[:, None], np.maximum(mu * impulse[:, 0] + b, 0.0))
    dissipation = s * np.linalg.norm(impulse[:, 1:] - nearest, axis=1)
    g = u.copy()
    g[:, 0] += mu * speed
    outside = s * np.linalg.norm(impulse - project_cone(impulse, mu, b), axis=1)
    separated = np.linalg.norm(project_cone(-g, mu, np.zeros(nc)), axis=1)  # = dist(g, K*)
    product = s * np.abs(np.sum(impulse * g, axis=1) + b * speed) / free
    worst = np.max(np.array([signorini, dissipation, np.maximum(np.maximum(outside, separated), product)]) / free, axis=1)
    return Defects(*(float(value) if np.isfinite(value) else np.inf for value in worst))


class Violations(NamedTuple):
    """The violations of each contact (nc,), m/s."""

    signorini: Array
    cone: Array
    direction: Array
    dissipation: Array


def judged(step: EngineStep) -> FrictionProblem:
    """The problem by which the step is judged: of penetrations as much is taken away as the engine did, at most all."""
    problem = step.problem
    if step.step is None or not problem.mechanical or not (problem.bias < 0).any():
        return problem
    speed = problem.contact_velocity(step.impulse)[:, 0] - problem.bias
    return problem.replace(bias=np.where(problem.bias < 0, np.clip(-speed, problem.bias, 0.0), problem.bias))


def penetration(step: EngineStep) -> float | None:
    """The deepest penetration with which the step begins, m; None where the step's length is not known."""
    return None if step.step is None else float(-step.step * step.problem.bias.min(initial=0.0)) + 0.0


def violations(problem: FrictionProblem, impulse: Array) -> Violations:
    """The violations of impulse (nc, d)."""
    u, s = problem.contact_velocity(impulse), problem.scale
    limit = np.maximum(problem.friction * impulse[:, 0] + problem.friction_bias, 0.0)
    inside = _cut(impulse[:, 1:], limit)
    beyond = s * np.linalg.norm(impulse[:, 1:] - inside, axis=1)
    defect = s[:, None] * (inside - _cut(inside - u[:, 1:] / s[:, None], limit))
    speed = np.linalg.norm(u[:, 1:], axis=1)
    along = np.sum(defect * u[:, 1:], axis=1) / np.where(speed > 0, speed, 1.0)
    across = np.sqrt(np.maximum(np.sum(defect**2, axis=1) - along**2, 0.0))
    return Violations(np.abs(np.minimum(s * impulse[:, 0], u[:, 0])), beyond, across, np.abs(along))


def _cut(tangential: Array, limit: Array) -> Array:
    """The vectors (nc, d-1), shortened to the limits (nc,)."""
    size = np.linalg.norm(tangential, axis=1)
    return tangential * np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0)[:, None]
