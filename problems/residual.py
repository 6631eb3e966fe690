"""The residual of an answer in Coulomb's law, on which every verdict is based.

Coulomb's law at a contact is equivalent to r = P_K(r - g(u)/s) for any s > 0, with the cone
K = {|r_t| <= mu r_n + b_f, r_n >= 0} and de Saxcé's shifted velocity g(u) = u + mu |u_t| e_n (De Saxcé and Feng 1998). The
residual measures the defect of that equation as a velocity, relative to the largest free velocity in the contact's island:

    max_i s_i | r_i - P_K(r_i - g(u_i)/s_i) | / unit_i

with s_i the mean diagonal of contact i's block of W, and unit_i the largest |q_j| of the contacts of its island that can bear
(problems.forms.islands), so that a part that rests does not hide behind another that is fast. It is zero exactly at a
solution, and invariant under changes of units, of the order of the contacts and of their tangent frames; that of problems side
by side is the largest of theirs. Without the shift, g(u) = u, the same formula measures the convex relaxation's own optimality.

Every term has a rounding error of some eps: s r, the terms of the sum u, and mu times those of u_t. The sum of these errors
over the unit is the residual's floor, below which an answer cannot be judged: for impulses so large that eps s r exceeds it,
the computed residual may be 0 for wrong answers. Where a contact is open beyond the errors, P_K(r - g/s) = 0 whatever they are.
"""

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel
from frictionbench.problems.forms.cone import nearest
from frictionbench.problems.forms.islands import length
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem

EPSILON = float(np.finfo(float).eps)


def residual(problem: FrictionProblem, impulse: Array) -> float:
    """The residual of impulse (nc, d), N s, on the exact problem: the largest defect of Coulomb's law at a contact, as a
    velocity over the contact's unit, `problem.units`.

    Zero exactly at a solution; infinity where the impulse is not finite or has another shape. Errors: none.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual(problem, fb.solve(problem, "lemke").impulse) <= 1e-8
    True
    """
    return float(largest(contact_residuals(problem, impulse)))


def relaxation_residual(problem: FrictionProblem, impulse: Array, softness: Array | None = None) -> float:
    """The residual of impulse (nc, d) on the problem's convex relaxation, in the same measure.

    softness: (nc, d), R >= 0 in 1/kg, the compliance of regularised contacts, u = W r + q + R r.
    """
    return float(largest(contact_residuals(problem, impulse, 0.0, softness)))


def contact_residuals(problem: FrictionProblem, impulse: Array, shift: float = 1.0, softness: Array | None = None) -> Array:
    """The residual of each contact (nc,), on the exact problem or with shift 0 on its convex relaxation."""
    nc = problem.contacts
    if impulse.shape != (nc, problem.dimension):
        return np.full(nc, np.inf)
    u = problem.contact_velocity(impulse)
    if softness is not None:
        u = u + softness * impulse
    law = problem.friction, problem.friction_bias
    return _residuals(impulse, u, problem.scale, *law, problem.units, shift)


def polygon_residual(problem: FrictionProblem, lcp: LCP, z: Array) -> float:
    """The residual of z on the friction problem's LCP, as a velocity over the contact's unit, independent of units:

    max |min(s z, w)| over the impulses c and beta, |min(z, s w)| over the sliding speeds lambda, s that of the contact.
    """
    return float(largest(polygon_residuals(problem, lcp, z)))


def polygon_residuals(problem: FrictionProblem, lcp: LCP, z: Array) -> Array:
    """The residual of each contact (nc,) on the friction problem's LCP."""
    z, nc = check.entries("z", z, lcp.size), problem.contacts
    if not nc:
        return np.zeros(0)
    many = lcp.size // nc - 2
    s = np.concatenate([problem.scale, np.repeat(problem.scale, many), problem.scale])
    speed, force = np.arange(lcp.size) >= lcp.size - nc, lcp.M @ z + lcp.q
    defect = np.abs(np.minimum(np.where(speed, z, s * z), np.where(speed, s * force, force)))
    parts = np.split(defect, [nc, lcp.size - nc])
    worst = np.max([parts[0], parts[1].reshape(nc, many).max(axis=1), parts[2]], axis=0)
    return relative(np.where(np.isfinite(worst), worst, np.inf), problem.units)


@kernel
def largest(values):  # type: ignore[no-untyped-def]
    """The largest of the contacts' values (nc,) >= 0, 0 for none."""
    most = 0.0
    for value in values:
        most = max(most, value)
    return most


