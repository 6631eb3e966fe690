"""The call of Siconos by hand, in the system's Python: the Delassus matrix by numpy, and one driver.

The arrays are read from standard input as JSON; the answer is the line of the output that is an object, as Siconos prints too.
"""

import json
import sys
from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn


def answer(M: Any, N: Any, T: Any, v: Any, b: Any, mu: Any, tol: float) -> dict[str, Any]:
    """The impulses, normal first, by the sweeps of fc2d_driver; its return code, and the seconds that a user would wait."""
    begun = perf_counter()
    J = np.stack([N, T], axis=1).reshape(2 * len(mu), len(v))
    q = J @ v
    q[0::2] += b
    W = J @ np.linalg.solve(M, J.T)
    problem = sn.FrictionContactProblem(2, len(mu), W, q, mu)
    options = sn.SolverOptions(sn.SICONOS_FRICTION_2D_NSGS)
    options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = tol, 100_000
    r = np.zeros(len(q))
    code = sn.fc2d_driver(problem, r, q.copy(), options)
    return {"r": r.tolist(), "code": int(code), "clock": perf_counter() - begun}


given = json.load(sys.stdin)
tol = given.pop("tol")
print(json.dumps(answer(**{name: np.array(values) for name, values in given.items()}, tol=tol)))
