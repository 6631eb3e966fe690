"""The centred point of an interior point method around given impulses and velocities.

A complementary pair x, s is what is positive and what is negative of their difference: x = y_+ and s = (-y)_+ with y = x - s.
The smooth function

    phi(y) = (y + sqrt(y^2 + 4 g^2)) / 2          in place of y_+

makes x = phi(y), s = phi(-y), which still has x - s = y, and x ∘ s = g^2 in every pair: the point of the interior, at the
distance g from the boundary, that corresponds to a guess of r and u. In Lorentz' cone phi is taken of the eigenvalues of y.
References: Chen and Harker 1993; Kanzow 1996; in the cone Fukushima, Luo and Tseng 2001.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part
from frictionbench.solvers.interior.lorentz import Vector
from frictionbench.solvers.interior.point import Point, new_point
from frictionbench.solvers.interior.system import Space, System


@part
def _phi(y: float, g: float) -> float:
    """(y + sqrt(y^2 + 4 g^2)) / 2 without cancellation."""
    larger = (abs(y) + np.sqrt(y * y + 4 * g * g)) / 2
    return larger if y >= 0 else g * g / larger


@part
def _phi_in_cone(y: Vector, g: float) -> Vector:
    size = np.sqrt(y[1] * y[1] + y[2] * y[2])
    high, low = _phi(y[0] + size, g), _phi(y[0] - size, g)
    along = (high - low) / (2 * size) if size > 0 else 0.0
    return (high + low) / 2, along * y[1], along * y[2]


@kernel
def centred_point(system: System, space: Space, r: Array, u: Array, g: float) -> Point:
    """The point for impulses r and velocities u (nc, d), in the problem's units; g relative to the largest free velocity."""
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