def relative(velocity: Array, units: Array) -> Array:
    """velocity (nc,) >= 0 over the contacts' units; where nothing moves, 0 or infinity."""
    with np.errstate(over="ignore"):
        return np.where(units > 0, velocity / np.where(units > 0, units, 1.0), np.where(velocity > 0, np.inf, 0.0))


def residual_floor(problem: FrictionProblem, impulse: Array) -> float:
    """A bound of the rounding error of impulse's (nc, d) residual, the largest of `contact_floors`.

    Infinity where the impulse is not finite or has another shape. Errors: none.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual_floor(problem, fb.solve(problem, "lemke").impulse) < 1e-12
    True
    """
    return float(largest(contact_floors(problem, impulse)))


def residual_with_floor(problem: FrictionProblem, impulse: Array) -> tuple[float, float]:
    """The residual and its floor together, of finite impulses (nc, d), for solvers that stop by both."""
    u, terms = problem.contact_velocity(impulse), problem.velocity_size(impulse)
    found, floor = _largest_with_floor(impulse, u, terms, problem.scale, problem.friction, problem.friction_bias, problem.units)
    return found, floor


def contact_floors(problem: FrictionProblem, impulse: Array, shift: float = 1.0) -> Array:
    """A bound (nc,) of the rounding error of each contact's residual: 2 eps (s_i |r_i| + (1 + mu_i) |terms of u_i|)/unit_i, and
    of a contact that is open beyond it, without friction bias, 2 eps s_i |r_i|/unit_i. shift: as in contact_residuals.
    Infinity as in residual_floor."""
    nc = problem.contacts
    if impulse.shape != (nc, problem.dimension) or not np.isfinite(impulse).all():
        return np.full(nc, np.inf)
    u, terms = problem.contact_velocity(impulse), problem.velocity_size(impulse)
    law = problem.friction, problem.friction_bias
    return _floors(impulse, u, terms, problem.scale, *law, problem.units, shift)


def energy_within(problem: FrictionProblem, impulse: Array, bound: float) -> float:
    """The largest energy defect, J, of impulses (nc, d) whose residual is within bound.

    It is bound sum_i unit_i (|r_i| + |g(u_i)|/s_i), because with p = P_K(r - g/s) and h = g + s (p - r), p.h = 0, the energy
    defect r.g (problems.simulate.ledger_defect) is s p.(r - p) + (r - p).h + s |r - p|^2.
    """
    u = problem.contact_velocity(impulse)
    with np.errstate(over="ignore", invalid="ignore"):
        u[:, 0] += problem.friction * np.linalg.norm(u[:, 1:], axis=1)
        sizes = np.linalg.norm(impulse, axis=1) + np.linalg.norm(u, axis=1) / problem.scale
        return float(bound * (problem.units * sizes).sum())


@kernel
def _residuals(r, u, s, mu, b, units, shift):  # type: ignore[no-untyped-def]
    """(nc,): s_i |r_i - P_K(r_i - (u_i + shift mu_i |u_t,i| e_n)/s_i)| / unit_i, infinity where that is NaN."""
    result = np.empty(len(r))
    for i in range(len(r)):
        result[i] = relative_defect(s[i] * contact_defect(r[i], u[i], s[i], mu[i], b[i], shift), units[i])
    return result


@inlined
def relative_defect(defect: float, unit: float) -> float:
    """defect / unit; infinity where that is NaN, and where nothing moves but the defect is not 0."""
    share = defect / unit if unit > 0 or defect > 0 else 0.0
    return share if share < np.inf else np.inf


@kernel
def _largest_with_floor(r, u, terms, s, mu, b, units):  # type: ignore[no-untyped-def]
    """The largest of _residuals and of _floors, of Coulomb's law."""
    return largest(_residuals(r, u, s, mu, b, units, 1.0)), largest(_floors(r, u, terms, s, mu, b, units, 1.0))


@kernel
def _floors(r, u, terms, s, mu, b, units, shift):  # type: ignore[no-untyped-def]
    """(nc,): see contact_floors."""
    floor = np.empty(len(r))
    for i in range(len(r)):
        impulse, moved = s[i] * length(r[i], 0, r.shape[1]), (1 + mu[i]) * length(terms[i], 0, r.shape[1])
        worst = impulse + moved
        sliding = (1 - shift) * mu[i] * np.abs(u[i, 1:]).sum()
        if b[i] == 0 and u[i, 0] > (1 + mu[i]) * impulse + sliding + 2 * EPSILON * worst:
            worst = impulse
        floor[i] = relative_defect(2 * EPSILON * worst, units[i])
    return floor


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
