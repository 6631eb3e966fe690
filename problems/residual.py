"""How far an answer is from Coulomb's law: the one measure behind every verdict.

Coulomb's law at a contact says r = P_K(r - g(u)/s) for any s > 0, with the cone K = {|r_t| <= mu r_n + b_f, r_n >= 0} and
de Saxcé's shifted velocity g(u) = u + mu |u_t| e_n (De Saxcé and Feng 1998). The residual measures the defect of that
equation as a velocity, relative to the largest free contact velocity:

    max_i s_i | r_i - P_K(r_i - g(u_i)/s_i) |  /  max_i |q_i|

with s_i the mean diagonal of contact i's block of W. It is zero exactly at a solution, and a change of units, of the order
of the contacts or of their tangent frames changes nothing. Without the shift, g(u) = u, the same formula measures the
convex relaxation's own optimality.

Rounding leaves some eps of every term: of s r, of those that add up to u, and mu times those of u_t. Their sum over |q| is
the residual's floor. An answer cannot be judged any finer: of impulses so large that eps s r is beyond |q| the residual
may come out as 0 whatever they are.
"""

import numpy as np
from numba import njit

from problems.check import Array
from problems.friction import FrictionProblem


def project_cone(x: Array, mu: Array, b: Array) -> Array:
    """Project the rows of x (nc, d) on {|x_t| <= mu x_n + b, x_n >= 0}; mu, b: (nc,), >= 0."""
    n, t = x[:, 0], x[:, 1:]
    size = np.hypot.reduce(t, axis=1) if t.shape[1] > 1 else np.abs(t[:, 0])
    inside = (n >= 0) & (size <= mu * n + b)
    with np.errstate(over="ignore"):
        on_ray = (n + mu * (size - b)) / (1 + mu * mu)  # normal part of the nearest point of the slanted side
    normal = np.where(inside, n, np.where(size > mu * n + b, np.maximum(on_ray, 0.0), 0.0))
    limit = mu * normal + b
    factor = np.where(size > limit, limit / np.where(size > 0, size, 1.0), 1.0)
    return np.column_stack([normal, t * factor[:, None]])


def residual(problem: FrictionProblem, impulse: Array) -> float:
    """The residual of impulse (nc, d) on the exact problem; infinity where the impulse is not finite."""
    return _defect(problem, impulse, shifted=True)


def relaxation_residual(problem: FrictionProblem, impulse: Array) -> float:
    """The residual of impulse (nc, d) on the problem's convex relaxation, in the same measure."""
    return _defect(problem, impulse, shifted=False)


def residual_floor(problem: FrictionProblem, impulse: Array) -> float:
    """What rounding may change of the residual of impulse (nc, d): 2 eps max_i (s_i |r_i| + (1 + mu_i) |terms of u_i|)/|q|."""
    if not problem.contacts:
        return 0.0
    if not np.isfinite(impulse).all():
        return np.inf
    with np.errstate(over="ignore"):
        terms = np.linalg.norm(problem.velocity_size(impulse), axis=1)
        worst = np.max(problem.scale * np.linalg.norm(impulse, axis=1) + (1 + problem.friction) * terms)
    free = _largest(problem.q.reshape(-1, problem.dimension))
    return float(2 * np.finfo(float).eps * worst / free) if free and np.isfinite(worst) else np.inf if worst else 0.0


def energy_within(problem: FrictionProblem, impulse: Array, bound: float) -> float:
    """The largest energy defect, J, of impulses (nc, d) whose residual is within bound: bound |q| sum_i (|r_i| + |g(u_i)|/s_i).

    For with p = P_K(r - g/s) and h = g + s (p - r), p.h = 0, the ledger's r.g is s p.(r - p) + (r - p).h + s |r - p|^2.
    """
    u = problem.contact_velocity(impulse)
    u[:, 0] += problem.friction * np.linalg.norm(u[:, 1:], axis=1)
    sizes = np.linalg.norm(impulse, axis=1) + np.linalg.norm(u, axis=1) / problem.scale
    return float(bound * _largest(problem.q.reshape(u.shape)) * sizes.sum()) if problem.contacts else 0.0


def _defect(problem: FrictionProblem, impulse: Array, shifted: bool) -> float:
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0.0
    if impulse.shape != (nc, d) or not np.isfinite(impulse).all():
        return np.inf
    u = problem.contact_velocity(impulse)
    s = problem.scale
    worst = float(np.max(s * _defects(impulse, u, s, problem.friction, problem.friction_bias, shifted)))
    free = _largest(problem.q.reshape(nc, d))
    if not np.isfinite(worst):
        return np.inf
    if free == 0:
        return 0.0 if worst == 0 else np.inf
    return worst / free


@njit(cache=True)
def _defects(r: Array, u: Array, s: Array, mu: Array, b: Array, shifted: bool) -> Array:
    """|r_i - P_K(r_i - g(u_i)/s_i)| (nc,), contact by contact as project_cone has it."""
    nc, d = r.shape
    defects = np.empty(nc)
    for i in range(nc):
        sliding = 0.0
        for k in range(1, d):
            sliding += u[i, k] * u[i, k]
        n = r[i, 0] - (u[i, 0] + (mu[i] * np.sqrt(sliding) if shifted else 0.0)) / s[i]
        size = 0.0
        for k in range(1, d):
            size += (r[i, k] - u[i, k] / s[i]) ** 2
        size = np.sqrt(size)
        nearest = n
        if size > mu[i] * n + b[i]:
            nearest = max((n + mu[i] * (size - b[i])) / (1 + mu[i] * mu[i]), 0.0)
        elif n < 0:
            nearest = 0.0
        limit = mu[i] * nearest + b[i]
        factor = limit / size if size > limit else 1.0
        defect = (r[i, 0] - nearest) ** 2
        for k in range(1, d):
            defect += (r[i, k] - factor * (r[i, k] - u[i, k] / s[i])) ** 2
        defects[i] = np.sqrt(defect)
    return defects


@njit(cache=True)
def _largest(q: Array) -> float:
    """max_i |q_i|."""
    largest = 0.0
    for i in range(len(q)):
        square = 0.0
        for k in range(q.shape[1]):
            square += q[i, k] * q[i, k]
        largest = max(largest, square)
    return np.sqrt(largest)


def fclib_error(problem: FrictionProblem, impulse: Array) -> float:
    """|r - P_K(r - g(u))| / |q| in Euclidean norms: FCLIB's error, for comparison with published figures.

    It depends on the units of mass (Acary, Brémond and Huber 2018, section 5.1).
    """
    if not problem.contacts:
        return 0.0
    if not np.isfinite(impulse).all():
        return np.inf
    u, one = problem.contact_velocity(impulse), np.ones(problem.contacts)
    error = float(np.linalg.norm(_defects(impulse, u, one, problem.friction, problem.friction_bias, True)))
    size = float(np.linalg.norm(problem.q))
    if not np.isfinite(error):
        return np.inf
    return error / size if size else error
