"""A point inside the cones of a contact problem: unknowns x, partners s, and their products x ∘ s.

A contact has four unknowns and four partners, in the exact problem and in its convex relaxation. In the plane they are the
complementary pairs of the friction LCP (problems.forms.lcp), x >= 0, s >= 0, x ∘ s = 0 component by component:

    c:       u_n - shift lambda              its normal impulse, and the speed at which it opens,
    beta+:   lambda + u_t                    its impulse along the tangent,
    beta-:   lambda - u_t                    and against it,
    lambda:  mu c - beta+ - beta- + b_f      its sliding speed, and the unused friction.

In space they are one such pair and a pair of elements of Lorentz' cone, {a: a_0 >= |a_t|} with two components in a_t, the
positive elements of a Jordan algebra (Faraut and Korányi 1994):

    c:                 u_n - shift lambda,
    (lambda, u_t)      (mu c + b_f, r_t)     sliding speed and velocity, the friction limit and the friction impulse,

    a ∘ b = (a_0 b_0 + a_t . b_t,  a_0 b_t + b_0 a_t),      identity (1, 0),      det a = a_0^2 - |a_t|^2,

stored as x = (c, r_t, lambda) and s = (u_n - shift lambda, u_t, mu c + b_f), so that the complementarity gap is the sum of all
x_k s_k in both. The shift is 0 for Coulomb's law and mu for its relaxation (problems.forms.relaxation).

Steps are measured along geodesics: for a pair of numbers, in their logarithms. Every a has the eigenvalues a_0 ± |a_t|, and
functions of a act on its eigenvalues. At a point a inside the cone the geodesic a -> Q(sqrt a) exp(w) leaves along
Q(sqrt a) w, with Q(a) b = 2 (a . b) a - det(a) (b_0, -b_t). For a number, Q(sqrt a) w = a w.

A guess of impulses and velocities is turned into a point by smoothing. A complementary pair consists of the positive and the
negative part of its difference y = x - s, that is x = y_+ and s = (-y)_+. The smooth function

    phi(y) = (y + sqrt(y^2 + 4 g^2)) / 2          in place of y_+

makes x = phi(y), s = phi(-y), which still has x - s = y, and x ∘ s = g^2 in every pair: the *centred point*, at the distance g
from the boundary. (Chen and Harker 1993; Kanzow 1996; in the cone Fukushima, Luo and Tseng 2001.)
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, lean, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.interior.system import Space, System, space_of

LEAST_EIGENVALUE = 1e-15  # lower bound of the eigenvalues, relative to a_0: a few units of rounding

Vector = tuple[float, float, float]


class Point(NamedTuple):
    """Unknowns x (nc, 4), their partners s (nc, 4), the joints' impulses (nj, 1); a step and a defect have the same shape.

    A contact without friction has only its first pair; the other entries are zero, and so is all that is computed from them.
    """

    x: Array
    s: Array
    joint: Array


@part
def new_point(system: System) -> Point:
    nc, nj = len(system.friction), len(system.joint_bias)
    return Point(np.zeros((nc, 4)), np.zeros((nc, 4)), np.zeros((nj, 1)))


def start_point(system: System, impulse: float, speed: float) -> Point:
    """Impulses `impulse` times those that stop a unit velocity, and velocities `speed`; in space, tangential ones are zero."""
    x, s = start_pairs(system.weight, system.pairs, space_of(system), impulse, speed)
    return Point(x, s, np.zeros((len(system.joint_bias), 1)))


@kernel
def start_pairs(weight: Array, pairs: Index64, space: Space, impulse: float, speed: float) -> tuple[Array, Array]:
    """The x and s of start_point."""
    x, s = np.zeros((len(weight), 4)), np.zeros((len(weight), 4))
    for i in range(len(x)):
        scaled = impulse / weight[i]
        x[i, 0], s[i, 0] = scaled, speed
        if pairs[i] > 1:
            x[i, 3], s[i, 3] = speed, scaled
            if space is None:
                x[i, 1] = x[i, 2] = scaled
                s[i, 1] = s[i, 2] = speed
    return x, s


@lean
def add_products(space: Space, factor: float, x: Array, s: Array, total: Array) -> None:
    """total += factor x ∘ s."""
    if space is None:
        for i in range(len(x)):
            for k in range(4):
                total[i, k] += factor * x[i, k] * s[i, k]
        return
    for i in range(len(x)):
        total[i, 0] += factor * x[i, 0] * s[i, 0]
        total[i, 3] += factor * (x[i, 3] * s[i, 3] + x[i, 1] * s[i, 1] + x[i, 2] * s[i, 2])
        for k in (1, 2):
            total[i, k] += factor * (x[i, 3] * x[i, k] + s[i, 3] * s[i, k])


@lean
def set_identity(space: Space, factor: float, total: Array) -> None:
    """total = factor times the identity of ∘."""
    for i in range(len(total)):
        for k in range(4):
            total[i, k] = factor if space is None or k in (0, 3) else 0.0


@lean
def longest(system: System, space: Space, point: Point, step: Point, limit: float) -> float:
    """How far along the step x and s stay inside their cones, at most limit."""
    x, s, dx, ds, length = point.x, point.s, step.x, step.s, limit
    if space is None:
        for i in range(len(x)):
            for k in range(4):
                length = _longest(x[i, k], dx[i, k], length)
                length = _longest(s[i, k], ds[i, k], length)
        return length
    for i in range(len(x)):
        length = _longest(x[i, 0], dx[i, 0], length)
        length = _longest(s[i, 0], ds[i, 0], length)
        if system.pairs[i] > 1:
            length = longest_in_cone((x[i, 3], s[i, 1], s[i, 2]), (dx[i, 3], ds[i, 1], ds[i, 2]), length)
            length = longest_in_cone((s[i, 3], x[i, 1], x[i, 2]), (ds[i, 3], dx[i, 1], dx[i, 2]), length)
    return length


@lean
def _longest(value: float, step: float, limit: float) -> float:
    return -value / step if value + limit * step < 0 else limit


@lean
def to_geodesics(system: System, space: Space, point: Point, step: Point) -> None:
    """Overwrite a step's x and s with the geodesics that leave the point along it."""
    x, s, dx, ds = point.x, point.s, step.x, step.s
    for i in range(len(x)):
        for k in range(system.pairs[i] if space is None else 1):
            dx[i, k] /= x[i, k]
            ds[i, k] /= s[i, k]
        if space is not None and system.pairs[i] > 1:
            dx[i, 3], ds[i, 1], ds[i, 2] = to_geodesic((x[i, 3], s[i, 1], s[i, 2]), (dx[i, 3], ds[i, 1], ds[i, 2]))
            ds[i, 3], dx[i, 1], dx[i, 2] = to_geodesic((s[i, 3], x[i, 1], x[i, 2]), (ds[i, 3], dx[i, 1], dx[i, 2]))


