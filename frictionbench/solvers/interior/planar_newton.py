"""Newton's equations of planar contacts, whose unknowns are those of the friction LCP (solvers.interior.point).

    (diag(s/x) + K) dx = g - H'du,      H'du = (du_n, du_t, -du_t, 0),      g = target/x - defect,

and K for the parts in which a contact's own unknowns act on its s. c is eliminated first, then beta+ and beta-, lambda last:
every pivot is a sum of positive numbers.
"""

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import part
from frictionbench.solvers.interior.elements import add_planar, larger, natural, push_planar, read_planar
from frictionbench.solvers.interior.point import Point
from frictionbench.solvers.interior.system import System, Work


@part
def push_planar_impulses(system: System, x: Array, impulse: Array, momentum: Array) -> None:
    """The impulses r = H x, and momentum += J'r."""
    for i in range(len(x)):
        impulse[i, 0] = x[i, 0]
        impulse[i, 1] = x[i, 1] - x[i, 2]
        push_planar(system.contacts, i, impulse[i, 0], impulse[i, 1], momentum)


@part
def planar_defects(system: System, point: Point, v: Array, impulse: Array, defect: Array) -> float:
    """defect = H'u + K x - s at velocities v; the largest residual of a contact."""
    x, s, worst = point.x, point.s, 0.0
    for i in range(len(x)):
        mu, bias, shift = system.friction[i], system.friction_bias[i], system.shift[i]
        un, ut = read_planar(system.contacts, i, v)
        un += system.offset[i, 0]
        ut += system.offset[i, 1]
        defect[i, 0] = un - shift * x[i, 3] - s[i, 0]
        if system.pairs[i] > 1:
            defect[i, 1] = x[i, 3] + ut - s[i, 1]
            defect[i, 2] = x[i, 3] - ut - s[i, 2]
            defect[i, 3] = mu * x[i, 0] - x[i, 1] - x[i, 2] + bias - s[i, 3]
        r = (impulse[i, 0], impulse[i, 1], 0.0)
        worst = larger(worst, natural(r, (un, ut, 0.0), mu, bias, mu - shift, system.weight[i]))
    return worst


@part
def add_planar_stiffness(system: System, point: Point, work: Work) -> None:
    """Add J'C J to the fronts, C = H B^-1 H', and keep the inverses of x and of the pivots."""
    x, s, inverse, pivot = point.x, point.s, work.inverse, work.pivot
    for i in range(len(x)):
        soft = work.softness[0] * system.weight[i]
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
            own = s[i, 3] * inverse[i, 3] + work.softness[0] / system.weight[i]
            pivot[i, 3] = 1 / (own + total + mu * shift * nn)
            nt = shift * skew * pivot[i, 3] * nn
            tn = mu * skew * pivot[i, 3] * nn
            tt = total - skew * skew * pivot[i, 3]
            nn -= mu * shift * nn * nn * pivot[i, 3]
        add_planar(system.contacts, i, nn, nt, tn, tt, system.fronts, work.storage)


@part
def _unknowns(pivot: Array, mu: float, shift: float, g: Array, un: float, ut: float) -> tuple[float, float, float, float]:
    """B^-1 (g - H'u) of one contact."""
    c = pivot[0] * (g[0] - un)
    plus, minus = pivot[1] * (g[1] - ut), pivot[2] * (g[2] + ut)
    slide = pivot[3] * (g[3] + plus + minus - mu * c)
    return c + pivot[0] * shift * slide, plus - pivot[1] * slide, minus - pivot[2] * slide, slide


@part
def add_planar_right_side(system: System, target: Array, defect: Array, work: Work) -> None:
    """Add J'H B^-1 g to work.vector, and keep g."""
    g, inverse = work.right, work.inverse
    for i in range(len(g)):
        for k in range(4):
            g[i, k] = target[i, k] * inverse[i, k] - defect[i, k]
        c, plus, minus, _ = _unknowns(work.pivot[i], system.friction[i], system.shift[i], g[i], 0.0, 0.0)
        push_planar(system.contacts, i, c, plus - minus, work.vector)


@part
def planar_steps(system: System, point: Point, target: Array, step: Point, work: Work) -> None:
    """dx = B^-1 (g - H'du) and ds, du from the velocities in work.vector."""
    s, g, inverse = point.s, work.right, work.inverse
    for i in range(len(s)):
        un, ut = read_planar(system.contacts, i, work.vector)
        dx = step.x[i]
        dx[0], dx[1], dx[2], dx[3] = _unknowns(work.pivot[i], system.friction[i], system.shift[i], g[i], un, ut)
        for k in range(4):
            step.s[i, k] = (target[i, k] - s[i, k] * dx[k]) * inverse[i, k]
