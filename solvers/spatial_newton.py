"""Newton's equations of spatial contacts with the circular cone (solvers.contact_point).

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
"""

from numba import njit

from problems.check import Array
from solvers.contact_elements import Vector, add_spatial, feel_spatial, natural, push_spatial
from solvers.contact_point import Point
from solvers.contact_system import SOFTNESS, System, Work

INSIDE = 0.1  # det y / y_0^2 from which a contact clearly sticks


@njit(cache=True, error_model="numpy")
def push_spatial_impulses(system: System, x: Array, impulse: Array, momentum: Array) -> None:
    """The impulses r = H x, and momentum += J'r."""
    for i in range(len(x)):
        for k in range(3):
            impulse[i, k] = x[i, k]
        push_spatial(system.contacts, i, (x[i, 0], x[i, 1], x[i, 2]), momentum)


@njit(cache=True, error_model="numpy")
def spatial_defects(system: System, point: Point, v: Array, impulse: Array, defect: Array) -> float:
    """defect = H'u + K x - s at velocities v; the largest residual of a contact."""
    x, s, worst = point.x, point.s, 0.0
    for i in range(len(x)):
        mu, bias, shift = system.friction[i], system.friction_bias[i], system.shift[i]
        u0, u1, u2 = feel_spatial(system.contacts, i, v)
        u0 += system.offset[i, 0]
        u1 += system.offset[i, 1]
        u2 += system.offset[i, 2]
        defect[i, 0] = u0 - shift * x[i, 3] - s[i, 0]
        if system.pairs[i] > 1:
            defect[i, 1] = u1 - s[i, 1]
            defect[i, 2] = u2 - s[i, 2]
            defect[i, 3] = mu * x[i, 0] + bias - s[i, 3]
        r = (impulse[i, 0], impulse[i, 1], impulse[i, 2])
        worst = max(worst, natural(r, (u0, u1, u2), mu, bias, mu - shift, system.weight[i]))
    return worst


@njit(cache=True, error_model="numpy")
def _eliminate(x: Array, s: Array, mu: float, shift: float, soft: float) -> tuple[Vector, float, float, float, float, float]:
    """z softened, D, the two factors a of dlambda = .. - a . du_t - share mu dc, the share, and the inverse pivot of c."""
    z0, z1, z2 = x[3] + soft * s[3], s[1] + soft * x[1], s[2] + soft * x[2]
    D = s[3] * z0 - x[1] * z1 - x[2] * z2
    share = (z0 * z0 - z1 * z1 - z2 * z2) / D
    nn = 1 / (s[0] / x[0] + soft + shift * mu * share)
    return (z0, z1, z2), D, (z0 * x[1] - s[3] * z1) / D, (z0 * x[2] - s[3] * z2) / D, share, nn


@njit(cache=True, error_model="numpy")
def add_spatial_stiffness(system: System, point: Point, work: Work) -> None:
    """Add J'C J to the fronts, C = H B^-1 H'."""
    for i in range(len(point.x)):
        x, s, mu, shift = point.x[i], point.s[i], system.friction[i], system.shift[i]
        soft, none = SOFTNESS * system.weight[i], (0.0, 0.0, 0.0)
        if system.pairs[i] == 1:
            nn = 1 / (s[0] / x[0] + soft)
            add_spatial(system.contacts, i, (nn, 0.0, 0.0), none, none, system.fronts, work.storage)
            continue
        (z0, z1, z2), _, a1, a2, share, nn = _eliminate(x, s, mu, shift, soft)
        y0, y1, y2 = s[3], x[1], x[2]
        n = (nn, nn * shift * a1, nn * shift * a2)
        m1, m2 = mu * (z1 - share * y1), mu * (z2 - share * y2)
        row1 = (-m1 * n[0] / z0, (y0 - y1 * a1 - m1 * n[1]) / z0, (-y1 * a2 - m1 * n[2]) / z0)
        row2 = (-m2 * n[0] / z0, (-y2 * a1 - m2 * n[1]) / z0, (y0 - y2 * a2 - m2 * n[2]) / z0)
        add_spatial(system.contacts, i, n, row1, row2, system.fronts, work.storage)


@njit(cache=True, error_model="numpy")
def _step(x: Array, s: Array, laws: Vector, target: Array, defect: Array, u: Vector, dx: Array, ds: Array) -> None:
    """Fill dx = (dc, dr_t, dlambda) and ds of one contact with friction, for a change u of its velocity.

    The dlambda of a contact that sticks follows from the products: du_t carries the rounding of large impulses, while
    lambda and u_t go to zero.
    """
    mu, shift, soft = laws
    (z0, z1, z2), D, a1, a2, share, nn = _eliminate(x, s, mu, shift, soft)
    y0, y1, y2 = s[3], x[1], x[2]
    t1, t2 = target[1], target[2]
    d1, d2 = u[1] + defect[1], u[2] + defect[2]
    slide = (z0 * target[3] - z1 * t1 - z2 * t2) / D - a1 * d1 - a2 * d2 - share * defect[3]
    c = nn * (target[0] / x[0] - defect[0] - u[0] + shift * slide)
    slide -= share * mu * c
    y = mu * c + defect[3]
    r1 = (t1 - y0 * d1 - y1 * slide - z1 * y) / z0
    r2 = (t2 - y0 * d2 - y2 * slide - z2 * y) / z0
    t1 -= x[3] * r1 + s[1] * y
    t2 -= x[3] * r2 + s[2] * y
    det = y0 * y0 - y1 * y1 - y2 * y2
    if det > INSIDE * y0 * y0:
        slide = (y0 * (target[3] - x[3] * y - s[1] * r1 - s[2] * r2) - y1 * t1 - y2 * t2) / det
    dx[0], dx[1], dx[2], dx[3] = c, r1, r2, slide
    ds[0] = (target[0] - s[0] * c) / x[0]
    ds[1], ds[2], ds[3] = (t1 - y1 * slide) / y0, (t2 - y2 * slide) / y0, y


@njit(cache=True, error_model="numpy")
def _spatial_step(system: System, i: int, point: Point, target: Array, defect: Array, u: Vector, step: Point) -> None:
    x, s, dx, ds = point.x[i], point.s[i], step.x[i], step.s[i]
    soft = SOFTNESS * system.weight[i]
    if system.pairs[i] == 1:
        dx[0] = (target[i, 0] / x[0] - defect[i, 0] - u[0]) / (s[0] / x[0] + soft)
        ds[0] = (target[i, 0] - s[0] * dx[0]) / x[0]
    else:
        _step(x, s, (system.friction[i], system.shift[i], soft), target[i], defect[i], u, dx, ds)


@njit(cache=True, error_model="numpy")
def push_spatial_response(system: System, point: Point, target: Array, defect: Array, step: Point, work: Work) -> None:
    """Add J'H B^-1 g to work.vector."""
    for i in range(len(target)):
        _spatial_step(system, i, point, target, defect, (0.0, 0.0, 0.0), step)
        push_spatial(system.contacts, i, (step.x[i, 0], step.x[i, 1], step.x[i, 2]), work.vector)


@njit(cache=True, error_model="numpy")
def spatial_steps(system: System, point: Point, target: Array, defect: Array, step: Point, work: Work) -> None:
    """dx = B^-1 (g - H'du) and ds, du from the velocities in work.vector."""
    for i in range(len(target)):
        _spatial_step(system, i, point, target, defect, feel_spatial(system.contacts, i, work.vector), step)
