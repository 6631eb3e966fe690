"""The violations of each part of Coulomb's law by an engine's answer.

At each contact, in m/s, where D is the disc of radius mu r_n + b_f and s is as in problems.residual,

    signorini      |min(s r_n, u_n)|                   0 <= u_n  ⟂  r_n >= 0
    cone           s max(|r_t| - mu r_n - b_f, 0)      friction beyond the cone
    direction      the part of E across u_t            friction that does not oppose the slip
    dissipation    the part of E along u_t             slip although friction could still hold, or too little friction

with E = s (p - P_D(p - u_t/s)), where p is the friction impulse projected onto D and P_D is that projection. All four are zero
exactly if Coulomb's law holds.

Engines may leave a penetration. The bias b = gap/step of a penetrating contact is therefore replaced by the value in [b, 0]
that fits the engine's answer best (docs/engines.md), so that only deeper penetration, or separation faster than b, is a
violation.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.native import EngineStep


class Violations(NamedTuple):
    """The violations of each contact (nc,), m/s."""

    signorini: Array
    cone: Array
    direction: Array
    dissipation: Array


def judged(step: EngineStep) -> FrictionProblem:
    """The problem by which the step is judged: it removes as much of each penetration as the engine did, at most all of it."""
    problem = step.problem
    if step.step is None or not problem.mechanical or not (problem.bias < 0).any():
        return problem
    speed = problem.contact_velocity(step.impulse)[:, 0] - problem.bias
    return problem.replace(bias=np.where(problem.bias < 0, np.clip(-speed, problem.bias, 0.0), problem.bias))


def penetration(step: EngineStep) -> float | None:
    """The deepest penetration at the start of the step, m; None if the length of the step is unknown."""
    return None if step.step is None else float(-step.step * step.problem.bias.min(initial=0.0)) + 0.0


def violations(problem: FrictionProblem, impulse: Array) -> Violations:
    """The violations of impulse (nc, d)."""
    u, s = problem.contact_velocity(impulse), problem.scale
    limit = np.maximum(problem.friction * impulse[:, 0] + problem.friction_bias, 0.0)
    inside = _cut(impulse[:, 1:], limit)
    beyond = s * np.linalg.norm(impulse[:, 1:] - inside, axis=1)
    defect = s[:, None] * (inside - _cut(inside - u[:, 1:] / s[:, None], limit))
    speed = np.linalg.norm(u[:, 1:], axis=1, keepdims=True)
    way = u[:, 1:] / np.where(speed > 0, speed, 1.0)
    along = np.sum(defect * way, axis=1)
    across = np.linalg.norm(defect - along[:, None] * way, axis=1)
    return Violations(np.abs(np.minimum(s * impulse[:, 0], u[:, 0])), beyond, across, np.abs(along))


def _cut(tangential: Array, limit: Array) -> Array:
    """The vectors (nc, d-1), shortened to lengths of at most limit (nc,)."""
    size = np.linalg.norm(tangential, axis=1)
    return tangential * np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0)[:, None]
