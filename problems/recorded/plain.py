"""Dense arrays under the field's letters, as np.savez("problem.npz", W=W, q=q, mu=mu, d=3) writes them:

    W (nc*d, nc*d), q (nc*d), mu (nc), d                        known by the Delassus matrix; normal first
    M (nv, nv), N (nc, nv), T (nc*(d-1), nv), mu (nc), v (nv)   mass, normals and tangents in rows, free velocity (also vfree);
        with b (nc), fb (nc), F (nj, nv), bF (nj), d            biases and joints, none if left out; d = 2 if left out
    M (n, n), q (n)                                             an LCP, w = M z + q

mu may be one number for all contacts. N and T may also have the contacts in columns. Of a file with both M and W, M is used.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from frictionbench.problems.check import Array, require
from frictionbench.problems.forms.lcp import LCP
from frictionbench.problems.friction import FrictionProblem

Arrays = dict[str, Array]


def kind(arrays: Arrays) -> Callable[[Arrays], FrictionProblem | LCP] | None:
    """The function that reads these arrays, None where they are of none of these kinds."""
    if {"M", "N", "T", "mu"} <= arrays.keys():
        return mechanical
    if {"W", "q", "mu", "d"} <= arrays.keys():
        return known_by_delassus
    return lcp if {"M", "q"} <= arrays.keys() else None


def mechanical(arrays: Arrays) -> FrictionProblem:
    """A problem given by its mechanics. Errors: InputError naming the field."""
    M, N, T, d = arrays["M"], arrays["N"], arrays["T"], _dimension(arrays)
    require(N.ndim == T.ndim == M.ndim == 2, "M, N, T", "expected matrices")
    if N.shape[1] != len(M) == N.shape[0]:
        N, T = N.T, T.T
    nc = len(N)
    require("v" in arrays or "vfree" in arrays, "v", "missing")
    F = arrays.get("F", np.zeros((0, len(M))))
    return FrictionProblem(
        mass=M,
        normal=N,
        tangent=T,
        friction=np.broadcast_to(arrays["mu"], nc) if arrays["mu"].ndim == 0 else arrays["mu"],
        free_velocity=arrays["v" if "v" in arrays else "vfree"],
        bias=arrays.get("b", np.zeros(nc)),
        friction_bias=arrays.get("fb", np.zeros(nc)),
        joints=F,
        joint_bias=arrays.get("bF", np.zeros(len(F))),
        dimension=d,
    )


def known_by_delassus(arrays: Arrays) -> FrictionProblem:
    """A problem in Delassus form. Errors: InputError naming the field."""
    d, q, mu = _dimension(arrays), arrays["q"], arrays["mu"]
    return FrictionProblem.from_delassus(arrays["W"], q, np.full(q.size // d, mu) if mu.ndim == 0 else mu, d)


def lcp(arrays: Arrays) -> LCP:
    """A bare LCP. Errors: InputError naming the field."""
    return LCP(arrays["M"], arrays["q"])


def _dimension(arrays: dict[str, Any]) -> int:
    d = arrays.get("d", np.array(2))
    require(d.size == 1 and d.ravel()[0] in (2, 3), "d", f"must be 2 or 3, got {d}")
    return int(d.ravel()[0])
