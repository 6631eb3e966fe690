"""The residual of an answer in Coulomb's law, on which every verdict is based.

Coulomb's law at a contact is equivalent to r = P_K(r - g(u)/s) for any s > 0, with the cone
K = {|r_t| <= mu r_n + b_f, r_n >= 0} and de Saxcé's shifted velocity g(u) = u + mu |u_t| e_n (De Saxcé and Feng 1998). The
residual is the defect of this equation as a velocity, relative to the change that impulses must cause in the contact's island:

    max_i max( s_i | r_i - P_K(r_i - g(u_i)/s_i) |, |min(s_i r_n,i, u_n,i)| ) / unit_i

Here s_i is the mean of the positive diagonal entries of contact i's block of W. Without friction biases, unit_i is the
largest closing speed max(-q_n,j, 0) of the contacts of its island that can carry load (problems.forms.islands). Zero impulses
then have the residual 1 if impulses are needed, and a residual of 1e-8 is a defect of 1e-8 of that change. The residual is
zero exactly at a solution, but does not bound the distance from one. It is invariant under changes of units, also of a
joint's coordinate, of the order of contacts and of their tangent frames. That of problems side by side is the largest of
theirs. docs/residual.md states what it can hide.

The second term, the defect of Signorini's law, is implied by the first, but only up to a factor of sqrt(1 + mu^2): for a large
mu, K is nearly a half-space, so that the first term is small for a contact that penetrates while it slides.
Without the shift, g(u) = u, the first term measures the optimality in the convex relaxation.

Every term has a rounding error of a few eps: s r, the terms of the sum u, and mu times those of u_t. The sum of these errors
divided by the unit is the residual's floor, below which an answer cannot be judged: for very large impulses, rounding errors of
s r can make the computed residual of a wrong answer 0. If a contact is open by more than these errors, those of u_n do not
matter, and P_K(r - g/s) lies in the disc of radius b_f.
"""

from typing import Any

import numpy as np

from frictionbench.problems import check
from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, kernel, lean_kernel
from frictionbench.problems.forms.cone import nearest, project_cone
from frictionbench.problems.forms.delassus import act, pushed_contact_velocity, velocity_size
from frictionbench.problems.forms.islands import EPSILON, length
from frictionbench.problems.forms.lcp import LCP, by_unknown
from frictionbench.problems.friction import FrictionProblem

# The share of tol that methods ask of a residual of their own, which has other units or norms or is summed in another order.
TOL_SHARE = 0.5
LEAST_UNIT = 1e-250  # smaller units have no reciprocal


def residual(problem: FrictionProblem, impulse: Array) -> float:
    """The residual of impulse (nc, d), N s, on the exact problem: the largest defect of Coulomb's law at a contact, as a
    velocity divided by the contact's unit, `problem.units`.

    It is zero exactly at a solution, and infinity if the impulse is not finite or has another shape.
    Errors: InputError naming problem if it is not a FrictionProblem, or impulse if it is not an array of numbers.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual(problem, fb.solve(problem, "lemke").impulse) <= 1e-8
    True
    """
    return float(largest(contact_residuals(problem, _impulses(problem, impulse))))


def relaxation_residual(problem: FrictionProblem, impulse: Array, softness: Array | None = None) -> float:
    """The residual of impulse (nc, d) on the problem's convex relaxation, relative to `problem.relaxation_units`.

    softness: (nc, d), R >= 0 in 1/kg, the compliance of regularised contacts, u = W r + q + R r.
    """
    return float(largest(contact_residuals(problem, impulse, 0.0, softness)))


def contact_residuals(problem: FrictionProblem, impulse: Array, shift: float = 1.0, softness: Array | None = None) -> Array:
    """The residual of each contact (nc,) on the exact problem, or with shift 0 on its convex relaxation."""
    nc = problem.contacts
    if impulse.shape != (nc, problem.dimension):
        return np.full(max(nc, 1), np.inf)  # infinity also where there is no contact
    u = problem.contact_velocity(impulse)
    if softness is not None:
        u = u + softness * impulse
    law = problem.friction, problem.friction_bias
    return _residuals(impulse, u, problem.scale, *law, _units(problem, impulse, shift), shift)


def _units(problem: FrictionProblem, impulse: Array, shift: float = 1.0) -> Array:
    """The contacts' units (nc,); if nothing moves, the largest s_i |r_i|."""
    units = problem.units if shift else problem.relaxation_units
    if len(units) and units[0] == 0 and not units.any():  # testing the first is fast and nearly always enough
        return np.full(len(units), (problem.scale * np.linalg.norm(impulse, axis=1)).max())
    return units


def polygon_residual(problem: FrictionProblem, lcp: LCP, z: Array) -> float:
    """The residual of z on the friction problem's LCP, as a velocity divided by the contact's unit:

    max |min(s z, w)| for the impulses c and beta, |min(z, s w)| for the sliding speeds lambda, with the contact's s.
    """
    return float(largest(polygon_residuals(problem, lcp, z)))


