"""Newton's equations of one contact (solvers.interior.point), solved by formula for given velocities of the bodies.

In the plane the unknowns are those of the friction LCP,

    (diag(s/x) + K) dx = g - H'du,      H'du = (du_n, du_t, -du_t, 0),      g = target/x - defect,

with K the matrix by which a contact's own unknowns act on its s. c is eliminated first, then beta+ and beta-, and lambda last:
every pivot is a sum of positive numbers.

In space they are c, s_0 = u_n - shift lambda and the pair y = (mu c + b_f, r_t), z = (lambda, u_t) in Lorentz' cone. The
products are linearised as they stand (Alizadeh, Haeberly and Overton 1998),

    c ds_0 + s_0 dc = target_0,      y ∘ dz + z ∘ dy = target,

and not after Nesterov and Todd's scaling, which needs the eigenvalue y_0 - |r_t| of a sliding contact's y to full precision
and ends at residuals of 1e-7. Here the two pivots are z_0 and

    D = y_0 z_0 - y_t . z_t,

which is 2 y_0 z_0 where the contact slides, r_t opposite to u_t, and positive for all y and z inside the cone. Given du,

    dz_t = du_t + defect_t,
    dlambda = (z_0 t_0 - z_t . t_t - (z_0 y_t - y_0 z_t) . dz_t - det(z) dy_0) / D,      dy_0 = mu dc + defect_3,
    dy_t = (t_t - y_0 dz_t - y_t dlambda - z_t dy_0) / z_0.

The delta of solvers.interior.newton replaces z by z + delta y, which adds delta dy to dz.
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined
from frictionbench.solvers.interior.point import Point, Vector
from frictionbench.solvers.interior.system import System

STICKS = 0.1  # det y / y_0^2 above which a contact clearly sticks, so that a division by det y loses no digits of dlambda


@inlined
def planar_stiffness(
    system: System, point: Point, i: int, softness: float, inverse: Array, pivot: Array
) -> tuple[Vector, Vector, Vector]:
    """C = H B^-1 H' by rows, the third zero; the inverses of x and of the pivots (nc, 4) are stored."""
    x, s, soft = point.x, point.s, softness * system.weight[i]
    inverse[i, 0] = 1 / x[i, 0]
    pivot[i, 0] = 1 / (s[i, 0] * inverse[i, 0] + soft)
    nn, nt, tn, tt = pivot[i, 0], 0.0, 0.0, 0.0
    if system.pairs[i] > 1:
        for k in range(1, 4):
            inverse[i, k] = 1 / x[i, k]
        pivot[i, 1] = 1 / (s[i, 1] * inverse[i, 1] + soft)
        pivot[i, 2] = 1 / (s[i, 2] * inverse[i, 2] + soft)
        total, skew = pivot[i, 1] + pivot[i, 2], pivot[i, 1] - pivot[i, 2]
        mu, shift = system.friction[i], system.shift[i]
        tangential = s[i, 3] * inverse[i, 3] + softness / system.weight[i]
        pivot[i, 3] = 1 / (tangential + total + mu * shift * nn)
        nt = shift * skew * pivot[i, 3] * nn
        tn = mu * skew * pivot[i, 3] * nn
        tt = total - skew * skew * pivot[i, 3]
        nn -= mu * shift * nn * nn * pivot[i, 3]
    return (nn, nt, 0.0), (tn, tt, 0.0), (0.0, 0.0, 0.0)


@inlined
def planar_step(
    system: System, point: Point, i: int, target: Array, defect: Array, u: Vector, inverse: Array, pivot: Array, step: Point
) -> None:
    """Fill dx = B^-1 (g - H'u) and ds for a change u of the contact's velocity."""
    mu, shift, s, dx = system.friction[i], system.shift[i], point.s, step.x
    c = pivot[i, 0] * (target[i, 0] * inverse[i, 0] - defect[i, 0] - u[0])
    plus = pivot[i, 1] * (target[i, 1] * inverse[i, 1] - defect[i, 1] - u[1])
    minus = pivot[i, 2] * (target[i, 2] * inverse[i, 2] - defect[i, 2] + u[1])
    slide = pivot[i, 3] * (target[i, 3] * inverse[i, 3] - defect[i, 3] + plus + minus - mu * c)
    dx[i, 0], dx[i, 1] = c + pivot[i, 0] * shift * slide, plus - pivot[i, 1] * slide
    dx[i, 2], dx[i, 3] = minus - pivot[i, 2] * slide, slide
    for k in range(4):
        step.s[i, k] = (target[i, k] - s[i, k] * dx[i, k]) * inverse[i, k]


