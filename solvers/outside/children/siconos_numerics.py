"""Siconos in a process of its own, for solvers.outside.siconos: Debian builds it for the system's Python only.

It is told a problem once and asked to solve it as often as one likes; the clock is around the driver's call alone.
"""

from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from talk import Array, serve  # this folder, on the path of a child

CALLS = 3  # of the driver at most: |r| grows little from one answer to the next
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


def solve(solver: str, eps: float, size: float, limit: int, start: Array) -> dict[str, Any]:
    """The driver's calls from `start`, the last one's code, the iterations and seconds of all.

    Siconos divides its error by |q| or, in friction problems, by |r| where that is larger, which is known only afterwards: it
    is then asked once more, from its own answer, for as much less. eps: the error before that division. size: |q|.
    """
    r, iterations, seconds = start.copy(), 0, 0.0
    for _ in range(CALLS):
        options = sn.SolverOptions(getattr(sn, f"SICONOS_{solver.upper()}"))
        options.dparam[sn.SICONOS_DPARAM_TOL] = eps / size
        options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = limit
        driver, arguments = call(r)
        begun = perf_counter()
        code = driver(*arguments, options)
        seconds += perf_counter() - begun
        iterations += max(int(options.iparam[sn.SICONOS_IPARAM_ITER_DONE]), 0)
        larger = float(np.linalg.norm(r))
        if code or told["kind"] == "lcp" or not larger > size:
            break
        size = 1.1 * larger
    return {"r": r, "code": int(code), "iterations": iterations, "clock": seconds}


def call(r: Array) -> tuple[Any, tuple[Any, ...]]:
    """The driver of the problem that is kept, and its arguments, r the guess and the answer."""
    kind, problem = told["kind"], told["problem"]
    if kind == "lcp":
        return sn.linearComplementarity_driver, (problem, r, np.zeros(len(r)))
    if kind == "global":
        return sn.gfc3d_driver, (problem, r, np.zeros(len(r)), np.zeros(len(told["q"])))
    return sn.fc2d_driver if kind == "friction_2d" else sn.fc3d_driver, (problem, r, told["W"] @ r + told["q"])


serve(answer)
