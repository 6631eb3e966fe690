"""The residual of an answer in Coulomb's law, on which every verdict is based.

Coulomb's law at a contact is equivalent to r = P_K(r - g(u)/s) for any s > 0, with the cone
K = {|r_t| <= mu r_n + b_f, r_n >= 0} and de Saxcé's shifted velocity g(u) = u + mu |u_t| e_n (De Saxcé and Feng 1998). The
residual measures the defect of that equation as a velocity, relative to the largest free contact velocity:

    max_i s_i | r_i - P_K(r_i - g(u_i)/s_i) |  /  max_i |q_i|

with s_i the mean diagonal of contact i's block of W. It is zero exactly at a solution, and invariant under changes of
units, of the order of the contacts and of their tangent frames. Without the shift, g(u) = u, the same formula measures the
convex relaxation's own optimality.

Every term has a rounding error of some eps: s r, the terms of the sum u, and mu times those of u_t. The sum of these errors
over |q| is the residual's floor, below which an answer cannot be judged: for impulses so large that eps s r exceeds |q|, the
computed residual may be 0 for wrong answers.
"""

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel
from frictionbench.problems.forms.cone import nearest
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem


def residual(problem: FrictionProblem, impulse: Array) -> float:
    """The residual of impulse (nc, d), N s, on the exact problem: the largest defect of Coulomb's law at a contact, as a
    velocity over the largest free contact velocity.

    Zero exactly at a solution; infinity where the impulse is not finite or has another shape. Errors: none.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual(problem, fb.solve(problem, "lemke").impulse) <= 1e-8
    True
    """
    return _defect(problem, impulse, shift=1.0)


def relaxation_residual(problem: FrictionProblem, impulse: Array, softness: Array | None = None) -> float:
    """The residual of impulse (nc, d) on the problem's convex relaxation, in the same measure.

    softness: (nc, d), R >= 0 in 1/kg, the compliance of regularised contacts, u = W r + q + R r.
    """
    return _defect(problem, impulse, shift=0.0, softness=softness)


