"""By how much an engine's answer violates each part of Coulomb's law.

At each contact, as a velocity, with D the disc of radius mu r_n + b_f and s as in problems.residual,

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
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.own import EngineStep


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
