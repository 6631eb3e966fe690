"""ContactBench's .npz (Le Lidec and others 2024): G (3 nc, 3 nc) and g (3 nc, 1) in u = G r + g, mus (nc).

Its contacts have the normal last, (t1, t2, n). G includes a compliance of 1e-9 I, which is part of the problem.
"""

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem


def problem(arrays: dict[str, Array]) -> FrictionProblem:
    """The problem with the normal first. Errors: InputError naming the field."""
    G, g, mu = arrays["G"], arrays["g"].ravel(), arrays["mus"]
    n = 3 * mu.size
    require(G.shape == (n, n), "G", f"expected shape {(n, n)} for {mu.size} friction coefficients, got {G.shape}")
    require(len(g) == n, "g", f"expected length {n}, got {len(g)}")
    order = (3 * np.arange(mu.size)[:, None] + np.array([2, 0, 1])).ravel()
    return FrictionProblem.from_delassus(G[np.ix_(order, order)], g[order], mu.ravel(), 3)