@lean
def set_step(to: Point, factor: float, step: Point) -> None:
    """to = factor step."""
    for i in range(len(to.x)):
        for k in range(4):
            to.x[i, k] = factor * step.x[i, k]
            to.s[i, k] = factor * step.s[i, k]
    for j in range(len(to.joint)):
        to.joint[j, 0] = factor * step.joint[j, 0]


@lean
def add_step(to: Point, factor: float, step: Point) -> None:
    """to += factor step."""
    for i in range(len(to.x)):
        for k in range(4):
            to.x[i, k] += factor * step.x[i, k]
            to.s[i, k] += factor * step.s[i, k]
    for j in range(len(to.joint)):
        to.joint[j, 0] += factor * step.joint[j, 0]


@lean
def longest_in_cone(a: Vector, step: Vector, limit: float) -> float:
    """The largest length <= limit with a + length step in the cone, for a in the cone up to rounding."""
    size = np.sqrt(a[1] * a[1] + a[2] * a[2])
    det = max(a[0] - size, LEAST_EIGENVALUE * a[0]) * (a[0] + size)
    half = a[0] * step[0] - a[1] * step[1] - a[2] * step[2]
    square = step[0] * step[0] - step[1] * step[1] - step[2] * step[2]
    length = limit
    if a[0] + length * step[0] < 0:
        length = -a[0] / step[0]
    inner = half * half - square * det
    if inner >= 0:  # the smallest positive root of det(a + t step) = det + 2 half t + square t^2, without cancellation
        root = np.sqrt(inner)
        if half <= 0 and det < length * (root - half):
            length = det / (root - half)
        elif half > 0 and half + root < -length * square:
            length = -(half + root) / square
    return length