def polygon_residuals(problem: FrictionProblem, lcp: LCP, z: Array) -> Array:
    """The residual of each contact (nc,) on the friction problem's LCP."""
    z, nc = check.entries("z", z, lcp.size), problem.contacts
    if not nc:
        return np.zeros(0)
    s = by_unknown(problem.scale, lcp.size)
    speed, force = np.arange(lcp.size) >= lcp.size - nc, lcp.M @ z + lcp.q
    defect = np.abs(np.minimum(np.where(speed, z, s * z), np.where(speed, s * force, force)))
    parts = np.split(defect, [nc, lcp.size - nc])
    worst = np.max([parts[0], parts[1].reshape(nc, -1).max(axis=1), parts[2]], axis=0)
    return relative(np.where(np.isfinite(worst), worst, np.inf), problem.units)


@kernel
def largest(values):  # type: ignore[no-untyped-def]
    """The largest of the contacts' values (nc,) >= 0; 0 without contacts."""
    most = 0.0
    for value in values:
        most = max(most, value)
    return most


def relative(velocity: Array, units: Array) -> Array:
    """velocity (nc,) >= 0 divided by the contacts' units; 0 or infinity if a unit is 0."""
    with np.errstate(over="ignore"):
        return np.where(units > 0, velocity / np.where(units > 0, units, 1.0), np.where(velocity > 0, np.inf, 0.0))


def residual_floor(problem: FrictionProblem, impulse: Array) -> float:
    """A bound on the rounding error of impulse's (nc, d) residual, the largest of `contact_floors`.

    It is infinity if the impulse is not finite or has another shape. Errors: as in `residual`.

    >>> import frictionbench as fb
    >>> problem = fb.scene("stack", blocks=2, push=1.0).problem()
    >>> fb.residual_floor(problem, fb.solve(problem, "lemke").impulse) < 1e-12
    True
    """
    return float(largest(contact_floors(problem, _impulses(problem, impulse))))


def _impulses(problem: FrictionProblem, impulse: Any) -> Array:
    """The impulse as floats. Errors: as in residual."""
    check.require(isinstance(problem, FrictionProblem), "problem", f"must be a FrictionProblem, got {type(problem)}")
    return check.floats("impulse", impulse)


def residual_with_floor(problem: FrictionProblem, impulse: Array) -> tuple[float, float]:
    """The residual and its floor together, for finite impulses (nc, d), for solvers whose stopping test uses both."""
    law = problem.scale, problem.friction, problem.friction_bias, _units(problem, impulse)
    if problem.mechanical and len(problem.joint_bias):
        error, floor = largest_with_floor(impulse, problem.contact_velocity(impulse), problem.velocity_size(impulse), *law)
    elif problem.mechanical:  # one call is faster than three for few contacts
        rows = *problem.contact_rows, *problem.inverse_rows
        error, floor = mechanical_with_floor(*rows, problem.free_velocity, impulse, problem.bias, *law)
    else:
        error, floor = known_with_floor(*problem.blocks, impulse, problem.offset, *law)
    return error, floor


def contact_floors(problem: FrictionProblem, impulse: Array, shift: float = 1.0) -> Array:
    """A bound (nc,) on the rounding error of each contact's residual: 2 eps (s_i |r_i| + (1 + mu_i) |terms of u_i|)/unit_i. For
    a contact that is open beyond it, 2 eps s_i |r_i|/unit_i, plus at most 2 s_i b_f,i/unit_i for its friction bias.
    shift: as in contact_residuals. Infinity as in residual_floor."""
    nc = problem.contacts
    if impulse.shape != (nc, problem.dimension) or not np.isfinite(impulse).all():
        return np.full(max(nc, 1), np.inf)
    u, terms = problem.contact_velocity(impulse), problem.velocity_size(impulse)
    law = problem.friction, problem.friction_bias
    return _floors(impulse, u, terms, problem.scale, *law, _units(problem, impulse, shift), shift)


@kernel
def _residuals(r, u, s, mu, b, units, shift):  # type: ignore[no-untyped-def]
    """(nc,): the residual of each contact."""
    result = np.empty(len(r))
    for i in range(len(r)):
        result[i] = contact_residual(r[i], u[i], s[i], mu[i], b[i], units[i], shift)
    return result


@inlined
def contact_residual(r, u, s, mu, b, unit, shift):  # type: ignore[no-untyped-def]
    """The residual of one contact, for r and u (d,); infinity if it is NaN, or if the unit is 0 and the defect is not.

    Velocities are first divided by the unit, so that those of an answer are of order one and their squares neither overflow nor
    underflow.
    """
    v = 1 / max(unit, LEAST_UNIT) if unit > 0 else 1.0
    s *= v
    defect, closed, opened = contact_defect(r, u, s, v, mu, b, shift), s * r[0], v * u[0]
    if shift == 1:
        signorini = abs(closed if closed < opened else opened)  # min and max would be branches, often mispredicted
        defect = signorini if signorini > defect else defect
    if unit < LEAST_UNIT:
        return relative_defect(defect, unit / LEAST_UNIT)
    return defect if defect < np.inf else np.inf


