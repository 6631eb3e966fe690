"""The projection onto a contact's friction cone, K = {|r_t| <= mu r_n + b, r_n >= 0}, mu and b >= 0.

The nearest point to (n, t) has the direction of t, so that it depends only on n and |t|, in the plane and in space. Inside K it
is (n, t) itself, otherwise the foot of the perpendicular on the slanted side with normal (-mu, 1), or on the face r_n = 0.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part


@part
def nearest(n: float, size: float, mu: float, b: float) -> tuple[float, float]:
    """(m, share), for which (m, share t) is the nearest point of the cone to (n, t) with |t| = size."""
    if not size > mu * n + b:
        return 0.0 if n < 0 else n, 1.0
    m = max((n + mu * (size - b)) / (1 + mu * mu), 0.0)
    limit = mu * m + b
    return m, limit / size if size > limit else 1.0


@kernel
def project_cone(x: Array, mu: Array, b: Array) -> Array:
    """The rows of x (nc, d), projected onto the cones with mu and b (nc,)."""
    p = np.empty_like(x)
    for i in range(len(x)):
        size = 0.0
        for k in range(1, x.shape[1]):
            size = np.hypot(size, x[i, k])
        p[i, 0], share = nearest(x[i, 0], size, mu[i], b[i])
        for k in range(1, x.shape[1]):
            p[i, k] = share * x[i, k]
    return p
