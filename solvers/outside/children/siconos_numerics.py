"""Siconos in a process of its own, for solvers.outside.siconos: Debian builds it for the system's Python only.

It is told a problem once and asked to solve it as often as one likes; the clock is around the driver's call alone.
"""

from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from talk import Array, serve  # this folder, on the path of a child

told: dict[str, Any] = {}


def answer(**message: Any) -> dict[str, Any]:
    """Keep a problem, or solve the one that is kept."""
    if "solver" not in message:
        told.clear()
        told.update(message)
        told["problem"] = made(**message)
        return {}
    return solve(**message)


def made(kind: str, q: Array, **given: Any) -> Any:
    """Siconos' own problem object, dense but for the global form."""
    if kind == "lcp":
        return sn.LCP(given["M"], q)
    if kind == "global":
        problem = sn.GlobalFrictionContactProblem()
        problem.dimension, problem.numberOfContacts = 3, len(given["mu"])
        told["kept"] = problem.M, problem.H = compressed(given["M"]), compressed(given["H"])
        problem.q, problem.b, problem.mu = q, given["b"], given["mu"]
        return problem
    return sn.FrictionContactProblem(2 if kind == "friction_2d" else 3, len(given["mu"]), given["W"], q, given["mu"])


def compressed(matrix: Array) -> Any:
    """A matrix in Siconos' sparse storage; this Python may have no scipy."""
    kept = sn.NM_create(sn.NM_SPARSE, *matrix.shape)
    rows, columns = np.nonzero(matrix)
    sn.NM_triplet_alloc(kept, len(rows))
    for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
        sn.NM_entry(kept, i, j, float(matrix[i, j]))
    return kept


def solve(solver: str, tol: float, limit: int, start: Array) -> dict[str, Any]:
    """The driver's call from `start`, its code, count of iterations and seconds."""
    options = sn.SolverOptions(getattr(sn, f"SICONOS_{solver.upper()}"))
    options.dparam[sn.SICONOS_DPARAM_TOL] = tol
    options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = limit
    r, kind, problem = start.copy(), told["kind"], told["problem"]
    if kind == "lcp":
        arguments: tuple[Any, ...] = (problem, r, np.zeros(len(r)))
        driver = sn.linearComplementarity_driver
    elif kind == "global":
        arguments = (problem, r, np.zeros(len(r)), np.zeros(len(told["q"])))
        driver = sn.gfc3d_driver
    else:
        arguments = (problem, r, told["W"] @ r + told["q"])
        driver = sn.fc2d_driver if kind == "friction_2d" else sn.fc3d_driver
    begun = perf_counter()
    code = driver(*arguments, options)
    seconds = perf_counter() - begun
    iterations = int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE])
    return {"r": r, "code": int(code), "iterations": max(iterations, 0), "clock": seconds}


serve(answer)
