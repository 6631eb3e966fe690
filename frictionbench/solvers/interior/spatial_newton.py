"""Newton's equations of spatial contacts with the circular cone (solvers.interior.point).

A contact's unknowns are c, s_0 = u_n - shift lambda and the pair y = (mu c + b_f, r_t), z = (lambda, u_t) in Lorentz' cone. The
products are linearised as they stand (Alizadeh, Haeberly and Overton 1998),

    c ds_0 + s_0 dc = target_0,      y ∘ dz + z ∘ dy = target,

and not after Nesterov and Todd's scaling, which needs the eigenvalue y_0 - |r_t| of a sliding contact's y to full precision
and ends at residuals of 1e-7. Here the two pivots are z_0 and

    D = y_0 z_0 - y_t . z_t,

which is 2 y_0 z_0 where the contact slides, r_t opposite to u_t, and positive for all y and z inside the cone. Given du,

    dz_t = du_t + defect_t,
    dlambda = (z_0 t_0 - z_t . t_t - (z_0 y_t - y_0 z_t) . dz_t - det(z) dy_0) / D,      dy_0 = mu dc + defect_3,
    dy_t = (t_t - y_0 dz_t - y_t dlambda - z_t dy_0) / z_0.

The delta of solvers.interior.newton comes in as z + delta y in place of z, which adds delta dy to dz.
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import inlined, part
from frictionbench.solvers.interior.elements import add_spatial, larger, natural, push_spatial, read_spatial
from frictionbench.solvers.interior.point import Point
from frictionbench.solvers.interior.system import System, Work

INSIDE = 0.1  # det y / y_0^2 above which a contact clearly sticks, and dlambda may be divided by det y without loss of digits


@part
def push_spatial_impulses(system: System, x: Array, impulse: Array, momentum: Array) -> None:
    """The impulses r = H x, and momentum += J'r."""
    for i in range(len(x)):
        for k in range(3):
            impulse[i, k] = x[i, k]
        push_spatial(system.contacts, i, (x[i, 0], x[i, 1], x[i, 2]), momentum)


@part
def spatial_defects(system: System, point: Point, v: Array, impulse: Array, defect: Array) -> float:
    """defect = H'u + K x - s at velocities v; the largest residual of a contact."""
    x, s, worst = point.x, point.s, 0.0
    for i in range(len(x)):
        mu, bias, shift = system.friction[i], system.friction_bias[i], system.shift[i]
        u0, u1, u2 = read_spatial(system.contacts, i, v)
        u0 += system.offset[i, 0]
        u1 += system.offset[i, 1]
        u2 += system.offset[i, 2]
        defect[i, 0] = u0 - shift * x[i, 3] - s[i, 0]
        if system.pairs[i] > 1:
            defect[i, 1] = u1 - s[i, 1]
            defect[i, 2] = u2 - s[i, 2]
            defect[i, 3] = mu * x[i, 0] + bias - s[i, 3]
        r = (impulse[i, 0], impulse[i, 1], impulse[i, 2])
        worst = larger(worst, natural(r, (u0, u1, u2), mu, bias, mu - shift, system.weight[i]))
    return worst


@inlined
def _eliminate(x: Array, s: Array, i: int, mu: float, shift: float, soft: float) -> tuple[float, ...]:
    """z softened, D, the two factors a of dlambda = .. - a . du_t - share mu dc, the share, and the inverse pivot of c."""
    z0, z1, z2 = x[i, 3] + soft * s[i, 3], s[i, 1] + soft * x[i, 1], s[i, 2] + soft * x[i, 2]
    D = s[i, 3] * z0 - x[i, 1] * z1 - x[i, 2] * z2
    a1, a2 = (z0 * x[i, 1] - s[i, 3] * z1) / D, (z0 * x[i, 2] - s[i, 3] * z2) / D
    share = (z0 * z0 - z1 * z1 - z2 * z2) / D
    return z0, z1, z2, D, a1, a2, share, 1 / (s[i, 0] / x[i, 0] + soft + shift * mu * share)