def polygon_residual(problem: FrictionProblem, lcp: LCP, z: Array) -> float:
    """The residual of z on the friction problem's LCP, as a velocity over max|q_i|, independent of units:

    max |min(s z, w)| over the impulses c and beta, |min(z, s w)| over the sliding speeds lambda, s that of the contact.
    """
    z, nc = check.entries("z", z, lcp.size), problem.contacts
    if not nc:
        return 0.0
    s = np.concatenate([problem.scale, np.repeat(problem.scale, lcp.size // nc - 2), problem.scale])
    speed, force = np.arange(lcp.size) >= lcp.size - nc, lcp.M @ z + lcp.q
    worst = np.abs(np.minimum(np.where(speed, z, s * z), np.where(speed, s * force, force))).max()
    if not np.isfinite(worst):
        return np.inf
    return float(worst / problem.velocity_scale) if problem.velocity_scale else np.inf if worst else 0.0


def residual_floor(problem: FrictionProblem, impulse: Array) -> float:
    """A bound of the rounding error of impulse's (nc, d) residual: 2 eps max_i (s_i |r_i| + (1 + mu_i) |terms of u_i|)/|q|.

    Infinity where the impulse is not finite or has another shape. Errors: none.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual_floor(problem, fb.solve(problem, "lemke").impulse) < 1e-12
    True
    """
    if not problem.contacts:
        return 0.0
    if impulse.shape != (problem.contacts, problem.dimension) or not np.isfinite(impulse).all():
        return np.inf
    with np.errstate(over="ignore"):
        terms = np.linalg.norm(problem.velocity_size(impulse), axis=1)
        worst = np.max(problem.scale * np.linalg.norm(impulse, axis=1) + (1 + problem.friction) * terms)
    free = problem.velocity_scale
    return float(2 * np.finfo(float).eps * worst / free) if free and np.isfinite(worst) else np.inf if worst else 0.0


def energy_within(problem: FrictionProblem, impulse: Array, bound: float) -> float:
    """The largest energy defect, J, of impulses (nc, d) whose residual is within bound: bound |q| sum_i (|r_i| + |g(u_i)|/s_i).

    Because with p = P_K(r - g/s) and h = g + s (p - r), p.h = 0, the energy defect r.g (problems.simulate.ledger_defect) is
    s p.(r - p) + (r - p).h + s |r - p|^2.
    """
    u = problem.contact_velocity(impulse)
    u[:, 0] += problem.friction * np.linalg.norm(u[:, 1:], axis=1)
    sizes = np.linalg.norm(impulse, axis=1) + np.linalg.norm(u, axis=1) / problem.scale
    return float(bound * problem.velocity_scale * sizes.sum()) if problem.contacts else 0.0


def _defect(problem: FrictionProblem, impulse: Array, shift: float, softness: Array | None = None) -> float:
    nc, d = problem.contacts, problem.dimension
    if not nc:
        return 0.0
    if impulse.shape != (nc, d):
        return np.inf
    u = problem.contact_velocity(impulse)
    if softness is not None:
        u = u + softness * impulse
    worst = largest_defect(impulse, u, problem.scale, problem.friction, problem.friction_bias, shift)
    free = problem.velocity_scale
    if free == 0 or worst == np.inf:
        return 0.0 if worst == 0 else np.inf
    return float(worst / free)


@kernel
def largest_defect(r, u, s, mu, b, shift):  # type: ignore[no-untyped-def]
    """max_i s_i |r_i - P_K(r_i - (u_i + shift mu_i |u_t,i| e_n)/s_i)|, infinity where that is NaN."""
    worst = 0.0
    for i in range(len(r)):
        defect = s[i] * contact_defect(r[i], u[i], s[i], mu[i], b[i], shift)
        if not defect <= worst:
            worst = defect if defect < np.inf else np.inf
    return worst


@kernel
def _defects(r: Array, u: Array, s: Array, mu: Array, b: Array, shift: float) -> Array:
    """|r_i - P_K(r_i - (u_i + shift mu_i |u_t,i| e_n)/s_i)| (nc,), contact by contact."""
    defects = np.empty(len(r))
    for i in range(len(r)):
        defects[i] = contact_defect(r[i], u[i], s[i], mu[i], b[i], shift)
    return defects


@inlined
def contact_defect(r: Array, u: Array, s: float, mu: float, b: float, shift: float) -> float:
    """|r - P_K(r - (u + shift mu |u_t| e_n)/s)| of one contact, r and u (d,)."""
    sliding = size = 0.0
    for k in range(1, len(r)):
        sliding += u[k] * u[k]
        size += (r[k] - u[k] / s) ** 2
    n, share = nearest(r[0] - (u[0] + shift * mu * np.sqrt(sliding)) / s, np.sqrt(size), mu, b)
    square = (r[0] - n) ** 2
    for k in range(1, len(r)):
        square += (r[k] - share * (r[k] - u[k] / s)) ** 2
    return np.sqrt(square)


def fclib_error(problem: FrictionProblem, impulse: Array) -> float:
    """|r - P_K(r - g(u))| / |q| in Euclidean norms: FCLIB's error, for comparison with published figures.

    It depends on the units of mass (Acary, Brémond and Huber 2018, section 5.1).
    """
    if not problem.contacts:
        return 0.0
    if impulse.shape != (problem.contacts, problem.dimension) or not np.isfinite(impulse).all():
        return np.inf
    u, one = problem.contact_velocity(impulse), np.ones(problem.contacts)
    error = float(np.linalg.norm(_defects(impulse, u, one, problem.friction, problem.friction_bias, 1.0)))
    size = float(np.linalg.norm(problem.q))
    if not np.isfinite(error):
        return np.inf
    return error / size if size else error
