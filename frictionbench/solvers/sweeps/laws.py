"""Coulomb's law at one contact with all other impulses fixed: the exact solve on which contact-wise methods are built.

With r and u the contact's present impulse and velocity, its block W = [[a, w'], [w~, W_t]] of the Delassus matrix gives
the velocity u + W (r+ - r) after a change of r. Two branches:

* open, r_n = 0: friction is bounded by |r_t| <= b_f, and u_n >= 0 must result;
* closed, u_n = 0: eliminating r_n = -(p_n + w'r_t)/a, with p_n the normal velocity at r = 0, leaves in the tangent plane

      S r_t + tau = -alpha r_t,   alpha >= 0 ⟂ |r_t| <= L - kappa'r_t,

  with S = W_t - w~w'/a, tau the tangential velocity at u_n = 0 and r_t = 0, L = b_f - mu p_n/a and kappa = mu w/a.

In the plane the solution is -tau/S clipped to an interval; in space it is a trust-region problem, one equation in alpha.

If mu|w| < a the contact has one solution. Otherwise it may have several (Painlevé): the open one is preferred, then the
sticking one, then a sliding one. Then at most one side of the cone bounds r_t (|kappa| > 1: pushing to the other side jams the
contact). Eigenvalues of S below LIFT are raised to it, in the equation for the change of r_t, so that fixed points stay exact.
References: Jean 1999; Daviet, Bertails-Descoubes and Boissieux 2011, for one exact spatial contact.
"""

from math import sqrt

import numpy as np

from frictionbench.problems.compiled import inlined, kernel, part
from frictionbench.problems.forms.islands import EPSILON
from frictionbench.problems.residual import contact_residual
from frictionbench.solvers.sweeps.form import state, velocity

LIFT = 1e-14  # the least eigenvalue of S, relative to the trace of W_t: a hundred units of rounding, in double
TINY = 1e-150  # added to it: a determinant, the product of two of these, is not zero even if W_t = 0


@inlined
def lift(W):  # type: ignore[no-untyped-def]
    """LIFT in the precision of W."""
    return LIFT * (np.finfo(W.dtype).eps / EPSILON)


@inlined
def planar_contact(u_n, u_t, r_n, r_t, W, mu, b_f):  # type: ignore[no-untyped-def]
    """The new (r_n, r_t); W: (2, 2)."""
    a, w, w_t, g = W[0, 0], W[0, 1], W[1, 0], W[1, 1]
    p_n = u_n - a * r_n - w * r_t
    least = lift(W) * (a + g) + TINY
    t = 0.0
    if b_f > 0:
        t = min(max(r_t - (u_t - w_t * r_n) / max(g, least), -b_f), b_f)
    if p_n + w * t >= 0 or a <= 0:
        return 0.0, t
    L, kappa = b_f - mu * p_n / a, mu * w / a
    t = r_t - (u_t - w_t / a * u_n) / max(g - w * w_t / a, least)
    if kappa > -1:
        t = min(t, L / (1 + kappa))
    if kappa < 1:
        t = max(t, -L / (1 - kappa))
    return max(-(p_n + w * t) / a, 0.0), t


@part
def spatial_contact(u, r, W, mu, b_f):  # type: ignore[no-untyped-def]
    """Overwrite r (3,) with the new impulse; u: (3,), W: (3, 3)."""
    a, w1, w2 = W[0, 0], W[0, 1], W[0, 2]
    p_n = u[0] - a * r[0] - w1 * r[1] - w2 * r[2]
    least = lift(W) * (W[1, 1] + W[2, 2]) + TINY
    t1, t2 = 0.0, 0.0
    if b_f > 0:
        p1, p2 = u[1] - W[1, 0] * r[0], u[2] - W[2, 0] * r[0]
        t1, t2 = bounded_tangent(W[1, 1], W[1, 2], W[2, 1], W[2, 2], least, p1, p2, r[1], r[2], b_f, 0.0, 0.0)
    if p_n + w1 * t1 + w2 * t2 >= 0 or a <= 0:
        r[0], r[1], r[2] = 0.0, t1, t2
        return
    c1, c2 = W[1, 0] / a, W[2, 0] / a
    S11, S12, S21, S22 = W[1, 1] - c1 * w1, W[1, 2] - c1 * w2, W[2, 1] - c2 * w1, W[2, 2] - c2 * w2
    p1, p2, L = u[1] - c1 * u[0], u[2] - c2 * u[0], b_f - mu * p_n / a
    open1, open2 = t1, t2
    t1, t2 = bounded_tangent(S11, S12, S21, S22, least, p1, p2, r[1], r[2], L, mu * w1 / a, mu * w2 / a)
    n = -(p_n + w1 * t1 + w2 * t2) / a
    if n < 0:  # neither branch holds: in a singular block friction alone may stop u_n, which is then negative by rounding
        n, t1, t2 = 0.0, open1, open2
    size, radius = sqrt(t1 * t1 + t2 * t2), mu * n + b_f
    if size > radius:  # by rounding
        t1, t2 = t1 * (radius / size), t2 * (radius / size)
    r[0], r[1], r[2] = n, t1, t2