@inlined
def relative_defect(defect: float, unit: float) -> float:
    """defect / unit; infinity if this is NaN, or if the unit is 0 and the defect is not."""
    share = defect / unit if unit > 0 else defect
    return share if share == 0 or (unit > 0 and share < np.inf) else np.inf


@lean_kernel
def largest_with_floor(r, u, terms, s, mu, b, units):  # type: ignore[no-untyped-def]
    """The largest of _residuals and the largest of _floors, for Coulomb's law."""
    worst = floor = 0.0
    for i in range(len(r)):
        worst = max(worst, contact_residual(r[i], u[i], s[i], mu[i], b[i], units[i], 1.0))
        floor = max(floor, _contact_floor(r[i], u[i], terms[i], s[i], mu[i], b[i], units[i], 1.0))
    return worst, floor


@kernel
def mechanical_with_floor(  # type: ignore[no-untyped-def]
    start, column, J, m_start, m_column, m_value, free, r, bias, s, mu, b, units
):
    """largest_with_floor for the impulses r of a mechanical problem without joints."""
    u = pushed_contact_velocity(start, column, J, m_start, m_column, m_value, free, r, bias)
    terms = velocity_size(start, column, J, m_start, m_column, m_value, free, r, bias)
    return largest_with_floor(r, u, terms, s, mu, b, units)


@kernel
def known_with_floor(first, neighbours, block, r, q, s, mu, b, units):  # type: ignore[no-untyped-def]
    """largest_with_floor for the impulses r of a problem of which only W, by blocks, and q (nc, d) are known."""
    u, terms = act(first, neighbours, block, r, q, False), act(first, neighbours, block, r, q, True)
    return largest_with_floor(r, u, terms, s, mu, b, units)


@kernel
def _floors(r, u, terms, s, mu, b, units, shift):  # type: ignore[no-untyped-def]
    """(nc,): see contact_floors."""
    floor = np.empty(len(r))
    for i in range(len(r)):
        floor[i] = _contact_floor(r[i], u[i], terms[i], s[i], mu[i], b[i], units[i], shift)
    return floor


@inlined
def _contact_floor(r, u, terms, s, mu, b, unit, shift):  # type: ignore[no-untyped-def]
    """The floor of one contact, see contact_floors; r, u and terms (d,)."""
    impulse, moved = s * length(r, 0, len(r)), 2 * EPSILON * (1 + mu) * length(terms, 0, len(r))
    sliding = 0.0
    for k in range(1, len(u)):
        sliding += abs(u[k])
    if u[0] > (1 + mu) * impulse + (1 - shift) * mu * sliding + 2 * EPSILON * impulse + moved:
        moved = min(2 * EPSILON * length(terms, 1, len(r) - 1), 2 * s * b)
    return relative_defect(2 * EPSILON * impulse + moved, unit)


@inlined
def contact_defect(r, u, s, v, mu, b, shift):  # type: ignore[no-untyped-def]
    """|s r - P_K(s r - v (u + shift mu |u_t| e_n))| of one contact, for r and u (d,); K is the cone of s r, with bias s b."""
    sliding = size = 0.0
    for k in range(1, len(r)):
        sliding += (v * u[k]) ** 2
        size += (s * r[k] - v * u[k]) ** 2
    n, share = nearest(s * r[0] - v * u[0] - shift * mu * np.sqrt(sliding), np.sqrt(size), mu, s * b)
    square = (s * r[0] - n) ** 2
    for k in range(1, len(r)):
        square += (s * r[k] - share * (s * r[k] - v * u[k])) ** 2
    return np.sqrt(square)


def fclib_error(problem: FrictionProblem, impulse: Array) -> float:
    """|r - P_K(r - g(u))| / |q| in Euclidean norms: FCLIB's error, for comparison with published figures.

    It depends on the units of mass (Acary, Brémond and Huber 2018, section 5.1).
    """
    if impulse.shape != (problem.contacts, problem.dimension) or not np.isfinite(impulse).all():
        return np.inf
    if not problem.contacts:
        return 0.0
    unit = float(np.abs(problem.q).max()) or 1.0  # in this unit squares of q neither overflow nor underflow
    with np.errstate(over="ignore", invalid="ignore"):
        r, g = impulse / unit, problem.contact_velocity(impulse) / unit
        g[:, 0] += problem.friction * np.linalg.norm(g[:, 1:], axis=1)
        error = float(np.linalg.norm(r - project_cone(r - g, problem.friction, problem.friction_bias / unit)))
    error /= float(np.linalg.norm(problem.q / unit)) or 1.0
    return error if np.isfinite(error) else np.inf
