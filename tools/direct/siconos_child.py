"""The call of Siconos by hand, in the system's Python: a driver for a given W, dense and sparse; the faster one's time counts.

W's entries (row, column, value), q, mu and the driver are read as JSON from standard input. The answer is the line of the
output that is an object, since Siconos prints as well.
"""

import json
import sys
from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn


def answer(entries: Any, q: Any, mu: Any, tol: float, method: str) -> dict[str, Any]:
    """Return the impulses, normal first, the driver's return code and its seconds."""
    n, d = len(q), 2 if "2D" in method else 3
    dense, sparse = np.zeros((n, n)), sn.NM_create(sn.NM_SPARSE, n, n)
    sn.NM_triplet_alloc(sparse, len(entries) + n)
    for i, j, value in entries:
        dense[int(i), int(j)] = value
        sn.NM_entry(sparse, int(i), int(j), value)
    for i in np.flatnonzero(np.diag(dense) == 0).tolist():  # without these entries PROX crashes
        sn.NM_entry(sparse, i, i, 0.0)
    found: list[dict[str, Any]] = []
    for W in (dense, sparse) if d == 3 else (dense,):
        for _ in range(3):
            options = sn.SolverOptions(getattr(sn, f"SICONOS_{method}"))
            options.dparam[sn.SICONOS_DPARAM_TOL], options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = tol, 100_000
            r, u = np.zeros(n), np.array(q)
            begun = perf_counter()
            problem = sn.FrictionContactProblem(d, len(mu), W, np.array(q), np.array(mu))
            code = (sn.fc2d_driver if d == 2 else sn.fc3d_driver)(problem, r, u, options)
            found.append({"clock": perf_counter() - begun, "code": int(code), "r": r.tolist()})
    return min(found, key=lambda each: (bool(each["code"]), each["clock"]))


print(json.dumps(answer(**json.load(sys.stdin))))