@part
def bounded_tangent(S11, S12, S21, S22, least, p1, p2, r1, r2, L, k1, k2):  # type: ignore[no-untyped-def]
    """t with p + S (t - r) = -alpha t, alpha >= 0 ⟂ |t| <= L - k't; zero where L <= 0 and t does not stick.

    It is solved along the axes in which S is diag(g, h) + [[0, s], [-s, 0]]: with g and h raised to `least`, no determinant
    suffers from cancellation, whatever the rank of S. alpha is the root of radius/|t| - 1, radius = L - k't, which is nearly
    linear in alpha. It is found by Newton's method (Moré and Sorensen 1983) inside a bracket: the function is negative at
    alpha = 0 unless the contact sticks, and not negative at (1 + |k|) |tau| / L. A t outside by rounding is scaled back.
    """
    mean, half, across, s = (S11 + S22) / 2, (S11 - S22) / 2, (S12 + S21) / 2, (S12 - S21) / 2
    spread = sqrt(half * half + across * across)
    g, h = max(mean + spread, least), max(mean - spread, least)
    # The axis of g: the longer of two expressions of the eigenvector, in which nothing cancels.
    e1, e2 = (half + spread, across) if half > 0 else (across, spread - half)
    length = sqrt(e1 * e1 + e2 * e2)
    e1, e2 = (e1 / length, e2 / length) if length > 0 else (1.0, 0.0)
    x, y = e1 * r1 + e2 * r2, e1 * r2 - e2 * r1
    tau1, tau2 = e1 * p1 + e2 * p2 - g * x - s * y, e1 * p2 - e2 * p1 + s * x - h * y
    k1, k2 = e1 * k1 + e2 * k2, e1 * k2 - e2 * k1
    low, high = 0.0, (1 + sqrt(k1 * k1 + k2 * k2)) * sqrt(tau1 * tau1 + tau2 * tau2) / L
    alpha = 0.0
    for _ in range(100):
        d1, d2 = g + alpha, h + alpha
        det = d1 * d2 + s * s
        x, y = (s * tau2 - d2 * tau1) / det, -(s * tau1 + d1 * tau2) / det
        size, radius = sqrt(x * x + y * y), L - k1 * x - k2 * y
        excess = size - radius
        if alpha == 0 and excess <= 0:
            break
        if L <= 0:
            return 0.0, 0.0
        if abs(excess) <= 4e-16 * size:
            break
        if excess > 0:
            low = alpha
        else:
            high = alpha
        v1, v2 = (s * y - d2 * x) / det, -(s * x + d1 * y) / det  # dt/dalpha
        slope = (-(k1 * v1 + k2 * v2) * size - radius * (x * v1 + y * v2) / size) / size
        alpha += excess / slope
        if not low < alpha < high:
            alpha = (low + high) / 2
            if alpha in (low, high):
                break
    share = L / (size + L - radius) if excess > 0 else 1.0
    return share * (e1 * x - e2 * y), share * (e2 * x + e1 * y)


@kernel
def defect(form, r, u, shift):  # type: ignore[no-untyped-def]
    """The residual of problems.residual at impulses r and velocities u (nc, d); shift: 1.0 Coulomb, 0.0 the relaxation."""
    worst = 0.0
    for i in range(len(r)):
        law = form.friction[i], form.friction_bias[i]
        error = contact_residual(r[i], u[i], form.scale[i], law[0], law[1], form.units[i], shift)
        worst = error if error > worst else worst
    return worst


@inlined
def residual_at(form, r, x, u, shift):  # type: ignore[no-untyped-def]
    """The residual at impulses r; x and u are overwritten with their state and velocities."""
    state(form, r, x)
    velocity(form, x, u)
    return defect(form, r, u, shift)
