"""Coulomb's law at one contact, the other impulses held: the exact solve that contact-wise methods are built on.

With r and u the contact's present impulse and velocity, its block W = [[a, w'], [w~, W_t]] of the Delassus matrix gives
the velocity u + W (r+ - r) after a change of r. Two branches:

* open, r_n = 0: the friction left over is |r_t| <= b_f, and u_n >= 0 must come out;
* closed, u_n = 0: eliminating r_n = -(p_n + w'r_t)/a, with p_n the normal velocity where r = 0, leaves in the tangent

      S r_t + tau = -alpha r_t,   alpha >= 0 ⟂ |r_t| <= L - kappa'r_t,

  with S = W_t - w~w'/a, tau the tangential velocity where u_n = 0 and r_t = 0, L = b_f - mu p_n/a and kappa = mu w/a.

In the plane that is -tau/S clipped to an interval; in space a trust-region problem, one equation in alpha.

If mu|w| < a the contact has one solution. Otherwise it may have several (Painlevé): these laws prefer the open one, then
the sticking one, then a sliding one. At most one side of the cone then bounds r_t (kappa beyond -1 or 1: pushing
to that side jams the contact). A singular S is lifted by LIFT, about the present r_t, so that the fixed points stay exact.
References: Jean 1999; Daviet, Bertails-Descoubes and Boissieux 2011, for one exact spatial contact.
"""

from math import hypot

from frictionbench.problems.compiled import inlined, kernel, part
from frictionbench.problems.residual import contact_residual
from frictionbench.solvers.sweeps.form import state, velocity

LIFT = 1e-14  # added to a singular S, relative to the trace of W: a hundred units of rounding
TINY = 1e-300  # and where W is zero: no division by zero


@inlined
def planar_contact(u_n, u_t, r_n, r_t, W, mu, b_f):  # type: ignore[no-untyped-def]
    """(r_n, r_t) after; W: (2, 2)."""
    a, w, w_t, g = W[0, 0], W[0, 1], W[1, 0], W[1, 1]
    p_n = u_n - a * r_n - w * r_t
    least = LIFT * (a + g) + TINY
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


@kernel
def spatial_contact(u, r, W, mu, b_f):  # type: ignore[no-untyped-def]
    """Overwrite r (3,) by the impulse after; u: (3,), W: (3, 3)."""
    a, w1, w2 = W[0, 0], W[0, 1], W[0, 2]
    p_n = u[0] - a * r[0] - w1 * r[1] - w2 * r[2]
    lift = LIFT * (a + W[1, 1] + W[2, 2]) + TINY
    t1, t2 = 0.0, 0.0
    if b_f > 0:
        S11, S12, S21, S22 = W[1, 1] + lift, W[1, 2], W[2, 1], W[2, 2] + lift
        tau1 = u[1] - W[1, 0] * r[0] - S11 * r[1] - S12 * r[2]
        tau2 = u[2] - W[2, 0] * r[0] - S21 * r[1] - S22 * r[2]
        t1, t2 = bounded_tangent(S11, S12, S21, S22, tau1, tau2, b_f, 0.0, 0.0)
    if p_n + w1 * t1 + w2 * t2 >= 0 or a <= 0:
        r[0], r[1], r[2] = 0.0, t1, t2
        return
    c1, c2 = W[1, 0] / a, W[2, 0] / a
    S11, S12, S21, S22 = W[1, 1] - c1 * w1 + lift, W[1, 2] - c1 * w2, W[2, 1] - c2 * w1, W[2, 2] - c2 * w2 + lift
    tau1 = u[1] - c1 * u[0] - S11 * r[1] - S12 * r[2]
    tau2 = u[2] - c2 * u[0] - S21 * r[1] - S22 * r[2]
    t1, t2 = bounded_tangent(S11, S12, S21, S22, tau1, tau2, b_f - mu * p_n / a, mu * w1 / a, mu * w2 / a)
    r[0], r[1], r[2] = max(-(p_n + w1 * t1 + w2 * t2) / a, 0.0), t1, t2


@part
def bounded_tangent(S11, S12, S21, S22, tau1, tau2, L, k1, k2):  # type: ignore[no-untyped-def]
    """t with S t + tau = -alpha t, alpha >= 0 ⟂ |t| <= L - k't; zero where L <= 0.

    Newton's method on radius/|t| - 1, radius = L - k't, which is nearly linear in alpha (Moré and Sorensen 1983), kept inside a
    bracket: it is negative at alpha = 0 unless the contact sticks, and not negative at (1 + |k|) |tau| / L.
    """
    low, high = 0.0, (1 + hypot(k1, k2)) * hypot(tau1, tau2) / L
    alpha = 0.0
    t1, t2 = 0.0, 0.0
    for _ in range(100):
        d1, d2 = S11 + alpha, S22 + alpha
        det = d1 * d2 - S12 * S21
        t1, t2 = (S12 * tau2 - d2 * tau1) / det, (S21 * tau1 - d1 * tau2) / det
        size, radius = hypot(t1, t2), L - k1 * t1 - k2 * t2
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
        v1, v2 = (S12 * t2 - d2 * t1) / det, (S21 * t1 - d1 * t2) / det  # dt/dalpha
        slope = (-(k1 * v1 + k2 * v2) * size - radius * (t1 * v1 + t2 * v2) / size) / size
        alpha += excess / slope
        if not low < alpha < high:
            alpha = (low + high) / 2
            if alpha in (low, high):
                break
    return t1, t2


@kernel
def defect(form, r, u, shift):  # type: ignore[no-untyped-def]
    """The residual of problems.residual at impulses r and velocities u (nc, d); shift: 1.0 Coulomb, 0.0 the relaxation."""
    worst = 0.0
    for i in range(len(r)):
        law = form.friction[i], form.friction_bias[i]
        found = contact_residual(r[i], u[i], form.scale[i], law[0], law[1], form.units[i], shift)
        worst = found if found > worst else worst
    return worst


@inlined
def residual_at(form, r, x, u, shift):  # type: ignore[no-untyped-def]
    """The residual at impulses r, whose state x and velocities u are computed anew."""
    state(form, r, x)
    velocity(form, x, u)
    return defect(form, r, u, shift)
