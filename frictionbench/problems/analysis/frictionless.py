"""Whether friction matters in a problem, or its frictionless answer satisfies Coulomb's law.

Without friction the impulses are normal and minimise the kinetic energy: with tangential impulses zero,

    0 <= u_n  ⟂  r_n >= 0,      u = W r + q.

Such an answer satisfies Coulomb's law if no loaded contact with friction slides, as in a stack at rest. A friction problem with
such an answer tests only the solution of a frictionless complementarity problem, and is called idle. The frictionless
velocities are unique, but the impulses of hyperstatic contacts are not: the problem is idle if any of them satisfies the law.
"""

from collections.abc import Callable

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import residual, residual_floor
from frictionbench.problems.subproblems import keep_contacts

# A frictionless answer up to this residual satisfies Coulomb's law. It is the tightest tolerance of most suites.
IDLE_RESIDUAL = 1e-8

Solve = Callable[[FrictionProblem], Array]


def idle(problem: FrictionProblem, solve: Solve) -> bool:
    """Whether a frictionless answer satisfies Coulomb's law, to IDLE_RESIDUAL or to the rounding floor of the residual.

    solve returns the impulses (nc, d) of a problem, and its errors are passed on. If the first frictionless answer violates the
    law, a second one is tried, without impulses at sliding contacts with friction. Since the frictionless velocities are
    unique, it satisfies the law if any answer does.
    """
    r = frictionless_answer(problem, solve)
    within = max(IDLE_RESIDUAL, residual_floor(problem, r))
    if residual(problem, r) <= within:
        return True
    # With a large normal impulse alone, the residual of a contact is at least |u_t| sqrt(1 + mu^2) over its unit.
    defect = np.linalg.norm(problem.contact_velocity(r)[:, 1:], axis=1) * np.hypot(1.0, problem.friction)
    with_friction = (problem.friction > 0) | (problem.friction_bias > 0)
    others = np.flatnonzero(~(with_friction & (defect > within * problem.units)))
    if len(others) == problem.contacts:
        return False
    second = np.zeros_like(r)
    if len(others):
        second[others] = frictionless_answer(keep_contacts(problem, others.tolist()), solve)
    return residual(problem, second) <= max(IDLE_RESIDUAL, residual_floor(problem, second))


def frictionless_answer(problem: FrictionProblem, solve: Solve) -> Array:
    """The impulses (nc, d), N s, of the problem without friction: all normal. Errors: those of solve."""
    none = np.zeros(problem.contacts)
    r = np.array(solve(problem.replace(friction=none, friction_bias=none)), dtype=float)
    r[:, 1:] = 0.0
    return r