@lean
def _quadratic(a: Vector, b: Vector) -> Vector:
    """Q(a) b."""
    twice = 2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    det = a[0] * a[0] - a[1] * a[1] - a[2] * a[2]
    return twice * a[0] - det * b[0], twice * a[1] + det * b[1], twice * a[2] + det * b[2]


@lean
def _inverse_root(a: Vector) -> Vector:
    """a^(-1/2)."""
    size = np.sqrt(a[1] * a[1] + a[2] * a[2])
    high = (a[0] + size) ** -0.5
    low = max(a[0] - size, LEAST_EIGENVALUE * a[0]) ** -0.5
    along = (high - low) / (2 * size) if size > 0 else 0.0
    return (high + low) / 2, along * a[1], along * a[2]


@lean
def to_geodesic(a: Vector, step: Vector) -> Vector:
    """w with step = Q(sqrt a) w."""
    return _quadratic(_inverse_root(a), step)


@lean
def _phi(y: float, g: float) -> float:
    """(y + sqrt(y^2 + 4 g^2)) / 2 without cancellation."""
    larger = (abs(y) + np.sqrt(y * y + 4 * g * g)) / 2
    return larger if y >= 0 else g * g / larger


@lean
def _phi_in_cone(y: Vector, g: float) -> Vector:
    size = np.sqrt(y[1] * y[1] + y[2] * y[2])
    high, low = _phi(y[0] + size, g), _phi(y[0] - size, g)
    along = (high - low) / (2 * size) if size > 0 else 0.0
    return (high + low) / 2, along * y[1], along * y[2]


@kernel
def centred_point(system: System, space: Space, r: Array, u: Array, g: float) -> Point:
    """The centred point of impulses r and velocities u (nc, d) in the problem's units; g is relative to system.speed."""
    point = new_point(system)
    x, s = point.x, point.s
    for i in range(len(x)):
        mu, weight = system.friction[i], system.weight[i]
        c, un = weight * r[i, 0] / system.impulse, u[i, 0] / system.speed
        x[i, 0], s[i, 0] = _phi(c - un, g) / weight, _phi(un - c, g)
        if system.pairs[i] == 1:
            continue
        limit = max(mu * c, 0.0) + weight * system.friction_bias[i]
        if space is None:
            t, ut = weight * r[i, 1] / system.impulse, u[i, 1] / system.speed
            slide = abs(ut)
            plus, minus, left = max(t, 0.0), max(-t, 0.0), limit - abs(t)
            x[i, 1], s[i, 1] = _phi(plus - slide - ut, g) / weight, _phi(slide + ut - plus, g)
            x[i, 2], s[i, 2] = _phi(minus - slide + ut, g) / weight, _phi(slide - ut - minus, g)
            x[i, 3], s[i, 3] = _phi(slide - left, g), _phi(left - slide, g) / weight
        else:
            t1, t2 = weight * r[i, 1] / system.impulse, weight * r[i, 2] / system.impulse
            u1, u2 = u[i, 1] / system.speed, u[i, 2] / system.speed
            y0 = limit - np.sqrt(u1 * u1 + u2 * u2)
            a = _phi_in_cone((y0, t1 - u1, t2 - u2), g)
            b = _phi_in_cone((-y0, u1 - t1, u2 - t2), g)
            s[i, 3], x[i, 1], x[i, 2] = a[0] / weight, a[1] / weight, a[2] / weight
            x[i, 3], s[i, 1], s[i, 2] = b
    return point
