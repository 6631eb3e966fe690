"""The call of Siconos by hand, in the system's Python: the Delassus matrix by numpy, and one driver. For harness.direct."""

from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from messages import Array, serve  # this folder's neighbour is on the path of the child


def answer(mass: Array, N: Array, T: Array, v: Array, b: Array, mu: Array, tol: float) -> dict[str, Any]:
    """The impulses, normal first, by the sweeps of fc2d_driver; its return code, and the seconds that a user would wait."""
    begun = perf_counter()
    J = np.stack([N, T], axis=1).reshape(2 * len(mu), len(v))
    q = J @ v
    q[0::2] += b
    W = J @ np.linalg.solve(mass, J.T)
    problem = sn.FrictionContactProblem(2, len(mu), W, q, mu)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = tol, 100_000
    r = np.zeros(len(q))
    code = sn.fc2d_driver(problem, r, q.copy(), options)
    return {"r": r, "code": int(code), "clock": perf_counter() - begun}


serve(answer)
