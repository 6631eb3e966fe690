"""Backward error and sensitivity, which distinguish unstable solvers from ill-posed problems.

The backward error of an answer is the smallest relative change of the data (q, mu) under which it is exact: small for a stable
solver, however ill-posed the problem (Higham 2002, section 1.5). The sensitivity of a problem is the ratio of the change of
the solution to a small change of q: large for an ill-posed problem, whatever the solver.
"""

from collections.abc import Callable

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.forms.cone import project_cone
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.residual import residual

NORM_ROUNDING = 8 * np.finfo(float).eps  # the rounding error of a norm and of a product, with a margin
ROUND_OFF = 1e-13  # relative to a contact's unit: impulses that change the contact's velocity by less are neglected
CHANGE, DRAWS = 1e-7, 3  # of q in the contacts' units, a hundred times the residuals of answers; random changes that are tried


def backward_error(problem: FrictionProblem, impulse: Array) -> float:
    """The least eta for which impulse (nc, d) obeys Coulomb's law exactly with some |dq_i| <= eta unit_i, |dmu_i| <= eta mu_i.

    The smaller of two values is returned: for the answer itself, and for its projection onto the friction cones with impulses
    below rounding set to zero. Infinity if there is no such change.
    """
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0.0
    if impulse.shape != (nc, d) or not np.isfinite(impulse).all():
        return np.inf
    scale = np.where(problem.units > 0, problem.units, 1.0)
    felt = problem.scale * np.linalg.norm(impulse, axis=1) > ROUND_OFF * scale
    allowed = project_cone(impulse, problem.friction, problem.friction_bias) * felt[:, None]
    return min(_least_change(problem, impulse, scale), _least_change(problem, allowed, scale))


def _least_change(problem: FrictionProblem, impulse: Array, scale: Array) -> float:
    """The largest change over contacts, with u the answer's velocities. r_n > 0 requires u_n = 0, r_n = 0 requires u_n >= 0.
    Sticking requires u_t = 0 and r_t inside the cone; sliding requires u_t against r_t, and a mu with r_t on the cone.
    """
    n, t = impulse[:, 0], impulse[:, 1:]
    if (n < 0).any():
        return np.inf
    u = problem.contact_velocity(impulse)
    size, widest = np.linalg.norm(t, axis=1), problem.friction * n
    limit = widest + problem.friction_bias
    normal = np.where(n > 0, np.abs(u[:, 0]), np.maximum(-u[:, 0], 0.0))
    at_limit = np.abs(size - limit) <= NORM_ROUNDING * limit
    onto = np.where(at_limit, 0.0, np.where(widest > 0, np.abs(size - limit) / np.where(widest > 0, widest, 1.0), np.inf))
    against = np.where(size[:, None] > 0, -t / np.where(size > 0, size, 1.0)[:, None], 0.0)
    along = np.maximum(np.sum(u[:, 1:] * against, axis=1), 0.0)
    stick = np.linalg.norm(u[:, 1:], axis=1)
    slide = np.where((size == 0) & (limit == 0), 0.0, np.linalg.norm(u[:, 1:] - along[:, None] * against, axis=1))
    sliding = np.maximum(np.hypot(normal, slide) / scale, onto)
    sticking = np.maximum(np.hypot(normal, stick) / scale, np.where((size <= limit) | at_limit, 0.0, onto))
    return float(np.max(np.minimum(sliding, sticking)))


def sensitivity(problem: FrictionProblem, solve: Callable[[FrictionProblem], Array]) -> float:
    """The largest |du| / |dq| over random relative changes of q, with velocities in the contacts' units; infinity if a
    perturbed problem is not solved.

    solve returns the impulses (nc, d) of a problem; their residuals must be at most CHANGE / 100. If a problem has several
    isolated solutions, a jump between them counts as ill-posedness.
    """
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0.0
    random = np.random.default_rng(0)
    scale = problem.units[:, None]
    if not scale.all():
        return 0.0
    before = solve(problem)
    worst = 0.0
    for _ in range(DRAWS):
        share = CHANGE * random.uniform(-1, 1, (nc, d))
        q = problem.q + (share * scale).ravel()
        moved = FrictionProblem.from_delassus(problem.W, q, problem.friction, d, problem.friction_bias)
        after = solve(moved)
        if max(residual(problem, before), residual(moved, after)) > CHANGE / 100:
            return np.inf
        du = moved.contact_velocity(after) - problem.contact_velocity(before)
        worst = max(worst, float(np.max(np.abs(du) / scale) / np.max(np.abs(share))))
    return worst
