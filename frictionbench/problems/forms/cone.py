"""The projection on a contact's friction cone, K = {|r_t| <= mu r_n + b, r_n >= 0}, mu and b >= 0.

The nearest point of (n, t) has the direction of t, so that it depends on n and |t| only, in the plane and in space:
(n, t) itself inside; on the slanted side, whose normal is (-mu, 1), the foot of the perpendicular; the face r_n = 0 below.
"""

import numpy as np

from frictionbench.problems.check import Array
from frictionbench.problems.compiled import kernel, part


@part
def nearest(n: float, size: float, mu: float, b: float) -> tuple[float, float]:
    """(m, share): the nearest point of the cone to (n, t), |t| = size, is (m, share t)."""
    if not size > mu * n + b:
        return 0.0 if n < 0 else n, 1.0
    m = max((n + mu * (size - b)) / (1 + mu * mu), 0.0)
    limit = mu * m + b
    return m, limit / size if size > limit else 1.0


@kernel
def project_cone(x: Array, mu: Array, b: Array) -> Array:
    """The rows of x (nc, d) projected on the cones of mu and b (nc,)."""
    p = np.empty_like(x)
    for i in range(len(x)):
        size = 0.0
        for k in range(1, x.shape[1]):
            size = np.hypot(size, x[i, k])
        p[i, 0], share = nearest(x[i, 0], size, mu[i], b[i])
        for k in range(1, x.shape[1]):
            p[i, k] = share * x[i, k]
    return p