@part
def add_spatial_stiffness(system: System, point: Point, work: Work) -> None:
    """Add J'C J to the fronts, C = H B^-1 H'."""
    x, s = point.x, point.s
    for i in range(len(x)):
        mu, shift, soft = system.friction[i], system.shift[i], work.softness[0] * system.weight[i]
        if system.pairs[i] == 1:
            n, row1, row2 = (1 / (s[i, 0] / x[i, 0] + soft), 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        else:
            z0, z1, z2, _, a1, a2, share, nn = _eliminate(x, s, i, mu, shift, soft)
            y0, y1, y2 = s[i, 3], x[i, 1], x[i, 2]
            n = (nn, nn * shift * a1, nn * shift * a2)
            m1, m2, inverse = mu * (z1 - share * y1), mu * (z2 - share * y2), 1 / z0
            row1 = (-m1 * n[0] * inverse, (y0 - y1 * a1 - m1 * n[1]) * inverse, (-y1 * a2 - m1 * n[2]) * inverse)
            row2 = (-m2 * n[0] * inverse, (-y2 * a1 - m2 * n[1]) * inverse, (y0 - y2 * a2 - m2 * n[2]) * inverse)
        add_spatial(system.contacts, i, n, row1, row2, system.fronts, work.storage)


@part
def _steps(system: System, point: Point, target: Array, defect: Array, step: Point, u: Array, softness: float) -> None:
    """Fill dx = (dc, dr_t, dlambda) and ds for changes u of the contacts' velocities.

    The dlambda of a contact that sticks follows from the products: du_t carries the rounding of large impulses, while
    lambda and u_t go to zero.
    """
    x, s, dx, ds = point.x, point.s, step.x, step.s
    for i in range(len(x)):
        mu, shift, soft = system.friction[i], system.shift[i], softness * system.weight[i]
        if system.pairs[i] == 1:
            dx[i, 0] = (target[i, 0] / x[i, 0] - defect[i, 0] - u[i, 0]) / (s[i, 0] / x[i, 0] + soft)
            ds[i, 0] = (target[i, 0] - s[i, 0] * dx[i, 0]) / x[i, 0]
            continue
        z0, z1, z2, D, a1, a2, share, nn = _eliminate(x, s, i, mu, shift, soft)
        y0, y1, y2 = s[i, 3], x[i, 1], x[i, 2]
        t1, t2, t3 = target[i, 1], target[i, 2], target[i, 3]
        d1, d2 = u[i, 1] + defect[i, 1], u[i, 2] + defect[i, 2]
        slide = (z0 * t3 - z1 * t1 - z2 * t2) / D - a1 * d1 - a2 * d2 - share * defect[i, 3]
        c = nn * (target[i, 0] / x[i, 0] - defect[i, 0] - u[i, 0] + shift * slide)
        slide -= share * mu * c
        y = mu * c + defect[i, 3]
        r1 = (t1 - y0 * d1 - y1 * slide - z1 * y) / z0
        r2 = (t2 - y0 * d2 - y2 * slide - z2 * y) / z0
        # z as it is: what of the products is left for dlambda and du_t
        z0, z1, z2 = x[i, 3], s[i, 1], s[i, 2]
        t1, t2, t3 = t1 - z0 * r1 - z1 * y, t2 - z0 * r2 - z2 * y, t3 - z0 * y - z1 * r1 - z2 * r2
        det = y0 * y0 - y1 * y1 - y2 * y2
        if det > INSIDE * y0 * y0:
            slide = (y0 * t3 - y1 * t1 - y2 * t2) / det
        dx[i, 0], dx[i, 1], dx[i, 2], dx[i, 3] = c, r1, r2, slide
        ds[i, 0] = (target[i, 0] - s[i, 0] * c) / x[i, 0]
        ds[i, 1], ds[i, 2], ds[i, 3] = (t1 - y1 * slide) / y0, (t2 - y2 * slide) / y0, y


@part
def add_spatial_right_side(system: System, point: Point, target: Array, defect: Array, step: Point, work: Work) -> None:
    """Add J'H B^-1 g to work.vector."""
    for i in range(len(target)):
        for k in range(3):
            work.velocity[i, k] = 0.0
    _steps(system, point, target, defect, step, work.velocity, work.softness[0])
    for i in range(len(target)):
        push_spatial(system.contacts, i, (step.x[i, 0], step.x[i, 1], step.x[i, 2]), work.vector)


@part
def spatial_steps(system: System, point: Point, target: Array, defect: Array, step: Point, work: Work) -> None:
    """dx = B^-1 (g - H'du) and ds, du from the velocities in work.vector."""
    u = work.velocity
    for i in range(len(u)):
        u[i, 0], u[i, 1], u[i, 2] = read_spatial(system.contacts, i, work.vector)
    _steps(system, point, target, defect, step, u, work.softness[0])
