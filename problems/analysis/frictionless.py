"""Whether friction is at work in a problem, or its frictionless answer satisfies Coulomb's law.

Without friction the impulses are normal and minimise the kinetic energy: with tangential impulses zero,

    0 <= u_n  ⟂  r_n >= 0,      u = W r + q.

Such an answer satisfies Coulomb's law where no contact that bears slides; a stack at rest is an example. A friction problem
with such an answer tests a solver of linear complementarity problems without friction, and is called idle. The frictionless
velocities are unique, the impulses of hyperstatic contacts are not: the problem is idle if any of them satisfies the law.
"""

from collections.abc import Callable

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.reduce import keep_contacts
from frictionbench.problems.residual import residual, residual_floor

WITHIN = (
    1e-8  # the largest residual of a frictionless answer that satisfies Coulomb's law: the tightest tolerance of most suites
)
SLIDES = 1e-6  # of the contact's unit of velocity: a tangential velocity above it is sliding

Solve = Callable[[FrictionProblem], Array]


def idle(problem: FrictionProblem, solve: Solve) -> bool:
    """Whether a frictionless answer satisfies Coulomb's law, to WITHIN or to the rounding floor of the residual.

    solve gives the impulses (nc, d) of a problem, and its errors are passed on. Where the first frictionless answer presses a
    contact that slides, a second one without impulses at sliding contacts is tried: it exists if the law is satisfied by any.
    """
    r = frictionless_answer(problem, solve)
    if _satisfies(problem, r):
        return True
    u = problem.contact_velocity(r)
    slides = np.linalg.norm(u[:, 1:], axis=1) > SLIDES * problem.units
    if not (slides & (r[:, 0] > 0)).any() or slides.all():
        return False
    second = np.zeros_like(r)
    second[~slides] = frictionless_answer(keep_contacts(problem, np.flatnonzero(~slides).tolist()), solve)
    return _satisfies(problem, second)


def frictionless_answer(problem: FrictionProblem, solve: Solve) -> Array:
    """The impulses (nc, d), N s, of the problem without friction: all normal. Errors: those of solve."""
    none = np.zeros(problem.contacts)
    r = np.array(solve(problem.replace(friction=none, friction_bias=none)), dtype=float)
    r[:, 1:] = 0.0
    return r


def _satisfies(problem: FrictionProblem, impulse: Array) -> bool:
    return residual(problem, impulse) <= max(WITHIN, residual_floor(problem, impulse))
