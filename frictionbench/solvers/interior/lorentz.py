"""The cone of Lorentz, {a: a_0 >= |a_t|} with two components in a_t, as the positive elements of a Jordan algebra.

    a ∘ b = (a_0 b_0 + a_t . b_t,  a_0 b_t + b_0 a_t),      identity (1, 0),      det a = a_0^2 - |a_t|^2.

Every a has the eigenvalues a_0 ± |a_t|, and functions of a are those of its eigenvalues. At a point a of the interior the
direction whose geodesic leaves along b is w with b = Q(sqrt a) w, and the geodesic a -> Q(sqrt a) exp(w), where

    Q(a) b = 2 (a . b) a - det(a) (b_0, -b_t).

For a number, Q(sqrt a) w = a w: a step relative to a, and the geodesic goes along its logarithm. (Faraut and Korányi 1994.)
"""

import numpy as np

from frictionbench.problems.compiled import kernel, part

ROUNDING = 1e-15  # the smallest eigenvalue that differs from zero, relative to a_0: a few units of rounding

Vector = tuple[float, float, float]


@kernel
def longest_in_cone(a: Vector, step: Vector, limit: float) -> float:
    """The largest length <= limit with a + length step in the cone, for a in it up to rounding."""
    size = np.sqrt(a[1] * a[1] + a[2] * a[2])
    det = max(a[0] - size, ROUNDING * a[0]) * (a[0] + size)
    half = a[0] * step[0] - a[1] * step[1] - a[2] * step[2]
    square = step[0] * step[0] - step[1] * step[1] - step[2] * step[2]
    length = limit
    if a[0] + length * step[0] < 0:
        length = -a[0] / step[0]
    inner = half * half - square * det
    if inner >= 0:  # det(a + t step) = det + 2 half t + square t^2 has zeros; its first above 0, without cancellation
        root = np.sqrt(inner)
        if half <= 0 and det < length * (root - half):
            length = det / (root - half)
        elif half > 0 and half + root < -length * square:
            length = -(half + root) / square
    return length


@part
def _quadratic(a: Vector, b: Vector) -> Vector:
    """Q(a) b."""
    twice = 2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
    det = a[0] * a[0] - a[1] * a[1] - a[2] * a[2]
    return twice * a[0] - det * b[0], twice * a[1] + det * b[1], twice * a[2] + det * b[2]


@part
def _inverse_root(a: Vector) -> Vector:
    """a^(-1/2)."""
    size = np.sqrt(a[1] * a[1] + a[2] * a[2])
    high = (a[0] + size) ** -0.5
    low = max(a[0] - size, ROUNDING * a[0]) ** -0.5
    along = (high - low) / (2 * size) if size > 0 else 0.0
    return (high + low) / 2, along * a[1], along * a[2]


@part
def to_geodesic(a: Vector, step: Vector) -> Vector:
    """w with step = Q(sqrt a) w."""
    return _quadratic(_inverse_root(a), step)
