"""A point inside the cones of a contact problem: unknowns x, partners s, and their products x ∘ s.

A contact has four unknowns and four partners, the exact problem and its convex relaxation alike. In the plane they are the
complementary pairs of the friction LCP (problems.forms.lcp), x >= 0, s >= 0, x ∘ s = 0 number by number:

    c:       u_n - shift lambda              its normal impulse, and the speed at which it opens,
    beta+:   lambda + u_t                    its impulse along the tangent,
    beta-:   lambda - u_t                    and against it,
    lambda:  mu c - beta+ - beta- + b_f      its sliding speed, and the friction left.

In space they are one such pair and a pair of elements of Lorentz' cone, whose product is that of solvers.interior.lorentz:

    c:                 u_n - shift lambda,
    (lambda, u_t)      (mu c + b_f, r_t)     sliding speed and velocity, the friction there is and the one in use,

stored as x = (c, r_t, lambda) and s = (u_n - shift lambda, u_t, mu c + b_f), so that the sum of the numbers' products is the
same in both. The shift is 0 for Coulomb's law and mu for its relaxation (problems.forms.relaxation).

Steps are measured along geodesics: for a pair of numbers, in their logarithms.
"""

from typing import NamedTuple

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.problems.rows import Index64
from frictionbench.solvers.interior.lorentz import longest_in_cone, to_geodesic
from frictionbench.solvers.interior.system import Space, System, space_of


class Point(NamedTuple):
    """Unknowns x (nc, 4), their partners s (nc, 4), the joints' impulses (nj, 1); a step and a defect have the same shape.

    A contact without friction has its first pair alone; the others are zero, and so is all that is computed from them.
    """

    x: Array
    s: Array
    joint: Array


@part
def new_point(system: System) -> Point:
    nc, nj = len(system.friction), len(system.joint_bias)
    return Point(np.zeros((nc, 4)), np.zeros((nc, 4)), np.zeros((nj, 1)))


def start_point(system: System, impulse: float, speed: float) -> Point:
    """Impulses of `impulse` times what stops a unit velocity at their contact, and `speed`; nothing tangential in space."""
    x, s = start_pairs(system.weight, system.pairs, space_of(system), impulse, speed)
    return Point(x, s, np.zeros((len(system.joint_bias), 1)))


@kernel
def start_pairs(weight: Array, pairs: Index64, space: Space, impulse: float, speed: float) -> tuple[Array, Array]:
    """The x and s of start_point."""
    x, s = np.zeros((len(weight), 4)), np.zeros((len(weight), 4))
    for i in range(len(x)):
        own = impulse / weight[i]
        x[i, 0], s[i, 0] = own, speed
        if pairs[i] > 1:
            x[i, 3], s[i, 3] = speed, own
            if space is None:
                x[i, 1] = x[i, 2] = own
                s[i, 1] = s[i, 2] = speed
    return x, s


@kernel
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


@kernel
def set_identity(space: Space, factor: float, total: Array) -> None:
    """total = factor times the identity of ∘."""
    for i in range(len(total)):
        for k in range(4):
            total[i, k] = factor if space is None or k in (0, 3) else 0.0


@part
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


@part
def _longest(value: float, step: float, limit: float) -> float:
    return -value / step if value + limit * step < 0 else limit


@part
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


@kernel
def set_step(to: Point, factor: float, step: Point) -> None:
    """to = factor step."""
    for i in range(len(to.x)):
        for k in range(4):
            to.x[i, k] = factor * step.x[i, k]
            to.s[i, k] = factor * step.s[i, k]
    for j in range(len(to.joint)):
        to.joint[j, 0] = factor * step.joint[j, 0]


@part
def add_step(to: Point, factor: float, step: Point) -> None:
    """to += factor step."""
    for i in range(len(to.x)):
        for k in range(4):
            to.x[i, k] += factor * step.x[i, k]
            to.s[i, k] += factor * step.s[i, k]
    for j in range(len(to.joint)):
        to.joint[j, 0] += factor * step.joint[j, 0]
