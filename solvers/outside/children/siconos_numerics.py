"""Siconos in a process of its own, for solvers.outside.siconos: Debian builds it for the system's Python only.

It receives a problem once and solves it on each request; the clock is around the call of the driver alone.
"""

from time import perf_counter
from typing import Any

import numpy as np
import siconos.numerics as sn
from messages import Array, serve  # this folder is on the path of the child

CALLS = 3  # of the driver at most: |r| grows little from one answer to the next
stored: dict[str, Any] = {}


def answer(**message: Any) -> dict[str, Any]:
    """Store a problem, or solve the stored one."""
    if "solver" not in message:
        stored.clear()
        stored.update(message)
        stored["problem"] = build_problem(**message)
        return {}
    return solve(**message)


def build_problem(kind: str, q: Array, **given: Any) -> Any:
    """Siconos' problem object, dense except in the global form."""
    if kind == "lcp":
        return sn.LCP(given["M"], q)
    if kind == "global":
        problem = sn.GlobalFrictionContactProblem()
        problem.dimension, problem.numberOfContacts = 3, len(given["mu"])
        stored["matrices"] = problem.M, problem.H = compressed(given["M"]), compressed(given["H"])
        problem.q, problem.b, problem.mu = q, given["b"], given["mu"]
        return problem
    return sn.FrictionContactProblem(2 if kind == "friction_2d" else 3, len(given["mu"]), given["W"], q, given["mu"])


def compressed(matrix: Array) -> Any:
    """A matrix in Siconos' sparse storage; this Python may have no scipy."""
    sparse_matrix = sn.NM_create(sn.NM_SPARSE, *matrix.shape)
    rows, columns = np.nonzero(matrix)
    sn.NM_triplet_alloc(sparse_matrix, len(rows))
    for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
        sn.NM_entry(sparse_matrix, i, j, float(matrix[i, j]))
    return sparse_matrix


def solve(solver: str, eps: float, size: float, limit: int, start: Array) -> dict[str, Any]:
    """Call the driver from `start`: the answer, the return code of the last call, the iterations and seconds of all calls.

    Siconos divides its error by |q| or, in friction problems, by |r| if that is larger, which is known only afterwards: the
    driver is then called again from its own answer with a smaller tolerance. eps: the error before that division. size: |q|.
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
        if code or stored["kind"] == "lcp" or not larger > size:
            break
        size = 1.1 * larger
    return {"r": r, "code": int(code), "iterations": iterations, "clock": seconds}


def call(r: Array) -> tuple[Any, tuple[Any, ...]]:
    """The driver of the stored problem and its arguments; r is the guess and is overwritten by the answer."""
    kind, problem = stored["kind"], stored["problem"]
    if kind == "lcp":
        return sn.linearComplementarity_driver, (problem, r, np.zeros(len(r)))
    if kind == "global":
        return sn.gfc3d_driver, (problem, r, np.zeros(len(r)), np.zeros(len(stored["q"])))
    return sn.fc2d_driver if kind == "friction_2d" else sn.fc3d_driver, (problem, r, stored["W"] @ r + stored["q"])


serve(answer)