@inlined
def _eliminate(x: Array, s: Array, i: int, mu: float, shift: float, soft: float) -> tuple[float, ...]:
    """The softened z, D, the vector a and the share in dlambda = ... - a . du_t - share mu dc, and the inverse pivot of c."""
    z0, z1, z2 = x[i, 3] + soft * s[i, 3], s[i, 1] + soft * x[i, 1], s[i, 2] + soft * x[i, 2]
    D = s[i, 3] * z0 - x[i, 1] * z1 - x[i, 2] * z2
    a1, a2 = (z0 * x[i, 1] - s[i, 3] * z1) / D, (z0 * x[i, 2] - s[i, 3] * z2) / D
    share = (z0 * z0 - z1 * z1 - z2 * z2) / D
    return z0, z1, z2, D, a1, a2, share, 1 / (s[i, 0] / x[i, 0] + soft + shift * mu * share)


@inlined
def spatial_stiffness(system: System, point: Point, i: int, softness: float) -> tuple[Vector, Vector, Vector]:
    """C = H B^-1 H' by rows."""
    x, s, mu, shift, soft = point.x, point.s, system.friction[i], system.shift[i], softness * system.weight[i]
    if system.pairs[i] == 1:
        n, row1, row2 = (1 / (s[i, 0] / x[i, 0] + soft), 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    else:
        z0, z1, z2, _, a1, a2, share, nn = _eliminate(x, s, i, mu, shift, soft)
        y0, y1, y2 = s[i, 3], x[i, 1], x[i, 2]
        n = (nn, nn * shift * a1, nn * shift * a2)
        m1, m2, inverse = mu * (z1 - share * y1), mu * (z2 - share * y2), 1 / z0
        row1 = (-m1 * n[0] * inverse, (y0 - y1 * a1 - m1 * n[1]) * inverse, (-y1 * a2 - m1 * n[2]) * inverse)
        row2 = (-m2 * n[0] * inverse, (-y2 * a1 - m2 * n[1]) * inverse, (y0 - y2 * a2 - m2 * n[2]) * inverse)
    return n, row1, row2


@inlined
def spatial_step(
    system: System, point: Point, i: int, target: Array, defect: Array, u: Vector, softness: float, step: Point
) -> None:
    """Fill dx = (dc, dr_t, dlambda) and ds for a change u of the contact's velocity.

    For a sticking contact dlambda follows from the products, because du_t carries the rounding errors of large impulses while
    lambda and u_t go to zero.
    """
    x, s, dx, ds = point.x, point.s, step.x, step.s
    mu, shift, soft = system.friction[i], system.shift[i], softness * system.weight[i]
    if system.pairs[i] == 1:
        dx[i, 0] = (target[i, 0] / x[i, 0] - defect[i, 0] - u[0]) / (s[i, 0] / x[i, 0] + soft)
        ds[i, 0] = (target[i, 0] - s[i, 0] * dx[i, 0]) / x[i, 0]
    else:
        z0, z1, z2, D, a1, a2, share, nn = _eliminate(x, s, i, mu, shift, soft)
        y0, y1, y2 = s[i, 3], x[i, 1], x[i, 2]
        t1, t2, t3 = target[i, 1], target[i, 2], target[i, 3]
        d1, d2 = u[1] + defect[i, 1], u[2] + defect[i, 2]
        slide = (z0 * t3 - z1 * t1 - z2 * t2) / D - a1 * d1 - a2 * d2 - share * defect[i, 3]
        c = nn * (target[i, 0] / x[i, 0] - defect[i, 0] - u[0] + shift * slide)
        slide -= share * mu * c
        y = mu * c + defect[i, 3]
        r1 = (t1 - y0 * d1 - y1 * slide - z1 * y) / z0
        r2 = (t2 - y0 * d2 - y2 * slide - z2 * y) / z0
        # With the original z: what the products leave for dlambda and du_t.
        z0, z1, z2 = x[i, 3], s[i, 1], s[i, 2]
        t1, t2, t3 = t1 - z0 * r1 - z1 * y, t2 - z0 * r2 - z2 * y, t3 - z0 * y - z1 * r1 - z2 * r2
        det = y0 * y0 - y1 * y1 - y2 * y2
        if det > STICKS * y0 * y0:
            slide = (y0 * t3 - y1 * t1 - y2 * t2) / det
        dx[i, 0], dx[i, 1], dx[i, 2], dx[i, 3] = c, r1, r2, slide
        ds[i, 0] = (target[i, 0] - s[i, 0] * c) / x[i, 0]
        ds[i, 1], ds[i, 2], ds[i, 3] = (t1 - y1 * slide) / y0, (t2 - y2 * slide) / y0, y
