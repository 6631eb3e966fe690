"""ContactBench's .npz (Le Lidec and others 2024): G (3 nc, 3 nc) and g (3 nc, 1) in u = G r + g, mus (nc).

Its contacts have the normal last, (t1, t2, n). G includes a compliance of 1e-9 I, which is part of the problem.
"""

import numpy as np

from frictionbench.problems import sizes
from frictionbench.problems.check import Array, require
from frictionbench.problems.friction import FrictionProblem
from frictionbench.problems.recorded.names import in_letters, require_known

LETTERS = {"W": "G", "q": "g", "friction": "mus", "dimension": "d"}


def problem(arrays: dict[str, Array]) -> FrictionProblem:
    """The problem with the normal first. Errors: InputError naming the field."""
    require_known(arrays, ("G", "g", "mus", "lam0"))
    G, g, mu = arrays["G"], arrays["g"].ravel(), arrays["mus"].ravel()
    require(G.ndim == 2, "G", f"expected a matrix, got shape {G.shape}")
    sizes.agree(3, {"W": G, "q": g, "friction": mu}, LETTERS)
    order = (3 * np.arange(mu.size)[:, None] + np.array([2, 0, 1])).ravel()
    with in_letters(LETTERS):
        return FrictionProblem.from_delassus(G[np.ix_(order, order)], g[order], mu, 3)
